"""The figures of an evaluation: their names, what they mean, and how they are written."""
import json
import textwrap
from dataclasses import dataclass
from typing import List

from .cli import atomic_output


@dataclass(frozen=True)
class Metric:
    """One figure. group: heading that it stands under; indented titles belong to the one above."""
    name: str
    group: str
    title: str
    unit: str
    meaning: str


METRICS = (
    Metric("ate_rmse_m", "path", "position error, RMSE", "m", "root mean square of the position error of the path"),
    Metric("path_error_median_m", "path", "  median", "m", "median of the same"),
    Metric("path_error_p95_m", "path", "  95th percentile", "m", "95th percentile of the same"),
    Metric("ate_rmse_start_m", "path", "  aligned at the start", "m", "the same, not fitted"),
    Metric("dead_reckoning_ate_rmse_m", "path", "  of dead reckoning", "m", "the same of dead_reckoning.tum"),
    Metric("heading_rmse_deg", "path", "heading error, RMSE", "deg", "root mean square of the yaw error"),
    Metric("pose_nees_start_mean", "path", "pose NEES, start aligned", "",
           "mean of e^T P^-1 e, with 3 degrees of freedom (x, y, yaw) in the plane and 6 in space; a consistent "
           "estimate has the degrees of freedom for mean. Not fitted, for the covariance is relative to the start. "
           "Poses with a singular covariance are skipped"),
    Metric("pose_nees_mean", "path", "  aligned as above", "",
           "the same after the alignment, which leaves errors at the start, where the covariance is none: of use "
           "where the start is not known exactly; with --align none of the path as it was given, by which a path in "
           "a frame of global positions is judged"),
    Metric("path_length_m", "path", "length", "m",
           "of the true path where it was compared; of the estimated path where the truth is positions only (their "
           "noise lengthens it) or not there"),
    Metric("duration_s", "path", "duration", "s", "likewise"),
    Metric("landmark_rmse_m", "landmarks", "position error, RMSE", "m",
           "root mean square of the position error of the matched landmarks"),
    Metric("landmark_max_m", "landmarks", "position error, largest", "m", "the largest of the same"),
    Metric("landmark_rmse_start_m", "landmarks", "  RMSE, aligned at the start", "m", "the same, not fitted"),
    Metric("landmarks_estimated", "landmarks", "estimated", "", "count"),
    Metric("landmarks_true", "landmarks", "true", "", "count"),
    Metric("landmarks_missed", "landmarks", "missed", "", "true ones without an estimate"),
    Metric("landmarks_spurious", "landmarks", "spurious", "", "estimates without a true one"),
    Metric("association_accuracy", "landmarks", "associations that are right", "",
           "of the accepted detections with a source_id, the share whose landmark matches the true landmark of that "
           "identity; with a landmark that is no longer in the map, or spurious, it is wrong"),
    Metric("association_accuracy_instant", "landmarks", "  as told at once", "",
           "the same as told at once (associations_instant.csv), before later sightings changed it"))


def no_metrics(alignment):
    """All figures unknown: what evaluation.json holds before anything is compared."""
    return {"align": alignment, **{metric.name: None for metric in METRICS}}


def format_value(value):
    """The text of a figure for people."""
    return "-" if value is None else str(value) if isinstance(value, int) else f"{value:.3f}"


def table(metrics) -> List[str]:
    """The figures as lines of text."""
    lines = []
    group = None
    for metric in METRICS:
        if metric.group != group:
            group = metric.group
            lines.append(group)
        value = metrics[metric.name]
        unit = metric.unit if value is not None else ""
        lines.append(f"  {metric.title:30s}{format_value(value):>12s} {unit}".rstrip())
    return lines


def definitions() -> str:
    """The figures' names and meanings, for the help of a script."""
    column = 31
    lines = [textwrap.fill(f"  {metric.name:{column - 2}s}{metric.meaning}", 115,
                           subsequent_indent=column * " ", break_on_hyphens=False) for metric in METRICS]
    return "\n".join(lines + [f"  {'align':{column - 2}s}none, se2, se3 or robust"])


def write_metrics(metrics, path):
    with atomic_output(path) as temporary_path:
        with open(temporary_path, "w", encoding="utf-8") as file:
            json.dump(metrics, file, indent=2, allow_nan=False)
            file.write("\n")
