"""One run as a page that can be handed in: figures, map, errors, parameters, versions and warnings.

The page is one file that needs nothing else, no network either. All texts come to it through the escaping of
Jinja's templates; pictures are SVG inside of it.
"""
import base64
import datetime
import io
import os
import platform
import shlex
from dataclasses import dataclass

import jinja2
import matplotlib
import numpy as np

from .cli import atomic_output
from .evaluation import ALIGNMENTS
from .evaluation_plots import draw_consistency, draw_errors, error_panels, summary
from .map_plot import draw_map
from .metrics import METRICS, format_value
from .plots import CHI_SQUARE_95, STYLE, plt
from .provenance import default_parameters, is_same_value

SVG_STYLE = {**STYLE, "svg.hashsalt": "report"}   # the same run gives the same picture
DATES_FROM = 1e9   # s: earlier stamps are those of a simulated clock


@dataclass(frozen=True)
class Run:
    """All that is known of one run. folder: where it is; truth_bag: path or None; sigmas: size of the ellipses."""
    folder: str
    estimate: object
    provenance: object
    truth: object
    truth_bag: object
    evaluation: object
    sigmas: float

    @property
    def name(self):
        return os.path.basename(os.path.abspath(self.folder))


def write_report(path, run, title=None):
    """Writes the page; title: text in place of the run's name."""
    with atomic_output(path) as temporary_path:
        with open(temporary_path, "w", encoding="utf-8") as file:
            file.write(render(run, title))


