"""The picture of an evaluation: the map, the errors over time with their uncertainty, and the consistency."""
import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt   # noqa: E402  (after the choice of the backend)
import numpy as np   # noqa: E402
from matplotlib.colors import to_rgba   # noqa: E402
from matplotlib.lines import Line2D   # noqa: E402
from matplotlib.patches import Ellipse, Patch   # noqa: E402

ESTIMATE_COLOR, TRUTH_COLOR, DEAD_RECKONING_COLOR = "#0072b2", "#222222", "#e69f00"
LANDMARK_COLOR, SPURIOUS_COLOR, BOUNDS_COLOR = "#d55e00", "#cc3399", "#009e73"
LABEL_COLORS = {"red": "#d62728", "green": "#2ca02c", "blue": "#1f5fd0", "yellow": "#e5b800",
                "orange": "#ff7f0e", "purple": "#9467bd", "cyan": "#17becf", "magenta": "#e377c2",
                "pink": "#f7a8c4", "brown": "#8c564b", "white": "#c8c8c8", "grey": "#7f7f7f",
                "gray": "#7f7f7f", "black": "#000000"}
STYLE = {"font.size": 9, "axes.titlesize": 10, "axes.titlelocation": "left", "axes.titleweight": "bold",
         "axes.grid": True, "grid.color": "#e4e4e4", "grid.linewidth": 0.6, "axes.axisbelow": True,
         "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": "#777777",
         "xtick.color": "#444444", "ytick.color": "#444444", "legend.fontsize": 8.5, "legend.frameon": False,
         "lines.solid_capstyle": "round", "path.simplify_threshold": 0.3}
# 2.5 % and 97.5 % quantiles by degrees of freedom
CHI_SQUARE_95 = {2: (0.0506, 7.3778), 3: (0.2158, 9.3484), 6: (1.2373, 14.4494)}
POINTS_MAX = 20000    # of a curve over time
NUMBERS_MAX = 80      # of landmarks that are numbered


def draw_evaluation(path, estimate, truth, evaluation, sigmas):
    """Writes the picture as PNG."""
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(14, 11), dpi=110)
        components = "xy" if evaluation.planar else "xyz"
        columns = figure.add_gridspec(1, 2, width_ratios=(1.12, 1.0), wspace=0.15,
                                      left=0.055, right=0.985, top=0.89, bottom=0.06)
        right = columns[1].subgridspec(3, 1, hspace=0.2, height_ratios=(len(components), 1.1, 1.1))
        position = right[0].subgridspec(len(components), 1, hspace=0.1)
        panels = []
        for cell in [position[i] for i in range(len(components))] + [right[1], right[2]]:
            panels.append(figure.add_subplot(cell, sharex=panels[0] if panels else None))

        _draw_position(panels[:-2], components, estimate, evaluation, sigmas)
        _draw_heading(panels[-2], estimate, evaluation, sigmas)
        _draw_consistency(panels[-1], estimate, evaluation)
        for panel in panels[:-1]:
            panel.tick_params(labelbottom=False)
        panels[-1].set_xlabel("time since the start (s)")
        figure.align_ylabels(panels)
        map_axes = figure.add_subplot(columns[0].subgridspec(2, 1, height_ratios=(1.0, 0.055), hspace=0.0)[0])
        _draw_map(map_axes, estimate, truth, evaluation, sigmas)
        figure.text(0.055, 0.965, "Estimate against the truth", fontsize=15, fontweight="bold",
                    color=TRUTH_COLOR)
        figure.text(0.055, 0.938, _summary(evaluation.metrics), fontsize=10.5, color="#444444")
        figure.savefig(path, format="png", dpi=110)
        plt.close(figure)


def _summary(metrics):
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
    parts.append("not aligned" if metrics["align"] == "none" else f"aligned by {metrics['align']}")
    return "  ·  ".join(parts)


# -------------------------------------------------------------------------------- the map


