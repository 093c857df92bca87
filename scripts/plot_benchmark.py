#!/usr/bin/python3
"""Prints what `benchmark_slam` wrote as tables, with ratios within the run, and draws it with its slopes.

  scripts/plot_benchmark.py FILE.json PICTURE.png [--narrow FILE.json]
"""
import argparse
import collections
import json
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

import matplotlib  # noqa: E402

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from slam_tools.plots import STYLE  # noqa: E402

LINES = {"limit/rank16": ("bare rank-16 update", "0.5", "--"), "limit/one_pass": ("one pass over half of P", "0.7", ":"),
         "update/ekf": ("EKF", "#0072b2", "-"), "update/invariant_ekf": ("right-invariant EKF", "#e69f00", "-"),
         "update/ukf": ("UKF", "#cc3399", "-"), "update/compressed_ekf": ("compressed EKF", "#009e73", "-"),
         "update/fastslam1": ("FastSLAM 1.0", "#56b4e9", "-"), "update/fastslam2": ("FastSLAM 2.0", "#999933", "-"),
         "update/mrpt_davison": ("MRPT, Davison", "#d55e00", "-."), "update/mrpt_full": ("MRPT, full", "#882255", "-.")}
SPATIAL = {"spatial/ekf": "EKF", "spatial/invariant_ekf": "right-invariant EKF", "spatial/mrpt_davison": "MRPT, Davison",
           "spatial/mrpt_full": "MRPT, full"}
STEEP_FROM = 100  # landmarks: growth is told from here on


def read(path):
    """{name: {landmarks: counters}} of a run, the better of two ways to the rank-16 update as `limit/rank16`."""
    with open(path, encoding="utf-8") as file:
        runs = json.load(file)["benchmarks"]
    series = collections.defaultdict(dict)
    for run in runs:
        if run.get("error_occurred"):
            sys.exit(f"plot_benchmark.py: {run['name']}: {run['error_message']}")
        group, name, landmarks = run["name"].split("/")[:3]
        series[f"{group}/{name}"][int(landmarks)] = run
    for landmarks, run in series["limit/rank16_eigen"].items():
        other = series["limit/rank16_blas"].get(landmarks, run)
        series["limit/rank16"][landmarks] = min(run, other, key=lambda each: each["median_ms"])
    return series


def growth(times):
    """The exponent of n in the time, from STEEP_FROM landmarks on; None: not measured."""
    points = [(n, time) for n, time in times.items() if n >= STEEP_FROM]
    if len(points) < 2:
        return None
    return np.polyfit(*np.log(np.array(points)).T, 1)[0]


def table(head, rows, form):
    width = max(len(name) for name, _, _ in rows)
    growing = any(slope is not None for _, _, slope in rows)
    print(" " * width + "".join(f"{n:>9}" for n in head) + ("   growth" if growing else ""))
    for name, cells, slope in rows:
        line = name.ljust(width) + "".join(f"{form.format(cells[n]) if n in cells else '':>9}" for n in head)
        print((line + (f"   n^{slope:.2f}" if slope is not None else "")).rstrip())


def print_spatial(series):
    medians = {name: {n: run["median_ms"] for n, run in series[name].items()} for name in SPATIAL if series[name]}
    head = sorted({n for times in medians.values() for n in times})
    if not head:
        return
    print("\nTime per update in space, the pose of six degrees of freedom and landmarks of three: median, ms")
    rows = [(SPATIAL[name], times, growth(times)) for name, times in medians.items()]
    beside = [medians[name] for name in ("spatial/mrpt_davison", "spatial/mrpt_full") if name in medians]
    if beside:
        fastest = {n: min(times[n] for times in beside) / medians["spatial/ekf"][n] for n in beside[0]}
        rows.append(("MRPT's faster method to EKF", fastest, None))
    table(head, rows, "{:.3g}")


