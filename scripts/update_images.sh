#!/usr/bin/env bash
# Makes the pictures in docs/images again: those of scripts/demo.sh without a display, smaller, those of the
# consistency, global and robustness studies, of a global map, and of the architecture.
#   scripts/update_images.sh
set -euo pipefail
case ${1:-} in
  '') ;;
  -h|--help) sed -n '2,3s/^# \?//p' "$0"; exit 0 ;;
  *) echo "update_images.sh: $1: unknown option; see --help" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH
unset DISPLAY   # the same picture everywhere: no window manager, no other screen

scripts/demo.sh
for name in rviz evaluation; do
  convert "runs/demo/$name.png" -resize 1000x -strip -dither None -colors 200 "PNG8:docs/images/$name.png"
done
for study in consistency global robustness; do
  build/devel/env.sh slam_study "$study" --json "runs/$study.json"
  build/devel/env.sh python3 "scripts/plot_$study.py" "runs/$study.json" "runs/$study.png"
  convert "runs/$study.png" -resize 1000x -strip -dither None -colors 200 "PNG8:docs/images/$study.png"
done
build/devel/env.sh slam_simulate --world config/worlds/yard.yaml --out runs/yard.bag
build/devel/env.sh slam_replay runs/yard.bag --out runs/yard --global
build/devel/env.sh python3 scripts/evaluate.py runs/yard/global --truth runs/yard.bag --align none
convert runs/yard/global/evaluation.png -resize 1000x -strip -dither None -colors 200 PNG8:docs/images/global_map.png
dot -Tpng -Gdpi=80 docs/images/architecture.dot -o docs/images/architecture.png   # Graphviz
identify -format '%d/%f %wx%h %b\n' docs/images/*.png