def _draw_map(axes, estimate, truth, evaluation, sigmas):
    legend = []
    if evaluation.dead_reckoning_in_truth is not None:
        legend += axes.plot(*evaluation.dead_reckoning_in_truth.positions[:, :2].T,
                            color=DEAD_RECKONING_COLOR, linewidth=0.9, alpha=0.75, zorder=2,
                            label="dead reckoning")
    if truth.path is not None:
        style = {"linewidth": 2.4, "alpha": 0.35}
        if truth.path.quaternions is None:
            style = {"linestyle": "none", "marker": ".", "markersize": 3, "alpha": 0.6}
        true_path = _during(truth.path, estimate.path)
        legend += axes.plot(*true_path[:, :2].T, color=TRUTH_COLOR, zorder=3, label="true path", **style)
    estimated_path = evaluation.path_in_truth.positions
    legend += axes.plot(*estimated_path[:, :2].T, color=ESTIMATE_COLOR, linewidth=1.0, zorder=4,
                        label="estimated path")
    start = axes.plot(*estimated_path[0, :2], linestyle="none", marker="D", markersize=8,
                      markerfacecolor="white", markeredgecolor=ESTIMATE_COLOR, markeredgewidth=1.8, zorder=9,
                      label="start")

    positions = evaluation.landmarks_in_truth
    spurious = np.array([truth.landmarks is not None and i not in evaluation.pairs
                         for i in range(len(positions))], dtype=bool)
    colors = np.array([LABEL_COLORS.get(label.lower(), LANDMARK_COLOR)
                       for label in estimate.landmarks.labels])
    legend_color = LANDMARK_COLOR if len(set(colors)) != 1 else colors[0]
    if len(positions):
        colors[spurious] = SPURIOUS_COLOR
        ellipses = _ellipses(evaluation.landmark_covariances_in_truth, sigmas)
        for position, width, height, angle, color in zip(positions, *ellipses, colors):
            axes.add_patch(Ellipse(position[:2], width, height, angle=angle, linewidth=0.9, zorder=5,
                                   facecolor=to_rgba(color, 0.22), edgecolor=color))
    for chosen, marker, size in ((~spurious, "o", 30), (spurious, "X", 46)):
        axes.scatter(*positions[chosen, :2].T, s=size, marker=marker, c=list(colors[chosen]),
                     edgecolors="white", linewidths=0.5, zorder=7)
    if truth.landmarks is not None and len(truth.landmarks):
        legend += axes.plot(*truth.landmarks.positions[:, :2].T, linestyle="none", marker="+", markersize=15,
                            markeredgewidth=1.2, color=TRUTH_COLOR, zorder=6, label="true landmark")
    if (~spurious).any():
        legend.append(Line2D([], [], linestyle="none", marker="o", markersize=5, color=legend_color,
                             label="estimated landmark"))
        legend.append(Patch(facecolor=to_rgba(legend_color, 0.22), edgecolor=legend_color,
                            label=f"its {sigmas:g}σ ellipse"))
    if spurious.any():
        legend.append(Line2D([], [], linestyle="none", marker="X", markersize=7, color=SPURIOUS_COLOR,
                             label="spurious landmark"))

    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.05)
    axes.set_title("(a) Map")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.legend(handles=start + legend, loc="upper center", bbox_to_anchor=(0.5, -0.055), ncol=4,
                columnspacing=1.8, handletextpad=0.6)
    _number_landmarks(axes, estimate, truth, evaluation)


def _during(true_path, estimated_path):
    """Positions of the true path while there was an estimate."""
    inside = (true_path.stamps >= estimated_path.stamps[0]) & (true_path.stamps <= estimated_path.stamps[-1])
    return true_path.positions[inside]


def _ellipses(covariances, sigmas):
    """Widths, heights and angles in degrees of the covariances of x and y."""
    values, vectors = np.linalg.eigh(covariances[:, :2, :2])
    lengths = 2.0 * sigmas * np.sqrt(np.maximum(values, 0.0))
    return lengths[:, 1], lengths[:, 0], np.degrees(np.arctan2(vectors[:, 1, 1], vectors[:, 0, 1]))


def _number_landmarks(axes, estimate, truth, evaluation):
    """Identities next to the true landmarks; ids of the map where there are no true ones."""
    if truth.landmarks is not None:
        points, texts = truth.landmarks.positions[:, :2], truth.landmarks.identities
    else:
        points, texts = evaluation.landmarks_in_truth[:, :2], estimate.landmarks.ids
    if not 0 < len(points) <= NUMBERS_MAX:
        return
    axes.figure.canvas.draw()   # settles the limits
    markers = np.vstack([axes.transData.transform(points),
                         axes.transData.transform(evaluation.landmarks_in_truth[:, :2])])
    placed = []
    for point, text in zip(markers[:len(points)], texts):
        half_size = np.array([4.6 * len(str(text)) + 1.5, 7.5])   # pixels
        best_cost, best = np.inf, None
        for radius in (18.0, 23.0, 30.0, 40.0):
            for angle in np.radians(np.arange(45.0, 405.0, 22.5)):
                center = point + (radius + half_size[0] - 6.0) * np.array([np.cos(angle), 0.0]) \
                    + radius * np.array([0.0, np.sin(angle)])
                hidden = np.all(np.abs(markers - center) < half_size + 5.0, axis=1).sum()
                crossed = sum(np.all(np.abs(other - center) < half_size + size) for other, size in placed)
                outside = not axes.bbox.contains(*center)
                cost = 10.0 * hidden + 20.0 * crossed + 50.0 * outside + 0.1 * radius
                if cost < best_cost:
                    best_cost, best = cost, center
        placed.append((best, half_size))
        leader = {"arrowstyle": "-", "color": "#999999", "linewidth": 0.6, "shrinkA": 0, "shrinkB": 4}
        far = np.linalg.norm(best - point) > 34.0
        axes.annotate(str(text), xy=point, xycoords="figure pixels", xytext=best, textcoords="figure pixels",
                      ha="center", va="center", fontsize=8.5, color=TRUTH_COLOR, zorder=10,
                      arrowprops=leader if far else None,
                      bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "alpha": 0.75,
                            "edgecolor": "none"})


# -------------------------------------------------------------------------------- over time


