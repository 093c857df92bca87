"""Draws an evaluation: the errors over time with their uncertainty, the consistency, and all of it in one picture."""
import numpy as np

from .map_plot import draw_map
from .plots import (BOUNDS_COLOR, CHI_SQUARE_95, ESTIMATE_COLOR, STYLE, TIME_LABEL, TRUTH_COLOR, legend_above,
                    nothing_to_show, over_time, plt)


def draw_evaluation(path, estimate, truth, evaluation, sigmas):
    """Writes the picture as PNG."""
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(14, 11), dpi=110)
        components = _components(evaluation)
        columns = figure.add_gridspec(1, 2, width_ratios=(1.12, 1.0), wspace=0.15,
                                      left=0.055, right=0.985, top=0.89, bottom=0.06)
        right = columns[1].subgridspec(3, 1, hspace=0.2, height_ratios=(len(components), 1.1, 1.1))
        position = right[0].subgridspec(len(components), 1, hspace=0.1)
        panels = []
        for cell in [position[i] for i in range(len(components))] + [right[1], right[2]]:
            panels.append(figure.add_subplot(cell, sharex=panels[0] if panels else None))

        draw_errors(panels[:-1], estimate, evaluation, sigmas)
        draw_consistency(panels[-1], estimate, evaluation)
        panels[-2].tick_params(labelbottom=False)
        panels[-2].set_xlabel("")
        figure.align_ylabels(panels)
        map_axes = figure.add_subplot(columns[0].subgridspec(2, 1, height_ratios=(1.0, 0.055), hspace=0.0)[0])
        draw_map(map_axes, estimate, truth, evaluation, sigmas)
        map_axes.set_title("Map")
        for letter, panel in zip("abcd", (map_axes, panels[0], panels[-2], panels[-1])):
            panel.set_title(f"({letter}) {panel.get_title(loc='left')}")
        figure.text(0.055, 0.965, "Estimate against the truth" if truth.is_known else "Estimate", fontsize=15,
                    fontweight="bold", color=TRUTH_COLOR)
        figure.text(0.055, 0.938, "  ·  ".join(summary(evaluation.metrics)), fontsize=10.5, color="#444444")
        figure.savefig(path, format="png", dpi=110)
        plt.close(figure)


def summary(metrics):
    """The run in a few phrases."""
    parts = []
    if metrics["ate_rmse_m"] is not None:
        part = f"path {metrics['ate_rmse_m']:.3f} m RMSE"
        if metrics["align"] == "robust":
            part = (f"path {metrics['path_error_median_m']:.2f} m median, "
                    f"{metrics['path_error_p95_m']:.2f} m 95th percentile")
        if metrics["dead_reckoning_ate_rmse_m"] is not None:
            part += f" (dead reckoning {metrics['dead_reckoning_ate_rmse_m']:.3f} m)"
        parts.append(part)
    if metrics["heading_rmse_deg"] is not None:
        parts.append(f"heading {metrics['heading_rmse_deg']:.2f}° RMSE")
    if metrics["landmarks_true"] is not None:
        matched = metrics["landmarks_true"] - metrics["landmarks_missed"]
        part = f"{matched} of {metrics['landmarks_true']} landmarks"
        if metrics["landmark_rmse_m"] is not None:
            part += f", {metrics['landmark_rmse_m']:.3f} m RMSE"
        if metrics["landmarks_spurious"]:
            part += f", {metrics['landmarks_spurious']} spurious"
        parts.append(part)
    else:
        parts.append(f"{metrics['landmarks_estimated']} landmarks")
    if metrics["path_length_m"] is not None:
        parts.append(f"{metrics['path_length_m']:.0f} m in {metrics['duration_s']:.0f} s")
    if metrics["ate_rmse_m"] is not None or metrics["landmark_rmse_m"] is not None:
        parts.append("not aligned" if metrics["align"] == "none" else f"aligned by {metrics['align']}")
    return parts


def _error_panel(panel, stamps, start, error, std, sigmas, shown=100):
    """An error with the band of its standard deviation; either may be None. Returns what the legend needs.

    shown: percentage of the errors that the panel is high enough for.
    """
    handles = []
    extent = []
    if std is not None:
        seconds, band = over_time(stamps, start, sigmas * std)
        handles.append(panel.fill_between(seconds, -band, band, color=ESTIMATE_COLOR, alpha=0.18, linewidth=0,
                                          label=f"±{sigmas:g}σ of the estimate"))
        extent.append(np.percentile(sigmas * std, 97))
    if error is not None:
        seconds, curve = over_time(stamps, start, error)
        handles += panel.plot(seconds, curve, color=ESTIMATE_COLOR, linewidth=0.9, label="error")
        extent.append(np.percentile(np.abs(error), shown))
    panel.axhline(0.0, color="#777777", linewidth=0.7, zorder=1)
    limit = 1.15 * max(extent, default=0.0)
    if limit > 0.0:
        panel.set_ylim(-limit, limit)
    return handles


