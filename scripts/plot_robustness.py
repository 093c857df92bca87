#!/usr/bin/python3
"""Draws what `slam_study robustness --json FILE` wrote: success rate and error against each fault's strength.

  scripts/plot_robustness.py FILE.json PICTURE.png
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

import numpy as np

from slam_tools import cli
from slam_tools.plots import STYLE, plt
from slam_tools.studies import draw_study

VARIANTS = (("configured", "#0072b2", "o"), ("textbook", "#d55e00", "s"))
COLUMNS = 4
GOAL = 0.09   # m, of a run that is a success
ERROR_TICKS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)   # m


def draw_fault(success, error, sweep):
    """One fault: success rates above, errors of the landmarks below, against the strength."""
    places = np.arange(len(sweep["strength"]))   # evenly: the strengths grow by leaps
    base = sweep["strength"].index(sweep["base"])
    for panel in (success, error):
        panel.axvline(base, color="#999999", linewidth=0.8, linestyle=":")
    for name, color, marker in VARIANTS:
        figures = sweep[name]
        success.plot(places, 100.0 * np.array(figures["success_share"]), color=color, marker=marker,
                     markersize=4, linewidth=1.3)
        median, worst = (np.array(figures[f"landmark_rmse_{which}_m"], dtype=float)
                         for which in ("median", "worst"))
        error.semilogy(places, median, color=color, marker=marker, markersize=4, linewidth=1.3)
        error.semilogy(places, worst, color=color, linewidth=0.9, linestyle="--")
    error.set_yticks(ERROR_TICKS)
    error.set_yticklabels([f"{tick:g}" for tick in ERROR_TICKS])
    error.minorticks_off()
    error.axhline(GOAL, color="#444444", linewidth=0.7)
    success.set_title(sweep["fault"])
    success.set_ylim(-5, 105)
    success.tick_params(labelbottom=False)
    error.set_xticks(places)
    error.set_xticklabels([f"{strength:g}" for strength in sweep["strength"]])
    error.set_xlabel(sweep["unit"])


def draw(sweeps, path):
    rows = -(-len(sweeps) // COLUMNS)
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(3.4 * COLUMNS, 4.2 * rows))
        grid = figure.add_gridspec(rows, COLUMNS, hspace=0.32, wspace=0.24, left=0.06, right=0.99, bottom=0.07,
                                   top=0.95)
        first_error = None
        for i, sweep in enumerate(sweeps):
            cell = grid[i // COLUMNS, i % COLUMNS].subgridspec(2, 1, hspace=0.1)
            success = figure.add_subplot(cell[0])
            error = figure.add_subplot(cell[1], sharex=success, sharey=first_error)
            first_error = first_error or error
            draw_fault(success, error, sweep)
            if i % COLUMNS == 0:
                success.set_ylabel("success (%)")
                error.set_ylabel("landmark RMSE (m)")
                figure.align_ylabels([success, error])
        handles = [plt.Line2D([], [], color=color, marker=marker, markersize=4, label=name)
                   for name, color, marker in VARIANTS]
        handles += [plt.Line2D([], [], color="#666666", label="median"),
                    plt.Line2D([], [], color="#666666", linestyle="--", label="worst run"),
                    plt.Line2D([], [], color="#999999", linestyle=":", label="base point"),
                    plt.Line2D([], [], color="#444444", linewidth=0.7, label="0.09 m")]
        figure.legend(handles=handles, loc="lower right", ncol=2, bbox_to_anchor=(0.985, 0.2),
                      title=f"{sweeps[0]['runs']} runs a point")
        figure.savefig(path, format="png", dpi=110)
        plt.close(figure)


def main():
    draw_study("robustness", __doc__, draw)


if __name__ == "__main__":
    cli.run(main)