def _over_time(stamps, start, *curves):
    """(seconds since start, curves) thinned, and interrupted where stamps are missing."""
    step = -(-len(stamps) // POINTS_MAX) if len(stamps) else 1
    seconds = stamps[::step] - start
    curves = [np.array(curve[::step], dtype=float) for curve in curves]
    gaps = np.diff(seconds)
    breaks = np.flatnonzero(gaps > max(1.0, 5.0 * np.median(gaps))) + 1 if len(gaps) else []
    return (np.insert(seconds, breaks, np.nan), *[np.insert(curve, breaks, np.nan) for curve in curves])


def _error_panel(panel, stamps, start, error, std, sigmas, shown=100):
    """An error with the band of its standard deviation; either may be None. Returns what the legend needs.

    shown: percentage of the errors that the panel is high enough for.
    """
    handles = []
    extent = []
    if std is not None:
        seconds, band = _over_time(stamps, start, sigmas * std)
        handles.append(panel.fill_between(seconds, -band, band, color=ESTIMATE_COLOR, alpha=0.18, linewidth=0,
                                          label=f"±{sigmas:g}σ of the estimate"))
        extent.append(np.percentile(sigmas * std, 97))
    if error is not None:
        seconds, curve = _over_time(stamps, start, error)
        handles += panel.plot(seconds, curve, color=ESTIMATE_COLOR, linewidth=0.9, label="error")
        extent.append(np.percentile(np.abs(error), shown))
    panel.axhline(0.0, color="#777777", linewidth=0.7, zorder=1)
    limit = 1.15 * max(extent, default=0.0)
    if limit > 0.0:
        panel.set_ylim(-limit, limit)
    return handles


def _legend_above(panel, handles):
    """In the line of the title, where it hides nothing."""
    if handles:
        panel.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=len(handles),
                     borderaxespad=0.2, handlelength=1.6, columnspacing=1.4)


def _nothing_to_show(panel, reason):
    panel.text(0.5, 0.5, reason, transform=panel.transAxes, ha="center", va="center", color="#888888")
    panel.set_yticks([])


def _uncertainty(estimate, evaluation):
    """(stamps, errors or None, covariances or None): of the comparison, else of the whole estimate."""
    errors = evaluation.path_errors
    if errors is not None and len(errors.stamps):
        return errors.stamps, errors, errors.covariances
    return estimate.path.stamps, None, estimate.covariances


def _draw_position(panels, components, estimate, evaluation, sigmas):
    stamps, errors, covariances = _uncertainty(estimate, evaluation)
    for i, (panel, name) in enumerate(zip(panels, components)):
        error = None if errors is None else errors.position[:, i]
        std = None if covariances is None else np.sqrt(np.maximum(covariances[:, i, i], 0.0))
        shown = 99 if evaluation.metrics["align"] == "robust" else 100
        handles = _error_panel(panel, stamps, estimate.path.stamps[0], error, std, sigmas, shown)
        panel.set_ylabel(f"{name} (m)")
        if not handles:
            _nothing_to_show(panel, "no true path and no covariance of the pose")
        if i == 0:
            _legend_above(panel, handles)
    panels[0].set_title("(b) Position error" if errors is not None else "(b) Position: no true path")


def _draw_heading(panel, estimate, evaluation, sigmas):
    stamps, errors, covariances = _uncertainty(estimate, evaluation)
    error = None if errors is None or errors.yaw is None else np.degrees(errors.yaw)
    std = None if covariances is None else np.degrees(np.sqrt(np.maximum(covariances[:, 5, 5], 0.0)))
    handles = _error_panel(panel, stamps, estimate.path.stamps[0], error, std, sigmas)
    panel.set_ylabel("yaw (°)")
    panel.set_title("(c) Heading error" if error is not None else "(c) Heading: no true heading")
    if not handles:
        _nothing_to_show(panel, "no true heading and no covariance of the pose")


def _draw_consistency(panel, estimate, evaluation):
    """NEES of the pose; without it NIS of the associations, which needs no truth.

    The covariance says how far the robot may be from where it should be, seen from its start: so the path is
    laid on the truth there. The best fit over the whole run would move the start, which is known best of all.
    """
    start = estimate.path.stamps[0]
    errors, nees = evaluation.path_errors, evaluation.start_nees
    if errors is not None and nees is not None and np.isfinite(nees).any():
        known = np.isfinite(nees)
        seconds, curve = _over_time(errors.stamps[known], start, np.maximum(nees[known], 1e-9))
        handles = panel.plot(seconds, curve, color=ESTIMATE_COLOR, linewidth=0.8, label="NEES", zorder=3)
        dimension, mean = evaluation.nees_dimension, evaluation.metrics["pose_nees_start_mean"]
        values = nees[known]
        panel.set_title("(d) Consistency")
        panel.set_ylabel("NEES, from the start")
    else:
        shown = estimate.associations.accepted & np.isfinite(estimate.associations.nis)
        values = estimate.associations.nis[shown]
        panel.set_title("(d) Consistency (NIS)")
        panel.set_ylabel("NIS")
        if not len(values):
            _nothing_to_show(panel, "no NEES: it needs true poses and their covariances; no NIS either")
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
    _legend_above(panel, handles)
