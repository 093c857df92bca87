#!/usr/bin/env bash
# Installs the build into a folder of its own and uses it from there, as other people's packages and robots do.
#   install_space.sh SOURCE BUILD      BUILD is built already; its CMAKE_INSTALL_PREFIX is emptied first and must lie in it
set -euo pipefail
source=$1
build=$2
export PATH=/usr/bin:$PATH
unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH LD_LIBRARY_PATH PYTHONPATH PKG_CONFIG_PATH   # the build's environment is not to help
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix=$(sed -n 's/^CMAKE_INSTALL_PREFIX:PATH=//p' "$build/CMakeCache.txt")
case $prefix in "$build"/?*) rm -rf "$prefix" ;; *) echo "install_space: skipped, $prefix is not in $build"; exit 77 ;; esac
say() { echo "install_space: $*"; }
# expect WHAT PATTERN COMMAND...: the command succeeds and says the pattern
expect() {
  local what=$1 pattern=$2; shift 2
  if ! "$@" >"$work/log" 2>&1 || ! grep -qE "$pattern" "$work/log"; then
    say "FAILED $what: expected '$pattern' of: $*"; tail -n 20 "$work/log"; exit 1
  fi
  say "ok $what"
}

expect "install" "Installing" cmake --install "$build"
# Programs and libraries may name sources, for their log lines, but not be looked for or look for others there.
leads_back() {
  grep -rlI --exclude="*.pyc" -e "$build/devel" -e "$build/layers" -e "$source/include" -e "$source/src" "$prefix"
  find "$prefix" -name "*.so" -o -path "*/lib/kinect_ekf_slam/*" -type f | while read -r file; do
    readelf -d "$file" 2>/dev/null | grep -E "R(UN)?PATH" | grep -qF "$build" && echo "$file"
  done
}
back=$(leads_back || true)
if [ -n "$back" ]; then say "FAILED: these installed files lead back to the checkout or the build: "$back; exit 1; fi

say "what is in the checkout and is to be installed"
for folder in bags config launch rviz msg srv; do
  diff -r "$source/$folder" "$prefix/share/kinect_ekf_slam/$folder"
done
diff -r "$source/include/kinect_ekf_slam" "$prefix/include/kinect_ekf_slam" | grep -v "^Only in $prefix" && exit 1

run=("$prefix/env.sh")
expect "rospack" "^$prefix/share/kinect_ekf_slam$" "${run[@]}" rospack find kinect_ekf_slam
expect "rosmsg" "float64\[9\] covariance" "${run[@]}" rosmsg show kinect_ekf_slam/LandmarkDetection
expect "a program" "10 landmarks" "${run[@]}" rosrun kinect_ekf_slam slam_replay \
  "$prefix/share/kinect_ekf_slam/bags/room.bag" --out "$work/run"
expect "a script" "landmarks" "${run[@]}" rosrun kinect_ekf_slam evaluate.py "$work/run" \
  --truth "$prefix/share/kinect_ekf_slam/bags/room.bag"
port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("", 0)); print(s.getsockname()[1])')
expect "roslaunch" "map saved to $work/demo.yaml" env ROS_MASTER_URI="http://localhost:$port" ROS_LOG_DIR="$work" \
  "${run[@]}" roslaunch -p "$port" kinect_ekf_slam simulation.launch rate:=20 duration:=20 \
  save_map:=true map_dir:="$work" map_file:=demo.yaml

say "another catkin package"
expect "configure" "Generating done" "${run[@]}" cmake -S "$source/test/install/consumer" -B "$work/consumer" \
  -DPYTHON_EXECUTABLE=/usr/bin/python3
expect "build" "Built target consumer" cmake --build "$work/consumer"
expect "run" "1 landmark, at \(1.5, 0.2\) m; a fiducial has 6 rows" "$work/consumer/devel/lib/kinect_ekf_slam_consumer/consumer"

say "plain CMake, without ROS"
expect "configure" "Generating done" cmake -S "$source/examples" -B "$work/example" -DCMAKE_PREFIX_PATH="$prefix"
expect "build" "Built target ekf_slam" cmake --build "$work/example"
expect "run" "robot: 0.0[0-9] m off" "$work/example/ekf_slam"
if ldd "$work/example/ekf_slam" | grep -E "ros|opencv|yaml|boost"; then say "FAILED: the core needs more than Eigen"; exit 1; fi
expect "the core alone is configured" "Generating done" cmake -S "$source" -B "$work/core" -Dkinect_ekf_slam_CORE_ONLY=ON \
  -DCMAKE_DISABLE_FIND_PACKAGE_catkin=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenCV=ON -DCMAKE_DISABLE_FIND_PACKAGE_yaml-cpp=ON
expect "the core alone is built" "Built target kinect_ekf_slam_core" cmake --build "$work/core" --target kinect_ekf_slam_core