def print_tables(series, narrow):
    medians = {name: {n: run["median_ms"] for n, run in sorted(series[name].items())} for name in LINES if series[name]}
    head = sorted({n for times in medians.values() for n in times})
    print(f"Time per update (predict and observe), 8 landmarks in view, by the number of landmarks: median, ms; growth from {STEEP_FROM} on")
    table(head, [(LINES[name][0], times, growth(times)) for name, times in medians.items()], "{:.3g}")
    ekf = medians["update/ekf"]

    def ratio(numerator, denominator):
        return {n: numerator[n] / denominator[n] for n in numerator if n in denominator}

    print("\nRatios within this run")
    rows = [("EKF to the bare update", ratio(ekf, medians["limit/rank16"]), None),
            ("EKF to one pass", ratio(ekf, medians["limit/one_pass"]), None)]
    faster = [medians[name] for name in ("update/mrpt_davison", "update/mrpt_full") if name in medians]
    if faster:
        fastest = {n: min(times[n] for times in faster if n in times) for n in faster[0]}
        rows += [("MRPT's faster method to EKF", ratio(fastest, ekf), None),
                 ("... to compressed EKF", ratio(fastest, medians["update/compressed_ekf"]), None)]
    if narrow:
        rows.append(("EKF without wide vectors to EKF", ratio({n: run["median_ms"] for n, run in narrow["update/ekf"].items()}, ekf), None))
    table(head, rows, "{:.3g}")

    print_spatial(series)

    print("\nCompressed EKF, single steps, ms")
    worst = series["update/compressed_ekf"]
    table(sorted(worst), [(title, {n: run[key] for n, run in worst.items()}, None) for title, key in
                          (("median", "median_ms"), ("99.9th percentile", "p999_ms"), ("worst", "max_ms"))], "{:.3g}")
    print("\nAssociation of 8 sightings without identity by nearest neighbour, ms")
    times = {title: {n: run["median_ms"] for n, run in sorted(series[f"associate/{name}"].items())}
             for title, name in (("EKF, whole map", "ekf"), ("compressed EKF, its region", "compressed_ekf"))}
    table(sorted({n for row in times.values() for n in row}), [(title, row, growth(row)) for title, row in times.items()], "{:.3g}")
    inserts = {name.split("/")[1]: run[2000]["median_ms"] / 1e3 for name, run in series.items()
               if name.startswith("insert/") and 2000 in run}
    if inserts:
        print("\nInsertion of 2,000 landmarks, 8 a view, s")
    for name, seconds in inserts.items():
        beside = f"   {seconds / inserts['ekf']:.0f} times the EKF's" if name.startswith("mrpt") else ""
        print(f"  {name:<16}{seconds:8.3g}{beside}")
    memory = {name.split("/")[1]: run[1000]["kB_per_landmark"] for name, run in series.items()
              if name.startswith("memory/") and 1000 in run}
    if memory:
        print("\nMemory at 1,000 landmarks, kB a landmark")
    for name, kilobytes in memory.items():
        print(f"  {name:<16}{kilobytes:8.3g}")


def draw(series, path):
    with plt.rc_context(STYLE):
        figure, panel = plt.subplots(figsize=(8, 6))
        for name, (title, color, line) in LINES.items():
            times = {n: run["median_ms"] for n, run in sorted(series[name].items())}
            if not times:
                continue
            slope = growth(times)
            label = title if slope is None else f"{title}: $n^{{{slope:.2f}}}$"
            panel.loglog(list(times), list(times.values()), line, color=color, marker="o", markersize=3, label=label)
        panel.set_xlabel("landmarks")
        panel.set_ylabel("time per update, median (ms)")
        panel.legend(fontsize=8)
        figure.tight_layout()
        figure.savefig(path, dpi=110)
        plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", help="what benchmark_slam --benchmark_out wrote")
    parser.add_argument("picture", help="PNG to write")
    parser.add_argument("--narrow", metavar="FILE", help="of the same program with KINECT_EKF_SLAM_WIDE=0, the EKF alone")
    arguments = parser.parse_args()
    try:
        series = read(arguments.results)
        print_tables(series, read(arguments.narrow) if arguments.narrow else None)
        draw(series, arguments.picture)
    except (OSError, ValueError, KeyError, TypeError) as error:
        print(f"plot_benchmark.py: {arguments.results}: not what benchmark_slam writes: {error!r}", file=sys.stderr)
        return 2
    print(f"\n{arguments.picture}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
