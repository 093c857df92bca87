#!/usr/bin/env bash
# Builds what scripts/faults.py runs with sanitizers, each in a build folder of its own:
#   scripts/build_sanitized.sh address    fuzz_slam, fuzz_perception and slam_replay with AddressSanitizer and UndefinedBehaviorSanitizer, in build/address
#   scripts/build_sanitized.sh thread     slam_node and roscpp_alone with ThreadSanitizer, in build/thread
# scripts/build.sh comes first: it installs what is needed. Neither is part of the tests' build: each takes a quarter of an hour.
set -euo pipefail
case ${1:-} in
  address) flags="-fsanitize=address,undefined -fno-sanitize=vptr -fno-sanitize-recover=undefined" targets="fuzz_slam fuzz_perception slam_replay" ;;
  thread) flags="-fsanitize=thread" targets="slam_node roscpp_alone" ;;
  -h|--help) sed -n '2,5s/^# \?//p' "$0"; exit 0 ;;
  *) echo "build_sanitized.sh: '${1:-}' given, allowed: address, thread" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH   # catkin needs the system's Python
unset PYTHONHOME PYTHONPATH CMAKE_PREFIX_PATH_OVERRIDE

folder=build/$1
mkdir -p "$folder"
cmake -S . -B "$folder" -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS="-O1 -g1 -fno-omit-frame-pointer $flags" \
  -DPYTHON_EXECUTABLE=/usr/bin/python3 >"$folder/configure.log" 2>&1 || { cat "$folder/configure.log" >&2; exit 2; }
# shellcheck disable=SC2086
cmake --build "$folder" -j"${JOBS:-2}" --target $targets
