#!/usr/bin/env bash
# Builds the package in build/; afterwards `build/devel/env.sh COMMAND` runs any command with it found.
#   scripts/build.sh [CMAKE OPTION ...]     for example  scripts/build.sh -DCMAKE_CXX_FLAGS=-march=native
set -euo pipefail
case ${1:-} in -h|--help) sed -n '2,3s/^# \?//p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH   # catkin needs the system's Python
unset PYTHONHOME PYTHONPATH CMAKE_PREFIX_PATH_OVERRIDE

scripts/install_dependencies.sh
# On the reference platform a warning is an error; another compiler may have others.
strict=OFF
if [ "$(. /etc/os-release && echo "$ID ${VERSION_ID:-}")" = "debian 12" ]; then strict=ON; fi
mkdir -p build
cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DPYTHON_EXECUTABLE=/usr/bin/python3 \
  -Dkinect_ekf_slam_WARNINGS_AS_ERRORS=$strict "$@" >build/configure.log 2>&1 || { cat build/configure.log >&2; exit 2; }
cmake --build build -j"${JOBS:-2}"
