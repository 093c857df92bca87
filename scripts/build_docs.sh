#!/usr/bin/env bash
# Builds the documentation as pages in build/docs/html: README.md, docs/*.md and the public headers. A warning is an error.
#   scripts/build_docs.sh     needs doxygen; formulas are drawn by MathJax when a page is looked at
set -euo pipefail
case ${1:-} in
  '') ;;
  -h|--help) sed -n '2,3s/^# \?//p' "$0"; exit 0 ;;
  *) echo "build_docs.sh: $1: unknown option; see --help" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH
if ! command -v doxygen >/dev/null; then
  echo "build_docs.sh: doxygen is not installed; scripts/install_dependencies.sh installs it" >&2
  exit 2
fi
scripts/check_links.py
mkdir -p build/docs
# MathJax from Debian's libjs-mathjax where it is installed, else from the network.
local=/usr/share/javascript/mathjax
{ cat docs/Doxyfile; [ ! -d $local ] || echo "MATHJAX_RELPATH = file://$local"; } | doxygen -
echo "build/docs/html/index.html"
