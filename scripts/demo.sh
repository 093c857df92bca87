#!/usr/bin/env bash
# Shows the package at work: installs what is missing, builds, plays a recorded run through slam_node under
# roslaunch, compares path and map with the truth, and leaves pictures. Needs no display; opens RViz where there
# is one.
#   scripts/demo.sh [--bag FILE] [--rate TIMES_REAL_TIME] [--out DIR]
set -euo pipefail
here=$PWD
cd "$(dirname "$0")/.."
export PATH=/usr/bin:$PATH

bag=bags/room.bag rate=4 out=runs/demo
while [ $# -gt 0 ]; do
  case $1 in
    --bag) bag=$(cd "$here" && realpath -m -- "${2:?--bag: a file must follow}"); shift 2 ;;
    --rate) rate=${2:?--rate: a number must follow}; shift 2 ;;
    --out) out=$(cd "$here" && realpath -m -- "${2:?--out: a folder must follow}"); shift 2 ;;
    -h|--help) sed -n '2,5s/^# \?//p' "$0"; exit 0 ;;
    *) echo "demo.sh: $1: unknown option; see --help" >&2; exit 2 ;;
  esac
done
say() { printf '== %s\n' "$*"; }
fail() { echo "demo.sh: $*" >&2; exit 1; }
[[ $rate =~ ^[0-9]*\.?[0-9]+$ ]] || { echo "demo.sh: --rate: '$rate' given, allowed: a number above 0" >&2; exit 2; }
[ -r "$bag" ] || { echo "demo.sh: $bag: cannot be read" >&2; exit 2; }

say "Building"
scripts/build.sh | sed -u '/Built target/d'
mkdir -p "$out"
out=$(realpath "$out")
rm -rf "$out/log" "$out"/{rviz,evaluation}.png "$out"/{summary,evaluation}.json "$out"/{report.html,demo_map.yaml}

# Everything that this script starts ends with it.
launch='' screen=''
running() { kill -0 "$1" 2>/dev/null; }
stop() { if [ -n "$1" ] && running "$1"; then kill -TERM "$1"; wait "$1" || true; fi; }
clean_up() { stop "$launch"; stop "$screen"; }
trap clean_up EXIT
trap 'exit 130' INT TERM

# A master of its own on a free port, and its logs beside the results.
port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
export ROS_MASTER_URI=http://127.0.0.1:$port ROS_HOSTNAME=127.0.0.1 ROS_LOG_DIR=$out/log
unset ROS_IP ROS_NAMESPACE
mkdir -p "$out/log"

rviz="RViz opens"
if ! { [ -n "${DISPLAY:-}" ] && xdpyinfo; } >/dev/null 2>&1; then
  rviz="RViz draws without a display"
  exec 3<> <(:)   # a pipe: the server tells which number it has found free
  Xvfb -displayfd 3 -screen 0 1120x960x24 -nolisten tcp >/dev/null 2>&1 &
  screen=$!
  read -r -t 10 -u 3 number || fail "Xvfb did not start"
  export DISPLAY=:$number LIBGL_ALWAYS_SOFTWARE=1
fi

say "Playing $bag through slam_node at $rate times real time; $rviz"
build/devel/env.sh roslaunch -p "$port" launch/replay.launch bag:="$(realpath "$bag")" rate:="$rate" delay:=4 \
  rviz:=true map_dir:="$out" >"$out/log/roslaunch.txt" 2>&1 &
launch=$!
until (: >"/dev/tcp/127.0.0.1/$port") 2>/dev/null; do
  running "$launch" || fail "roslaunch ended; see $out/log/roslaunch.txt"
  sleep 0.2
done
build/devel/env.sh python3 scripts/record_run.py "$out" --until-end-of /player --progress 5 ||
  fail "the run failed; see $out/log/roslaunch.txt"

# RViz may come late on a slow machine: its window, with something drawn in it.
window() { xwininfo -root -tree | sed -n 's/^ *\(0x[0-9a-f]*\) "[^"]* - RViz".*/\1/p' | head -n 1; }
drawn() { [ -e "$out/rviz.png" ] && [ "$(identify -format %k "$out/rviz.png")" -gt 500 ]; }
for _ in $(seq 30); do
  running "$launch" || fail "roslaunch ended; see $out/log/roslaunch.txt"
  id=$(window)
  [ -z "$id" ] || import -silent -window "$id" "$out/rviz.png" || true
  drawn && break
  sleep 1
done
drawn || echo "demo.sh: no picture of RViz: its window did not come" >&2

build/devel/env.sh rosservice call /slam_node/save_map demo_map.yaml >"$out/log/save_map.txt"

say "Comparing with the truth"
build/devel/env.sh python3 scripts/evaluate.py "$out" --truth "$bag" --report --title "Demonstration: $(basename "$bag")"

say "Result"
python3 - "$out" <<'END'
import json, os, sys

out = sys.argv[1]
result = json.load(open(os.path.join(out, "evaluation.json")))
metres = {name: "unknown" if value is None else f"{value:.3f} m" for name, value in result.items() if name.endswith("_m")}
if result["landmarks_true"] is not None:
    print(f"{result['landmarks_true'] - result['landmarks_missed']} of {result['landmarks_true']} landmarks, "
          f"{result['landmarks_spurious']} that are none; {metres['landmark_rmse_m']} off (RMSE), "
          f"{metres['landmark_max_m']} at most")
print(f"path {metres['ate_rmse_m']} off (RMSE); by the wheels alone {metres['dead_reckoning_ate_rmse_m']}")
for name, meaning in (("rviz.png", "what RViz showed at the end"),
                      ("evaluation.png", "path, map and errors against the truth"),
                      ("report.html", "all of it as a page: figures, map, parameters, warnings"),
                      ("evaluation.json", "the figures of the table"),
                      ("demo_map.yaml", "the map, as slam_node saves and loads it"),
                      ("trajectory.tum", "the path; beside it covariances, landmarks and associations"),
                      ("log/roslaunch.txt", "what the nodes said")):
    path = os.path.join(out, name)
    if os.path.exists(path):
        print(f"  {os.path.relpath(path):<28} {meaning}")
END

if [ -z "$screen" ] && [ -t 0 ]; then
  read -r -p "RViz stays open; Enter ends it. "
fi
