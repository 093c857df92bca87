"""Draws several runs over one truth: their paths, their errors and their consistency over time."""
import itertools

import numpy as np

from .map_plot import path_during
from .plots import (BOUNDS_COLOR, CHI_SQUARE_95, STYLE, TIME_LABEL, TRUTH_COLOR, legend_above, nothing_to_show, over_time,
                    plt)

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f3c8d", "#8c564b")
LEGEND_COLUMNS = 6
LINES = ("-", "--", ":")   # when the colours are used up


def draw_comparison(path, runs, truth):
    """Writes the picture as PNG. runs: of comparison.ComparedRun."""
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(14, 9))
        legend_rows = -(-(len(runs) + 2) // LEGEND_COLUMNS)
        grid = figure.add_gridspec(3, 2, width_ratios=(1.0, 1.05), wspace=0.14, hspace=0.2, left=0.05, right=0.985,
                                   top=0.96, bottom=0.075 + 0.025 * legend_rows)
        map_axes = figure.add_subplot(grid[:, 0])
        position = figure.add_subplot(grid[0, 1])
        panels = [position] + [figure.add_subplot(grid[row, 1], sharex=position) for row in (1, 2)]
        styles = [{"color": color, "linestyle": line} for line, color in itertools.product(LINES, COLORS)]
        styles = list(itertools.islice(itertools.cycle(styles), len(runs)))
        _draw_paths(map_axes, runs, styles, truth)
        start = min(run.estimate.path.stamps[0] for run in runs)
        _draw_errors(panels[:2], runs, styles, start)
        _draw_nees(panels[2], runs, styles, start)
        for panel in panels[:-1]:
            panel.tick_params(labelbottom=False)
        panels[-1].set_xlabel(TIME_LABEL)
        figure.align_ylabels(panels)
        figure.legend(handles=map_axes.get_legend_handles_labels()[0], loc="lower center",
                      ncol=min(len(runs) + 2, LEGEND_COLUMNS))
        figure.savefig(path, format="png", dpi=110)
        plt.close(figure)


def _draw_paths(axes, runs, styles, truth):
    if truth.path is not None:
        look = {"linewidth": 2.6, "alpha": 0.35}
        if truth.path.quaternions is None:
            look = {"linestyle": "none", "marker": ".", "markersize": 3, "alpha": 0.6}
        longest = max((run.estimate.path for run in runs), key=lambda path: path.stamps[-1] - path.stamps[0])
        axes.plot(*path_during(truth.path, longest)[:, :2].T, color=TRUTH_COLOR, label="true path", **look)
    if truth.landmarks is not None and len(truth.landmarks):
        axes.plot(*truth.landmarks.positions[:, :2].T, linestyle="none", marker="+", markersize=13,
                  markeredgewidth=1.2, color=TRUTH_COLOR, label="true landmark")
    for run, style in zip(runs, styles):
        axes.plot(*run.evaluation.path_in_truth.positions[:, :2].T, linewidth=1.0, label=run.name, **style)
        axes.plot(*run.evaluation.landmarks_in_truth[:, :2].T, linestyle="none", marker="o", markersize=5,
                  markerfacecolor="none", color=style["color"])
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.05)
    axes.set_title("(a) Paths and landmarks (circles)")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")


def _draw_errors(panels, runs, styles, start):
    position, heading = panels
    position.set_title("(b) Position error")
    position.set_ylabel("distance (m)")
    heading.set_title("(c) Heading error")
    heading.set_ylabel("yaw (°)")
    heading.axhline(0.0, color="#777777", linewidth=0.7, zorder=1)
    for run, style in zip(runs, styles):
        errors = run.evaluation.path_errors
        if errors is None:
            continue
        size = 2 if run.evaluation.planar else 3
        distances = np.linalg.norm(errors.position[:, :size], axis=1)
        position.plot(*over_time(errors.stamps, start, distances), linewidth=0.9, **style)
        if errors.yaw is not None:
            heading.plot(*over_time(errors.stamps, start, np.degrees(errors.yaw)), linewidth=0.9, **style)
    if position.lines:
        position.set_ylim(bottom=0.0)
    else:
        nothing_to_show(position, "no true path")
    if len(heading.lines) == 1:
        nothing_to_show(heading, "no true heading")


def _draw_nees(panel, runs, styles, start):
    panel.set_title("(d) Consistency")
    panel.set_ylabel("NEES, from the start")
    shown = []
    for run, style in zip(runs, styles):
        nees = run.evaluation.start_nees
        if nees is not None and run.evaluation.path_errors is not None and np.isfinite(nees).any():
            known = np.isfinite(nees)
            panel.plot(*over_time(run.evaluation.path_errors.stamps[known], start, np.maximum(nees[known], 1e-9)),
                       linewidth=0.8, **style)
            shown.append(nees[known])
    if not shown:
        nothing_to_show(panel, "no NEES: it needs true poses and their covariances")
        return
    bounds = [CHI_SQUARE_95[dimension] for dimension in sorted({run.evaluation.nees_dimension for run in runs})]
    legend_above(panel, [panel.axhspan(low, high, color=BOUNDS_COLOR, alpha=0.13, linewidth=0, label="95 % bounds")
                         for low, high in bounds][:1])
    panel.set_yscale("log")
    panel.set_ylim(min(bounds[0][0] / 3.0, max(np.percentile(np.concatenate(shown), 2), 1e-3)),
                   1.5 * max(bounds[-1][1], max(np.percentile(values, 99) for values in shown)))
