"""Prints runs beside their batch optimum."""
import math

CALIBRATED = (("input/linear_scale", "speed"), ("input/angular_scale", "turn"), ("input/odometry_delay", "delay s"),
              ("sensor/range_scale", "range"), ("sensor/depth_share", "depth"))


def row_figures(result):
    """Path of the filter and refined, landmarks of the filter and refined, m; NaN where there is no truth."""
    return [run[key] if run[key] is not None else math.nan
            for key in ("ate_rmse_m", "landmark_rmse_m") for run in (result, result["refined"])]


def means(results):
    """Those of the figures of a row."""
    return [sum(column) / len(results) for column in zip(*map(row_figures, results))]


def figures_text(figures):
    return "".join("       -" if math.isnan(figure) else f"{figure:8.3f}" for figure in figures[:2]) + "  " + "".join(
        f"{figure:8.3f}" for figure in figures[2:])


def print_refinements(names, results):
    """A line each, then the means. results: evaluation.json, with that of the refined run under "refined" and
    refinement.json under "refinement"."""
    print("         path ATE (m)       landmarks (m)")
    print("  robot  filter refined    filter refined   seconds" + "".join(f"{name:>16s}" for _, name in CALIBRATED))
    for name, result in zip(names, results):
        values = [result["refinement"]["calibration"][key] for key, _ in CALIBRATED]
        print(f"  {name:5d}{figures_text(row_figures(result))}{result['refinement']['seconds']:10.1f}"
              + "".join(f"{value['value']:10.3f} {value['sigma']:.3f}" for value in values))
    print(f"   mean{figures_text(means(results))}")
