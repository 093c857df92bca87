#!/usr/bin/env bash
# Style and structure: clang-format, clang-tidy, catkin_lint, who may include what. Writes build/test_results/checks.xml.
#   build/devel/env.sh scripts/checks.sh [--quick|--all]
# clang-tidy has a minute, the sources that changed last first; --quick leaves it out, --all lets it see every source.
set -uo pipefail
case ${1:-} in
  ''|--quick|--all) ;;
  -h|--help) sed -n '2,4s/^# \?//p' "$0"; exit 0 ;;
  *) echo "checks.sh: $1: unknown option; see --help" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."
results=build/test_results/checks.xml
log=build/checks
mkdir -p "$(dirname "$results")" "$log"
cases=""

# check NAME COMMAND...: passes when the command exits with 0; shows its output when not.
check() {
  local name=$1; shift
  if "$@" >"$log/$name.log" 2>&1; then
    echo "ok      $name"
    cases+="<testcase classname='checks' name='$name'/>"
  else
    echo "FAILED  $name"
    { grep -E '(error|warning):' "$log/$name.log" || cat "$log/$name.log"; } | head -n 30
    cases+="<testcase classname='checks' name='$name'><failure message='see build/checks/$name.log'/></testcase>"
  fi
}

sources() { git ls-files -co --exclude-standard -- 'include/*.h' 'src/*.cpp' 'test/*.h' 'test/*.cpp' 'benchmark/*.h' 'benchmark/*.cpp' | while read -r f; do [ -e "$f" ] && echo "$f"; done; }

format() { sources | xargs clang-format --dry-run --Werror; }

# A checkout may have any name, tools for the checkout are not installed, and the build keeps includes in their order.
lint() { catkin_lint -W2 --strict --ignore package_path_name --ignore uninstalled_script --ignore unused_catkin_include_dirs . 2>&1 | grep -v "rosdep\|unknown dependencies" | tee /dev/stderr | { ! grep -q "error\|warning"; }; }

# The core has no ROS and no OpenCV, and Ceres in smoothing/ alone; the build itself keeps the folders in their order.
no_ros_below() {
  local ros='ros/|tf2|rosbag|message_filters|opencv2|[a-z_]+_msgs/|kinect_ekf_slam/[A-Z]'
  ! grep -nE "#include *[<\"]($ros|ceres/)" -r \
    include/kinect_ekf_slam/{core,models,association,estimators,mapping,fusion,pipeline,simulation,study} \
    src/{core,models,association,estimators,mapping,fusion,pipeline,simulation,study} &&
    ! grep -nE "#include *[<\"]($ros)" -r {include/kinect_ekf_slam,src}/smoothing
}

# What starts a shell could be made to start another program.
no_shell() {
  ! git grep -nE '\b(system|popen)\(|shell *= *True|os\.system' -- 'src/*' 'include/*' 'examples/*' 'scripts/*.py'
}

headers_stand_alone() {
  git ls-files 'include/*.h' | grep -v /ros/ | xargs -P "${JOBS:-2}" -I{} sh -c '
    echo "#include \"${1#include/}\"" | g++ -std=c++17 -fsyntax-only -x c++ -Iinclude -isystem /usr/include/eigen3 -isystem /usr/include/opencv4 - ||
      { echo "$1 does not compile alone"; exit 1; }' header {}
}

newest_first() {
  { git log --no-renames --format= --name-only -- 'src/*.cpp'; git ls-files 'src/*.cpp'; } |
    awk '!seen[$0]++ && system("test -e " $0) == 0'
}

# tidy SECONDS: half a minute of work for a source, most of it for the headers of Eigen and ROS.
tidy() {
  newest_first | UNTIL=$(($(date +%s) + $1)) xargs -P "${JOBS:-2}" -I{} \
    sh -c '[ "$(date +%s)" -ge "$UNTIL" ] || { clang-tidy --quiet -p build "$1" && echo "fine: $1"; }' tidy {}
}

check clang_format format
check catkin_lint lint
check layers_know_no_ros no_ros_below
check no_shell no_shell
check headers_stand_alone headers_stand_alone
check docs scripts/build_docs.sh   # links, anchors, and what Doxygen warns of
check readme_parameters scripts/update_readme.py --check
if [ "${1:-}" != --quick ]; then
  seconds=60
  [ "${1:-}" = --all ] && seconds=86400
  check clang_tidy tidy "$seconds"
  echo "        clang_tidy saw $(grep -c '^fine: ' "$log/clang_tidy.log") of $(newest_first | wc -l) sources without a finding"
fi
echo "<testsuite name='checks'>$cases</testsuite>" >"$results"
