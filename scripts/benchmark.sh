#!/usr/bin/env bash
# Measures time per update, association, insertion and memory over the number of landmarks, and prints tables.
#   scripts/benchmark.sh [--quick] [--mrpt] [--callgrind | --node]
#     --quick      leaves out what takes minutes: the largest maps of compressed EKF and MRPT
#     --mrpt       installs MRPT (libmrpt-dev), beside which ours is measured where it is there
#     --callgrind  counts instructions with valgrind instead: no clock, the same figures on a busy machine
#     --node       plays bags/room.bag to slam_node instead: how soon it answers, and what it costs; with recorded data
#                  in SLAM_DATA also how long slam_replay takes for a run of MRCLAM
# Leaves runs/benchmark/benchmark.json and benchmark.png. Times are those of the thread on its core.
set -euo pipefail
quick=false mrpt=false callgrind=false node=false
for option in "$@"; do
  case $option in
    --quick) quick=true ;;
    --mrpt) mrpt=true ;;
    --callgrind) callgrind=true ;;
    --node) node=true ;;
    -h|--help) sed -n '2,9s/^# \?//p' "$0"; exit 0 ;;
    *) echo "benchmark.sh: $option: unknown option; see --help" >&2; exit 2 ;;
  esac
done
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH
out=runs/benchmark
mkdir -p build "$out"

if $mrpt && [ "$(dpkg-query -W -f='${db:Status-Status}' libmrpt-dev 2>/dev/null)" != installed ]; then
  echo "Installing libmrpt-dev ..." >&2
  as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }
  { as_root apt-get update && as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y --no-install-recommends libmrpt-dev; } >"$out/install.log" 2>&1 ||
    { tail -n 20 "$out/install.log" >&2; exit 2; }
fi
echo "Building (the log is in build/build.log) ..." >&2
scripts/build.sh >build/build.log 2>&1 || { tail -n 20 build/build.log >&2; exit 2; }
program=$(find build -name benchmark_slam -type f -perm -u+x | head -n 1)
if [ -z "$program" ]; then
  echo "benchmark.sh: Google Benchmark was not found; install libbenchmark-dev and call again" >&2
  exit 2
fi

if $node; then
  # A master of its own on a free port; everything that this script starts ends with it.
  port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
  export ROS_MASTER_URI=http://127.0.0.1:$port ROS_HOSTNAME=127.0.0.1 ROS_LOG_DIR=$PWD/$out/log
  started=()
  trap 'kill "${started[@]}" 2>/dev/null; wait' EXIT
  build/devel/env.sh rosmaster --core -p "$port" >"$out/rosmaster.log" 2>&1 &
  started+=($!)
  until (: >"/dev/tcp/127.0.0.1/$port") 2>/dev/null; do sleep 0.1; done
  build/devel/env.sh rosparam load config/slam.yaml /slam_node
  # Before all else that the machine does, where that is allowed: its other load is not the node's.
  first=(chrt -r 20)
  "${first[@]}" true 2>/dev/null || first=()
  "${first[@]}" "$(find build -name slam_node -type f -perm -u+x | head -n 1)" >"$out/slam_node.log" 2>&1 &
  started+=($!)
  echo "Playing bags/room.bag to slam_node (a minute or two) ..." >&2
  "${first[@]}" "$(find build -name benchmark_node -type f -perm -u+x | head -n 1)" bags/room.bag $!
  if [ -d "${SLAM_DATA:-}/mrclam6" ]; then
    build/devel/env.sh scripts/mrclam_to_bag.py "$SLAM_DATA/mrclam6" 1 "$out/mrclam6_1.bag" >"$out/bag.log"
    TIMEFORMAT="slam_replay of robot 1 of MRCLAM 6: %R s, with reading the bag and writing the results"
    { time build/devel/lib/kinect_ekf_slam/slam_replay "$out/mrclam6_1.bag" --config config/mrclam.yaml --out "$out/mrclam6_1" >"$out/replay.log"; } 2>&1
  fi
  exit
fi

if $callgrind; then
  command -v valgrind >/dev/null || { echo "benchmark.sh: no valgrind here; install it and call again" >&2; exit 2; }
  echo "instructions of an observation, 8 landmarks in view"
  for benchmark in update/{ekf,invariant_ekf,ukf}/{100,200} update/compressed_ekf/{100,500}; do
    # The program runs the same steps with and without the clock; those of observe() are counted.
    valgrind --tool=callgrind --callgrind-out-file=/dev/null --collect-atstart=no --toggle-collect='*::observe(*' \
      "$program" --benchmark_filter="^$benchmark/" >"$out/callgrind.log" 2>&1
    awk -v name="$benchmark" '/Collected :/ { collected = $NF } /iterations:/ { split($0, part, "iterations:"); steps = part[2] + 1 }
      END { printf "  %-28s %12.0f\n", name, collected / steps }' "$out/callgrind.log"
  done
  exit 0
fi

filter=.
if $quick; then filter='-(mrpt_.*/2000|mrpt_full/1000|compressed_ekf/(5000|10000)|insert/mrpt)'; fi
"$program" --benchmark_filter="$filter" --benchmark_out="$out/benchmark.json" --benchmark_out_format=json >"$out/benchmark.log" &
process=$!
while kill -0 $process 2>/dev/null; do
  if [ -t 2 ]; then printf '\rmeasuring: %d done ' "$(grep -c iterations "$out/benchmark.log")" >&2; fi
  sleep 1
done
wait $process
if [ -t 2 ]; then printf '\r\033[K' >&2; fi
# The EKF once more without the processor's wide vectors, to tell what they bring.
KINECT_EKF_SLAM_WIDE=0 "$program" --benchmark_filter='^update/ekf/' --benchmark_out="$out/narrow.json" --benchmark_out_format=json >"$out/narrow.log"
scripts/plot_benchmark.py "$out/benchmark.json" "$out/benchmark.png" --narrow "$out/narrow.json"
