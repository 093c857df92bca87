#!/usr/bin/env bash
# Runs everything that can fail and ends with the line `N passed, N failed, N skipped`.
#   scripts/test.sh [--quick]     --quick leaves out clang-tidy (a minute, newest sources first)
# Recorded data by others are found through SLAM_DATA; without them their tests are skipped, visibly.
set -uo pipefail
quick=false
case ${1:-} in
  '') ;;
  --quick) quick=true ;;
  -h|--help) sed -n '2,4s/^# \?//p' "$0"; exit 0 ;;
  *) echo "test.sh: $1: unknown option; see --help" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH JOBS="${JOBS:-2}"

export SLAM_DATA="${SLAM_DATA:-$(cd .. && pwd)/shared/data}"
step() { printf '\n== %s (%d s)\n' "$1" "$SECONDS"; }

step "build"
mkdir -p build
{ scripts/build.sh && cmake --build build -j"$JOBS" --target tests; } 2>&1 | tee build/build.log |
  grep --line-buffered -E 'Built target .*(_core|_models|_association|_estimators|_mapping|_pipeline|_perception|_simulation|_study|_ros|test_.*)$|^Installing'
if [ "${PIPESTATUS[0]}" -ne 0 ]; then
  grep -E 'error|Error' build/build.log | head -n 20
  echo "0 passed, 1 failed, 0 skipped"
  exit 1
fi
rm -rf build/test_results

step "style and structure"
checks=(scripts/checks.sh)
$quick && checks+=(--quick)
build/devel/env.sh "${checks[@]}"

# The ROS tests wait for their nodes half of the time: the Python tests run in it.
step "unit, contract, replay, ROS and Python tests"
build/devel/env.sh /usr/bin/python3 test/support/run_python_tests.py test/python build/test_results/python.xml >build/python.log 2>&1 &
build/devel/env.sh ctest --test-dir build -j"$JOBS" --output-on-failure --output-junit test_results/ctest.xml >build/ctest.log 2>&1 || grep -E 'FAILED|Failed|\*\*\*|FAIL:|Error' build/ctest.log | sort -u | head -n 40
tail -n 12 build/ctest.log
wait
cat build/python.log

step "sum"
/usr/bin/python3 test/support/sum_results.py build/test_results
