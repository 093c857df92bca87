#!/usr/bin/python3
"""Draws what `slam_study consistency --json FILE` wrote: NEES over time with its bounds, errors with 3-sigma bands.

  scripts/plot_consistency.py FILE.json PICTURE.png
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

import numpy as np

from slam_tools import cli
from slam_tools.plots import BOUNDS_COLOR, STYLE, plt
from slam_tools.studies import draw_study

COLORS = ("#d55e00", "#0072b2", "#cc3399", "#e69f00", "#009e73")
AXES = (("x (m)", 1.0), ("y (m)", 1.0), ("heading (deg)", 180.0 / np.pi))


def draw(results, path):
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(1 + len(AXES), len(results), figsize=(4.6 * len(results), 10), sharex=True,
                                      sharey="row", squeeze=False, gridspec_kw={"height_ratios": (1.3, 1, 1, 1)})
        for column, (result, color) in enumerate(zip(results, COLORS)):
            nees = np.array(result["nees_over_time"])
            time = result["time_step_s"] * np.arange(1, len(nees) + 1)
            low, high = result["pose_nees_bounds"]
            panel = panels[0][column]
            panel.axhspan(low, high, color=BOUNDS_COLOR, alpha=0.25, linewidth=0)
            panel.semilogy(time, nees, color=color, linewidth=0.9)
            panel.set_title(f"{result['estimator']}: mean {result['pose_nees']:.2f}, "
                            f"{100 * result['pose_nees_inside_share']:.0f} % inside")
            error, sigma = np.array(result["example_error"]), np.array(result["example_sigma"])
            for row, (_, scale) in enumerate(AXES):
                panel = panels[1 + row][column]
                panel.fill_between(time, -3 * scale * sigma[:, row], 3 * scale * sigma[:, row], color=color,
                                   alpha=0.2, linewidth=0)
                panel.plot(time, scale * error[:, row], color=color, linewidth=0.8)
            panels[-1][column].set_xlabel("time (s)")
        panels[0][0].set_ylabel("pose NEES, mean of the runs\n(green: 95 % if consistent)")
        for row, (name, _) in enumerate(AXES):
            panels[1 + row][0].set_ylabel(f"error in {name},\n3 sigma (first run)")
        figure.align_ylabels(panels[:, 0])
        figure.tight_layout()
        figure.savefig(path, format="png", dpi=110)
        plt.close(figure)


def main():
    draw_study("consistency", __doc__, draw)


if __name__ == "__main__":
    cli.run(main)
