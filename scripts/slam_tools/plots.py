"""How all pictures look, and what those over time share."""
import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt   # noqa: E402,F401  (after the choice of the backend; what draws takes it from here)
import numpy as np   # noqa: E402

ESTIMATE_COLOR, TRUTH_COLOR, DEAD_RECKONING_COLOR = "#0072b2", "#222222", "#e69f00"
LANDMARK_COLOR, SPURIOUS_COLOR, BOUNDS_COLOR = "#d55e00", "#cc3399", "#009e73"
STYLE = {"font.size": 9, "axes.titlesize": 10, "axes.titlelocation": "left", "axes.titleweight": "bold",
         "axes.grid": True, "grid.color": "#e4e4e4", "grid.linewidth": 0.6, "axes.axisbelow": True,
         "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": "#777777",
         "xtick.color": "#444444", "ytick.color": "#444444", "legend.fontsize": 8.5, "legend.frameon": False,
         "lines.solid_capstyle": "round", "path.simplify_threshold": 0.3}
# 2.5 % and 97.5 % quantiles by degrees of freedom
CHI_SQUARE_95 = {2: (0.0506, 7.3778), 3: (0.2158, 9.3484), 6: (1.2373, 14.4494)}
POINTS_MAX = 20000    # of a curve over time
TIME_LABEL = "time since the start (s)"


def over_time(stamps, start, *curves):
    """(seconds since start, curves) thinned, and interrupted where stamps are missing."""
    step = -(-len(stamps) // POINTS_MAX) if len(stamps) else 1
    seconds = stamps[::step] - start
    curves = [np.array(curve[::step], dtype=float) for curve in curves]
    gaps = np.diff(seconds)
    breaks = np.flatnonzero(gaps > max(1.0, 5.0 * np.median(gaps))) + 1 if len(gaps) else []
    return (np.insert(seconds, breaks, np.nan), *[np.insert(curve, breaks, np.nan) for curve in curves])


def legend_above(panel, handles):
    """In the line of the title, where it hides nothing."""
    if handles:
        panel.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=len(handles),
                     borderaxespad=0.2, handlelength=1.6, columnspacing=1.4)


def nothing_to_show(panel, reason):
    panel.text(0.5, 0.5, reason, transform=panel.transAxes, ha="center", va="center", color="#888888")
    panel.set_yticks([])
