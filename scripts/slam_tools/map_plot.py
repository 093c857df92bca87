"""Draws a map: paths, landmarks and how far off they may be."""
import numpy as np
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch
from matplotlib.transforms import ScaledTranslation

from .plots import DEAD_RECKONING_COLOR, ESTIMATE_COLOR, LANDMARK_COLOR, SPURIOUS_COLOR, TRUTH_COLOR

LABEL_COLORS = {"red": "#d62728", "green": "#2ca02c", "blue": "#1f5fd0", "yellow": "#e5b800",
                "orange": "#ff7f0e", "purple": "#9467bd", "cyan": "#17becf", "magenta": "#e377c2",
                "pink": "#f7a8c4", "brown": "#8c564b", "white": "#c8c8c8", "grey": "#7f7f7f",
                "gray": "#7f7f7f", "black": "#000000"}
NUMBERS_MAX = 80      # of landmarks that are numbered


def draw_map(axes, estimate, truth, evaluation, sigmas):
    """Paths and landmarks with their covariances, in the frame of the truth; the legend stands below."""
    legend = []
    if evaluation.dead_reckoning_in_truth is not None:
        legend += axes.plot(*evaluation.dead_reckoning_in_truth.positions[:, :2].T,
                            color=DEAD_RECKONING_COLOR, linewidth=0.9, alpha=0.75, zorder=2,
                            label="dead reckoning")
    if truth.path is not None:
        style = {"linewidth": 2.4, "alpha": 0.35}
        if truth.path.quaternions is None:
            style = {"linestyle": "none", "marker": ".", "markersize": 3, "alpha": 0.6}
        true_path = path_during(truth.path, estimate.path)
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
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    below = axes.transAxes + ScaledTranslation(0.0, -28.0 / 72.0, axes.figure.dpi_scale_trans)   # the axis' label
    axes.legend(handles=start + legend, loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=below, ncol=4,
                columnspacing=1.8, handletextpad=0.6)
    _number_landmarks(axes, estimate, truth, evaluation)


def path_during(true_path, estimated_path):
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
    points_per_pixel = 72.0 / axes.figure.dpi
    markers = points_per_pixel * axes.transData.transform(
        np.vstack([points, evaluation.landmarks_in_truth[:, :2]]))
    placed = []
    for point, text in zip(markers[:len(points)], texts):
        half_size = np.array([3.0 * len(str(text)) + 1.0, 4.9])   # points, as all lengths here
        best_cost, best = np.inf, None
        for radius in (11.8, 15.0, 19.6, 26.2):
            for angle in np.radians(np.arange(45.0, 405.0, 22.5)):
                center = point + (radius + half_size[0] - 3.9) * np.array([np.cos(angle), 0.0]) \
                    + radius * np.array([0.0, np.sin(angle)])
                hidden = np.all(np.abs(markers - center) < half_size + 3.3, axis=1).sum()
                crossed = sum(np.all(np.abs(other - center) < half_size + size) for other, size in placed)
                outside = not axes.bbox.contains(*(center / points_per_pixel))
                cost = 10.0 * hidden + 20.0 * crossed + 50.0 * outside + 0.15 * radius
                if cost < best_cost:
                    best_cost, best = cost, center
        placed.append((best, half_size))
        leader = {"arrowstyle": "-", "color": "#999999", "linewidth": 0.6, "shrinkA": 0, "shrinkB": 4}
        far = np.linalg.norm(best - point) > 22.3
        axes.annotate(str(text), xy=point, xycoords="figure points", xytext=best, textcoords="figure points",
                      ha="center", va="center", fontsize=8.5, color=TRUTH_COLOR, zorder=10,
                      arrowprops=leader if far else None,
                      bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "alpha": 0.75,
                            "edgecolor": "none"})