def _uncertainty(estimate, evaluation):
    """(stamps, errors or None, covariances or None): of the comparison, else of the whole estimate."""
    errors = evaluation.path_errors
    if errors is not None and len(errors.stamps):
        return errors.stamps, errors, errors.covariances
    return estimate.path.stamps, None, estimate.covariances


def error_panels(evaluation):
    """How many panels `draw_errors` needs."""
    return len(_components(evaluation)) + 1


def draw_errors(panels, estimate, evaluation, sigmas):
    """Errors of the position, a panel each component, and of the heading, with what the covariances say."""
    _draw_position(panels[:-1], _components(evaluation), estimate, evaluation, sigmas)
    _draw_heading(panels[-1], estimate, evaluation, sigmas)
    for panel in panels[:-1]:
        panel.tick_params(labelbottom=False)
    panels[-1].set_xlabel(TIME_LABEL)


def _components(evaluation):
    return "xy" if evaluation.planar else "xyz"


def _draw_position(panels, components, estimate, evaluation, sigmas):
    stamps, errors, covariances = _uncertainty(estimate, evaluation)
    for i, (panel, name) in enumerate(zip(panels, components)):
        error = None if errors is None else errors.position[:, i]
        std = None if covariances is None else np.sqrt(np.maximum(covariances[:, i, i], 0.0))
        shown = 99 if evaluation.metrics["align"] == "robust" else 100
        handles = _error_panel(panel, stamps, estimate.path.stamps[0], error, std, sigmas, shown)
        panel.set_ylabel(f"{name} (m)")
        if not handles:
            nothing_to_show(panel, "no true path and no covariance of the pose")
        if i == 0:
            legend_above(panel, handles)
    panels[0].set_title("Position error" if errors is not None else "Position: no true path")


def _draw_heading(panel, estimate, evaluation, sigmas):
    stamps, errors, covariances = _uncertainty(estimate, evaluation)
    error = None if errors is None or errors.yaw is None else np.degrees(errors.yaw)
    std = None if covariances is None else np.degrees(np.sqrt(np.maximum(covariances[:, 5, 5], 0.0)))
    handles = _error_panel(panel, stamps, estimate.path.stamps[0], error, std, sigmas)
    panel.set_ylabel("yaw (°)")
    panel.set_title("Heading error" if error is not None else "Heading: no true heading")
    if not handles:
        nothing_to_show(panel, "no true heading and no covariance of the pose")


def draw_consistency(panel, estimate, evaluation):
    """NEES of the pose; without it NIS of the associations, which needs no truth.

    The covariance says how far the robot may be from where it should be, seen from its start: so the path is
    laid on the truth there. The best fit over the whole run would move the start, which is known best of all.
    A path that is not to be aligned has a covariance that says where it is in the frame of the truth.
    """
    panel.set_xlabel(TIME_LABEL)
    start = estimate.path.stamps[0]
    errors = evaluation.path_errors
    is_given = evaluation.metrics["align"] == "none" and errors is not None
    nees = errors.nees if is_given else evaluation.start_nees
    if errors is not None and nees is not None and np.isfinite(nees).any():
        known = np.isfinite(nees)
        seconds, curve = over_time(errors.stamps[known], start, np.maximum(nees[known], 1e-9))
        handles = panel.plot(seconds, curve, color=ESTIMATE_COLOR, linewidth=0.8, label="NEES", zorder=3)
        values = nees[known]
        dimension, mean = evaluation.nees_dimension, float(values.mean())
        panel.set_title("Consistency")
        panel.set_ylabel("NEES, as given" if is_given else "NEES, from the start")
    else:
        shown = estimate.associations.accepted & np.isfinite(estimate.associations.nis)
        values = estimate.associations.nis[shown]
        panel.set_title("Consistency (NIS)")
        panel.set_ylabel("NIS")
        if not len(values):
            nothing_to_show(panel, "no NEES: it needs true poses and their covariances; no NIS either")
            return
        handles = panel.plot(estimate.associations.stamps[shown] - start, np.maximum(values, 1e-9),
                             linestyle="none", marker=".", markersize=2.5, color=ESTIMATE_COLOR, alpha=0.5,
                             label="NIS", zorder=3)
        dimension, mean = 2 if evaluation.planar else 3, float(values.mean())
    low, high = CHI_SQUARE_95[dimension]
    handles.append(panel.axhspan(low, high, color=BOUNDS_COLOR, alpha=0.13, linewidth=0,
                                 label=f"95 % bounds, {dimension} dof"))
    handles.append(panel.axhline(mean, color="#d55e00", linewidth=1.2, linestyle="--", zorder=4,
                                 label=f"mean {mean:.3g}"))
    panel.set_yscale("log")
    panel.set_ylim(min(low / 3.0, max(np.percentile(values, 2), 1e-3)),
                   1.5 * max(high, np.percentile(values, 99), mean))
    legend_above(panel, handles)
