#!/usr/bin/env bash
# Installs what the package needs to build, run and test, and nothing when it is already there.
# Debian: the distribution's own ROS 1 packages. Elsewhere: rosdep, if a ROS apt source is set up.
set -euo pipefail
case ${1:-} in
  '') ;;
  -h|--help) sed -n '2,3s/^# \?//p' "$0"; exit 0 ;;
  *) echo "install_dependencies.sh: $1: unknown option; see --help" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH DEBIAN_FRONTEND=noninteractive

packages=(
  # build tools
  build-essential git cmake clang-format clang-tidy catkin catkin-lint doxygen graphviz
  # core
  libeigen3-dev libyaml-cpp-dev
  # the batch optimum
  libceres-dev
  # perception
  libopencv-dev libcv-bridge-dev libimage-transport-dev libimage-geometry-dev
  # ROS 1 libraries and messages
  libroscpp-dev libmessage-filters-dev libtf2-dev libtf2-ros-dev librosbag-dev librosbag-storage-dev
  libdiagnostic-updater-dev libdynamic-reconfigure-config-init-mutex-dev
  ros-message-generation ros-message-runtime libstd-msgs-dev libgeometry-msgs-dev libnav-msgs-dev
  libsensor-msgs-dev libstereo-msgs-dev libstd-srvs-dev libvisualization-msgs-dev libdiagnostic-msgs-dev libtf2-msgs-dev
  ros-std-msgs ros-geometry-msgs ros-nav-msgs ros-sensor-msgs ros-stereo-msgs ros-std-srvs ros-visualization-msgs
  ros-diagnostic-msgs ros-tf2-msgs ros-rosgraph-msgs rospack-tools python3-genpy python3-genmsg python3-gencpp
  # ROS 1 tools and Python
  rosbash python3-roslaunch python3-rosbag python3-rosnode python3-rostopic python3-rosservice
  python3-rosparam python3-rospy python3-tf2-ros python3-dynamic-reconfigure python3-std-msgs
  python3-geometry-msgs python3-nav-msgs python3-sensor-msgs python3-stereo-msgs python3-std-srvs python3-visualization-msgs
  python3-diagnostic-msgs python3-tf2-msgs python3-rosgraph-msgs
  python3-numpy python3-matplotlib python3-pil python3-yaml python3-jinja2
  # launch files, pictures and the demo
  tf2-tools rviz xvfb xauth x11-utils libgl1-mesa-dri libgl1 imagemagick fonts-dejavu-core
  # tests and benchmarks
  libbenchmark-dev libgtest-dev librostest-dev python3-rostest python3-rosunit
)

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

if [ -n "${ROS_DISTRO:-}" ] && command -v rosdep >/dev/null; then
  exec rosdep install --from-paths . --ignore-src -y
fi
if ! command -v apt-get >/dev/null; then
  echo "install_dependencies.sh: no apt-get here; install by hand: ${packages[*]}" >&2
  exit 2
fi
missing=()
for package in "${packages[@]}"; do
  [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0
echo "Installing ${#missing[@]} Debian packages (once, about 2 minutes on a fresh machine) ..."
log=$(mktemp)
if ! { as_root apt-get update && as_root apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
  tail -n 20 "$log" >&2
  echo "install_dependencies.sh: apt-get failed; the whole log is in $log" >&2
  exit 2
fi
rm -f "$log"
