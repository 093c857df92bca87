#!/usr/bin/python3
"""Draws one run of what `slam_study global --json FILE` wrote: each sensor alone, the global map, and NEES over time.

  scripts/plot_global.py FILE.json PICTURE.png
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

import numpy as np

from slam_tools import cli
from slam_tools.plots import BOUNDS_COLOR, DEAD_RECKONING_COLOR, LANDMARK_COLOR, STYLE, TRUTH_COLOR, plt
from slam_tools.studies import draw_study

SEGMENT_COLORS = ("#0072b2", "#cc3399", "#009e73", "#e69f00", "#56b4e9", "#8c564b")


def draw_alone(panel, example):
    slam, fixes = np.array(example["slam"]), np.array(example["global_positions"])
    panel.plot(slam[:, 0], slam[:, 1], color=DEAD_RECKONING_COLOR, linewidth=1, label="SLAM alone, start known")
    panel.plot(fixes[:, 0], fixes[:, 1], ".", color="#56b4e9", markersize=3, label="fixes of the buoys")
    panel.set_title("Each sensor alone")


def draw_map(panel, example):
    for number, segment in enumerate(example["segments"]):
        path = np.array(segment)
        if len(path):
            panel.plot(path[:, 0], path[:, 1], color=SEGMENT_COLORS[number % len(SEGMENT_COLORS)], linewidth=1.4)
    landmarks, truth = np.array(example["landmarks"]), np.array(example["true_landmarks"])
    panel.plot(truth[:, 0], truth[:, 1], "o", color=TRUTH_COLOR, markersize=6, fillstyle="none", linewidth=0.6,
               label="true landmarks")
    panel.plot(landmarks[:, 0], landmarks[:, 1], "x", color=LANDMARK_COLOR, markersize=4, label="landmarks")
    panel.set_title("Global map, a color a segment")


def draw(results, path):
    example = results["example"]
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(10, 7))
        grid = figure.add_gridspec(2, 2, height_ratios=(2.2, 1))
        truth = np.array(example["truth"])
        for column, draw_panel in enumerate((draw_alone, draw_map)):
            panel = figure.add_subplot(grid[0, column])
            panel.plot(truth[:, 0], truth[:, 1], color=TRUTH_COLOR, linewidth=0.6, label="truth")
            draw_panel(panel, example)
            panel.set_aspect("equal")
            panel.set_xlabel("x (m)")
            panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncol=3)
        figure.axes[0].set_ylabel("y (m)")
        panel = figure.add_subplot(grid[1, :])
        nees = np.array(results["path_nees_over_time"])
        panel.axhspan(*results["nees_bounds"], color=BOUNDS_COLOR, alpha=0.25, linewidth=0)
        panel.plot(np.arange(1, len(nees) + 1), nees, color=SEGMENT_COLORS[0], linewidth=0.9)
        panel.set_ylim(bottom=0)
        panel.set_xlabel("time (s)")
        panel.set_ylabel("NEES of the position, mean of\nthe runs (green: 95 % if consistent)")
        panel.set_title(f"{len(results['runs'])} runs: path {results['path_rmse_m']:.3f} m, "
                        f"SLAM alone {results['slam_path_rmse_m']:.2f} m, "
                        f"buoys alone {results['beacon_path_rmse_m']:.3f} m")
        figure.tight_layout()
        figure.savefig(path, format="png", dpi=110)
        plt.close(figure)


def main():
    draw_study("global", __doc__, draw)


if __name__ == "__main__":
    cli.run(main)
