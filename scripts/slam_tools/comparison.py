"""Several runs side by side: what they are called, what they were run with, and how well they did."""
import os
from dataclasses import dataclass
from typing import Any, Dict, List, Optional

from .evaluation import Evaluation
from .metrics import METRICS, format_value
from .provenance import Provenance, is_same_value
from .runs import Estimate

NOT_SET = "-"   # stands for a parameter that a run's file does not name
COLUMNS = (("ate_rmse_m", "path ATE (m)"), ("heading_rmse_deg", "heading (deg)"), ("landmark_rmse_m", "landmarks (m)"),
           ("pose_nees_start_mean", "pose NEES"), ("landmarks_estimated", "mapped"), ("landmarks_missed", "missed"),
           ("landmarks_spurious", "spurious"), ("association_accuracy", "right"))
TIMES = (("update_ms_mean", "ms/update"), ("cpu_seconds", "cpu (s)"))


@dataclass(frozen=True)
class ComparedRun:
    name: str
    folder: str
    estimate: Estimate
    provenance: Provenance
    evaluation: Evaluation


def short_names(folders) -> List[str]:
    """The shortest ends of the paths that tell the folders apart, in their order."""
    parts = [os.path.realpath(folder).strip(os.sep).split(os.sep) for folder in folders]
    names = []
    for own in parts:
        size = next((size for size in range(1, len(own) + 1)
                     if sum(other[-size:] == own[-size:] for other in parts) == 1), len(own))
        names.append(os.sep.join(own[-size:]))
    return names


def differing_parameters(runs) -> Dict[str, List[Optional[str]]]:
    """{group/key: its text in each run} of the parameters that are not alike in all runs.

    None where a run's file does not name it. Runs whose parameters were not recorded are None throughout, and make
    nothing differ.
    """
    recorded = [run.provenance.parameters for run in runs if run.provenance.parameters is not None]
    names = sorted({name for parameters in recorded for name in parameters})
    return {name: [(run.provenance.parameters or {}).get(name) for run in runs] for name in names
            if any(not is_same_value(recorded[0].get(name), parameters.get(name)) for parameters in recorded)}


def table(runs) -> List[str]:
    """The runs as lines of text, one each, and below them what they were run with where that differs."""
    heads = ["run"] + [head for _, head in COLUMNS + TIMES]
    rows = []
    for run in runs:
        figures = [format_value(run.evaluation.metrics[name]) for name, _ in COLUMNS]
        times = [run.provenance.of(name, (int, float), None) for name, _ in TIMES]
        rows.append([run.name] + figures + [NOT_SET if value is None else f"{value:.3g}" if value < 1000.0
                                            else f"{value:.0f}" for value in times])
    lines = _aligned([heads] + rows)
    reckoned = {value for value in (run.evaluation.metrics["dead_reckoning_ate_rmse_m"] for run in runs)
                if value is not None}
    if len(reckoned) == 1:
        lines.append(f"dead reckoning: path ATE {reckoned.pop():.3f} m")
    differing = differing_parameters(runs)
    if differing:
        lines += ["", "parameters that differ"]
        lines += _aligned([[name] + [NOT_SET if text is None else text for text in texts]
                           for name, texts in [("", [run.name for run in runs]), *differing.items()]])
    return lines


def to_json(runs, truth_bag, alignment) -> Dict[str, Any]:
    """The figures of all runs; null where unknown."""
    differing = differing_parameters(runs)
    return {"truth": truth_bag, "align": alignment, "runs": [
        {"name": run.name, "folder": run.folder,
         "parameters_that_differ": {name: texts[i] for name, texts in differing.items()},
         **{metric.name: run.evaluation.metrics[metric.name] for metric in METRICS},
         **{name: run.provenance.of(name, (int, float), None) for name, _ in TIMES}}
        for i, run in enumerate(runs)]}


def _aligned(rows):
    """Lines of columns: the first to the left, the others to the right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return ["  ".join([row[0].ljust(widths[0])] + [text.rjust(width) for text, width in zip(row[1:], widths[1:])]
                      ).rstrip() for row in rows]
