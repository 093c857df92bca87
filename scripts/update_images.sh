#!/usr/bin/env bash
# Makes the pictures in docs/images again: those of scripts/demo.sh without a display, smaller.
#   scripts/update_images.sh
set -euo pipefail
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH
unset DISPLAY   # the same picture everywhere: no window manager, no other screen

scripts/demo.sh
for name in rviz evaluation; do
  convert "runs/demo/$name.png" -resize 1000x -strip -dither None -colors 200 "PNG8:docs/images/$name.png"
done
identify -format '%d/%f %wx%h %b\n' docs/images/*.png
