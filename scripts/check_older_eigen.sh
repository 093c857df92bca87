#!/usr/bin/env bash
# Compiles the layers without ROS, syntax only, against the Eigen 3.3 that Debian's r-cran-rcppeigen carries (downloaded, not installed).
#   scripts/check_older_eigen.sh     minutes; exit 1 when something needs a newer Eigen
set -euo pipefail
case ${1:-} in
  '') ;;
  -h|--help) sed -n '2,3s/^# \?//p' "$0"; exit 0 ;;
  *) echo "check_older_eigen.sh: $1: unknown option; see --help" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
(cd "$work" && apt-get download r-cran-rcppeigen >/dev/null 2>&1 && dpkg -x ./*.deb .) || {
  echo "check_older_eigen.sh: r-cran-rcppeigen cannot be downloaded: apt-get update?" >&2; exit 2; }
eigen=$work/usr/lib/R/site-library/RcppEigen/include
echo "Eigen $(sed -nE 's/#define EIGEN_(WORLD|MAJOR|MINOR)_VERSION //p' "$eigen/Eigen/src/Core/util/Macros.h" | paste -sd.)"
ls src/{core,models,association,estimators,mapping,pipeline,simulation,perception,study}/*.cpp |
  xargs -P "${JOBS:-2}" -n 1 g++ -std=c++17 -fsyntax-only -w -Iinclude -isystem "$eigen" -isystem /usr/include/opencv4
echo "all compile"
