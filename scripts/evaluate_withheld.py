#!/usr/bin/python3
"""How far a robot gets without GPS: the Husky's recording, whose GPS is withheld for stretches of a minute, one a run.

Odometry, gyro and GPS are fused by `slam_replay`; at the end of each stretch the estimate is compared with the GPS that
was withheld, beside dead reckoning: the same odometry and gyro, never corrected after the map was placed in the frame of
the GPS; and that, laid afterwards on the whole track as well as it can be. The recording is not part of the package:
--data, else the environment variable SLAM_DATA, names the folder; without it there is nothing to do.
"""
import argparse
import os
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

import numpy as np

from slam_tools.runs import read_path
from slam_tools.tables import read_csv

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
POSITION_COLUMNS = ("t", "beacon", "verdict", "nis", "dof", "x", "y", "z")
LAST_S = 2.0   # s of fixes at the end of a stretch whose mean is compared: one fix alone is noise


def default_data():
    return os.environ.get("SLAM_DATA") or os.path.join(os.path.dirname(ROOT), "shared", "data")


def replay(bag, configs, directory, settings):
    slam_replay = os.path.join(ROOT, "build", "devel", "lib", "kinect_ekf_slam", "slam_replay")
    command = [slam_replay, bag, "--out", directory]
    for config in configs:
        command += ["--config", os.path.join(ROOT, "config", config)]
    for setting in settings:
        command += ["--set", setting]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def read_positions(directory):
    """Times, places in the map (n x 2) and verdicts of the positions in positions.csv that are in the map."""
    rows = read_csv(os.path.join(directory, "positions.csv"), POSITION_COLUMNS, ("t", "x", "y"))
    rows = [row for row in rows if np.isfinite(row["x"])]
    return (np.array([row["t"] for row in rows]), np.array([[row["x"], row["y"]] for row in rows]),
            np.array([row["verdict"] for row in rows]))


def at(directory, name, times):
    """Places (n x 2) of a path at these times."""
    stamps, places, _ = read_path(os.path.join(directory, name))
    return np.stack([np.interp(times, stamps, places[:, axis]) for axis in (0, 1)], axis=1)


def laid_on(path, track):
    """The path (n x 2), moved and turned onto the track by least squares."""
    centred, target = path - path.mean(axis=0), track - track.mean(axis=0)
    turn = np.arctan2(centred[:, 0] @ target[:, 1] - centred[:, 1] @ target[:, 0], np.sum(centred * target))
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return centred @ rotation.T + track.mean(axis=0)


def errors(directory, end):
    """m at the end of the stretch, of the fused estimate, of dead reckoning, and of that laid on the whole track."""
    times, places, verdicts = read_positions(directory)
    last = (verdicts == "withheld") & (times >= end - LAST_S)
    reckoned = at(directory, "dead_reckoning.tum", times)
    paths = (at(directory, "trajectory.tum", times), reckoned, laid_on(reckoned, places))
    return [float(np.linalg.norm((path - places)[last].mean(axis=0))) for path in paths]


def stretches(directory, length):
    """(from, to) in s after the run's start: one after the other, from when positions are used to the last one."""
    times, _, verdicts = read_positions(directory)
    start, _, _ = read_path(os.path.join(directory, "trajectory.tum"))
    first = times[verdicts == "used"][0] - start[0]
    count = int((times[-1] - start[0] - first) // length)
    return [(first + i * length, first + (i + 1) * length) for i in range(count)], start[0]


def evaluate(data, out, length, settings):
    bag = os.path.join(data, "bags", "husky_outdoor.bag")
    configs = ("husky.yaml", "husky_gps.yaml")
    whole = os.path.join(out, "whole")
    replay(bag, configs, whole, settings)
    rows = []
    spans, start = stretches(whole, length)
    for begin, end in spans:
        directory = os.path.join(out, f"withheld_{begin:.0f}_{end:.0f}")
        replay(bag, configs, directory, [*settings, f"fusion/withhold=[[{begin}, {end}]]"])
        rows.append((begin, end, *errors(directory, start + end)))
    return rows


def print_rows(rows, length):
    print(f"Husky, GPS withheld for {length:g} s, position error at the end of the stretch against the withheld GPS (m)")
    print("  withheld (s)      odometry, gyro and GPS   dead reckoning   dead reckoning laid on the whole track")
    for begin, end, fused, reckoned, laid in rows:
        print(f"  {begin:5.0f} to {end:5.0f} {fused:24.2f} {reckoned:16.2f} {laid:26.2f}")
    fused, reckoned, laid = (np.mean([row[i] for row in rows]) for i in (2, 3, 4))
    print(f"   mean          {fused:24.2f} {reckoned:16.2f} {laid:26.2f}")
    print(f"   to dead reckoning's {fused / reckoned:18.2f} (goal: <= 0.50)")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", default=default_data(),
                        help="folder of the recorded data (default: SLAM_DATA, else shared/data beside the package)")
    parser.add_argument("--out", default=os.path.join(ROOT, "runs", "withheld"), help="folder for results")
    parser.add_argument("--stretch", type=float, default=60.0, metavar="S", help="s that GPS is withheld")
    parser.add_argument("--set", nargs="+", default=[], metavar="group/key=value", dest="settings",
                        help="parameters to try, over the configurations")
    arguments = parser.parse_args()
    if not os.path.isdir(arguments.data):
        print(f"evaluate_withheld.py: skipped: no recorded data in {arguments.data} (set SLAM_DATA)")
        return 0
    os.makedirs(arguments.out, exist_ok=True)
    try:
        print_rows(evaluate(arguments.data, arguments.out, arguments.stretch, arguments.settings), arguments.stretch)
    except (OSError, IndexError, subprocess.CalledProcessError) as error:
        print(f"evaluate_withheld.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
