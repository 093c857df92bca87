#!/usr/bin/env bash
# Makes the recorded runs anew and compares them byte by byte with those in bags/.
#   bags_are_reproducible.sh SLAM_SIMULATE SOURCE_FOLDER
# Exit: 0 the same, 1 not, 77 skipped: another standard library draws other random numbers.
set -euo pipefail
simulate=$1
cd "$2"

platform=$(. /etc/os-release && echo "$ID ${VERSION_ID:-} $(uname -m)")
if [ "$platform" != "debian 12 x86_64" ]; then
  echo "skipped: $platform, the bags were made on debian 12 x86_64"
  exit 77
fi
made=$(mktemp -d)
trap 'rm -rf "$made"' EXIT
for run in room room_hard; do
  "$simulate" --world config/worlds/$run.yaml --seed 1 --out "$made/$run.bag"
  cmp "$made/$run.bag" bags/$run.bag
  grep -q "$(sha256sum <bags/$run.bag | cut -d' ' -f1)" bags/README.md || {
    echo "bags/README.md does not have the checksum of $run.bag"; exit 1; }
done
