#!/usr/bin/env bash
# Makes the pictures of docs/detectors.md again, from simulated views.
#   scripts/update_detector_images.sh      (after scripts/build.sh)
set -euo pipefail
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for seed in 1 9; do
  build/devel/env.sh detector_study cylinders --seed "$seed" --picture "$folder/$seed.png"
done
convert "$folder/1.png" "$folder/9.png" +append -strip -dither None -colors 128 PNG8:docs/images/kinect_cylinder.png
build/devel/env.sh detector_study features --views 80 --picture "$folder/features.png"
convert "$folder/features.png" -strip -dither None -colors 64 PNG8:docs/images/features.png
identify -format '%d/%f %wx%h %b\n' docs/images/kinect_cylinder.png docs/images/features.png