def render(run, title=None):
    """The page as text."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(os.path.dirname(os.path.realpath(__file__))), autoescape=True,
        undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.get_template("report.html").render(
        title=title or f"SLAM run {run.name}", phrases=summary(run.evaluation.metrics), facts=facts(run),
        alignment=ALIGNMENTS[run.evaluation.metrics["align"]] if run.truth.is_known else None,
        metrics=known_metrics(run), unknown_metrics=unknown_metrics(run), pictures=pictures(run),
        sigmas=f"{run.sigmas:g}", planar=run.evaluation.planar, truth_is_known=run.truth.is_known,
        landmarks=landmark_rows(run), missed=missed_landmarks(run), consistency=consistency(run), input=input_rows(run),
        warnings=warnings(run), parameters=parameter_groups(run), versions=versions(run), commands=commands(run),
        align=run.evaluation.metrics["align"], has_parameters=run.provenance.parameters is not None)


# -------------------------------------------------------------------------------- what the run is


def facts(run):
    """[(name, text)] of what was run."""
    given = run.provenance.parameters or {}
    stamps = run.estimate.path.stamps
    rows = [("Recording", run.provenance.of("bag", str, run.provenance.of("node", str, None))),
            ("Truth", run.truth_bag),
            ("Estimator", given.get("estimator/type")), ("Space", given.get("estimator/space")),
            ("Association", given.get("association/type")),
            ("Data from", date(stamps[0]) if stamps[0] > DATES_FROM else None),
            ("Poses", f"{len(stamps)}, over {stamps[-1] - stamps[0]:.1f} s"),
            ("Run finished", run.provenance.of("finished", str, None)),
            ("This page written", date(datetime.datetime.now().timestamp()))]
    return [(name, text) for name, text in rows if text]


def date(seconds):
    return datetime.datetime.fromtimestamp(float(seconds), datetime.timezone.utc).strftime("%Y-%m-%d %H:%M:%S UTC")


def known_metrics(run):
    """[(group, [(title, is part of the one above, value with unit, meaning)])] of the figures that there are."""
    groups = {}
    for metric in METRICS:
        value = run.evaluation.metrics[metric.name]
        if value is not None:
            groups.setdefault(metric.group, []).append(
                (metric.title.strip(), metric.title.startswith(" "), f"{format_value(value)} {metric.unit}".strip(),
                 metric.meaning))
    return list(groups.items())


def unknown_metrics(run):
    return [metric.name for metric in METRICS if run.evaluation.metrics[metric.name] is None]


def input_rows(run):
    """[(name, text)] of what came in, what became of it, and how long that took."""
    of = run.provenance.of
    rows = [("Messages used", counts(of("messages", dict, {}))),
            ("Messages with detections", of("detection_frames", int, None)),
            ("Detections by what became of them", counts(of("detections", dict, {})))]
    for name, key, unit in (("Time per update, mean", "update_ms_mean", "ms"),
                            ("Time per update, 99th percentile", "update_ms_p99", "ms"),
                            ("Processor time", "cpu_seconds", "s"), ("Speed", "times_real_time", "times real time")):
        value = of(key, (int, float), None)
        rows.append((name, None if value is None else f"{value:.3g} {unit}" if value < 1000 else f"{value:.0f} {unit}"))
    return [(name, text) for name, text in rows if text not in (None, "")]


def counts(table):
    return ", ".join(f"{name} {count}" for name, count in table.items())


# -------------------------------------------------------------------------------- the map


def landmark_rows(run):
    """A dictionary of texts for each estimated landmark, in the order of the ids."""
    landmarks, true = run.estimate.landmarks, run.truth.landmarks
    variances = np.diagonal(landmarks.covariances, axis1=1, axis2=2)
    stds = np.sqrt(np.maximum(variances, 0.0))
    size = 2 if run.evaluation.planar else 3
    rows = []
    for i in np.argsort(landmarks.ids, kind="stable").tolist():
        j = run.evaluation.pairs.get(i)
        product = stds[i, 0] * stds[i, 1]
        error = None
        if j is not None:
            error = np.linalg.norm((run.evaluation.landmarks_in_truth[i] - true.positions[j])[:size])
        rows.append({
            "id": str(landmarks.ids[i]), "label": landmarks.labels[i], "sightings": str(landmarks.observations[i]),
            "position": [f"{value:.3f}" for value in landmarks.positions[i, :size]],
            "std": [f"{value:.3f}" for value in stds[i, :size]],
            "correlation": f"{landmarks.covariances[i, 0, 1] / product:.2f}" if product > 0.0 else "-",
            "true": "spurious" if j is None and true is not None else "-" if j is None else str(true.identities[j]),
            "error": "-" if error is None else f"{error:.3f}"})
    return rows


def missed_landmarks(run):
    """Identities of the true landmarks without an estimate."""
    if run.truth.landmarks is None:
        return []
    found = set(run.evaluation.pairs.values())
    return [str(identity) for j, identity in enumerate(run.truth.landmarks.identities.tolist()) if j not in found]


# -------------------------------------------------------------------------------- honesty


def consistency(run):
    """A sentence on the covariances, or None where nothing tells."""
    evaluation, parts = run.evaluation, []
    if evaluation.start_nees is not None and np.isfinite(evaluation.start_nees).any():
        values = evaluation.start_nees[np.isfinite(evaluation.start_nees)]
        dimension = evaluation.nees_dimension
        low, high = CHI_SQUARE_95[dimension]
        parts.append(f"The NEES of the pose, laid on the truth at the start, is {values.mean():.2f} in the mean; "
                     f"{dimension} is expected. {percent((values >= low) & (values <= high))} of the poses lie "
                     f"within its 95 % bounds ({low:.2f} to {high:.2f}), {percent(values > high)} above them, where "
                     "the covariance is too small.")
    used = run.estimate.associations.accepted & np.isfinite(run.estimate.associations.nis)
    if used.any():
        parts.append(f"The NIS of {used.sum()} matched detections is {run.estimate.associations.nis[used].mean():.2f} "
                     f"in the mean; {2 if evaluation.planar else 3} is expected without a gate.")
    if parts:
        parts.append("The errors of one run hang together over time: these are hints; a verdict takes many runs.")
    return " ".join(parts) or None


def percent(chosen):
    return f"{100.0 * np.mean(chosen):.0f} %"


def warnings(run):
    """One line each."""
    provenance, lines = run.provenance, []
    lines += [str(line) for line in provenance.of("warnings", list, [])]
    lines += [f"{count} messages refused: {reason}"
              for reason, count in provenance.of("messages_refused", dict, {}).items()
              if not any(reason in line for line in lines)]
    if provenance.parameters is None:
        lines.append("The run's folder has no parameters.yaml: its parameters are not known.")
    if run.estimate.covariances is None:
        lines.append("The run's folder has no trajectory_covariance.csv: how sure the pose was is not known.")
    errors = run.evaluation.path_errors
    if not run.truth.is_known:
        lines.append("There is no truth to compare with: errors are not known.")
    elif run.truth.path is not None and errors is None:
        lines.append("The path could not be compared: no common time with the truth, or it stays in one place.")
    elif errors is not None and errors.yaw is not None and len(errors.stamps) < len(run.estimate.path):
        lines.append(f"{len(run.estimate.path) - len(errors.stamps)} of {len(run.estimate.path)} poses have no truth "
                     "and are not in the figures.")
    if errors is not None and errors.nees is not None and not np.isfinite(errors.nees).all():
        lines.append(f"{np.sum(~np.isfinite(errors.nees))} poses with a singular covariance are not in the NEES.")
    return lines


# -------------------------------------------------------------------------------- parameters and versions


def parameter_groups(run):
    """[(group, [(key, value, None or the package's default where it is another)])]."""
    defaults = default_parameters() or {}
    groups = {}
    for name, value in (run.provenance.parameters or {}).items():
        group, _, key = name.rpartition("/")
        default = None if is_same_value(value, defaults.get(name)) else defaults.get(name, "built in")
        groups.setdefault(group, []).append((key, value, default))
    return sorted(groups.items())


def versions(run):
    """[(name, text)]."""
    of_run = [(name, str(text)) for name, text in run.provenance.of("versions", dict, {}).items()]
    return of_run + [("evaluated with", f"Python {platform.python_version()}, NumPy {np.__version__}, "
                                        f"Matplotlib {matplotlib.__version__}")]


def commands(run):
    """The lines that make run and page again, [] where what they need was not recorded."""
    bag = run.provenance.of("bag", str, None)
    if bag is None or run.provenance.parameters is None:
        return []
    evaluation = ["evaluate.py", "repeated", "--report"]
    if run.truth_bag is not None:
        evaluation += ["--truth", run.truth_bag, "--align", run.evaluation.metrics["align"]]
    return [shlex.join(["slam_replay", bag, "--config", os.path.join(run.folder, "parameters.yaml"),
                        "--out", "repeated"]), shlex.join(evaluation)]


# -------------------------------------------------------------------------------- pictures


def pictures(run):
    """{name: data URI of an SVG}."""
    with plt.rc_context(SVG_STYLE):
        figures = {}
        figures["map"] = plt.figure(figsize=(7.2, 7.0), constrained_layout=True)
        draw_map(figures["map"].add_subplot(), run.estimate, run.truth, run.evaluation, run.sigmas)
        panels = error_panels(run.evaluation)
        figures["errors"] = plt.figure(figsize=(7.2, 1.0 + 1.45 * panels), constrained_layout=True)
        draw_errors(figures["errors"].subplots(panels, 1, sharex=True), run.estimate, run.evaluation, run.sigmas)
        figures["errors"].align_ylabels()
        figures["consistency"] = plt.figure(figsize=(7.2, 2.6), constrained_layout=True)
        draw_consistency(figures["consistency"].add_subplot(), run.estimate, run.evaluation)
        return {name: svg_uri(figure) for name, figure in figures.items()}


def svg_uri(figure):
    """The figure, which is closed, as a data URI."""
    with io.BytesIO() as buffer:
        figure.savefig(buffer, format="svg", metadata={"Date": None})
        plt.close(figure)
        return "data:image/svg+xml;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
