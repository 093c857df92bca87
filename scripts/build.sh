#!/usr/bin/env bash
# Builds the package in build/; afterwards `build/devel/env.sh COMMAND` runs any command with it found.
#   scripts/build.sh [CMAKE OPTION ...]     for example  scripts/build.sh -Dkinect_ekf_slam_WARNINGS_AS_ERRORS=ON
set -euo pipefail
case ${1:-} in -h|--help) sed -n '2,3s/^# \?//p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH   # catkin needs the system's Python
unset PYTHONHOME PYTHONPATH CMAKE_PREFIX_PATH_OVERRIDE

scripts/install_dependencies.sh
cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DPYTHON_EXECUTABLE=/usr/bin/python3 "$@" >build.log.tmp 2>&1 || {
  cat build.log.tmp >&2; rm -f build.log.tmp; exit 2; }
mv build.log.tmp build/configure.log
cmake --build build -j"${JOBS:-2}"
