#!/usr/bin/python3
"""Puts several runs of one recording side by side: estimators, or settings.

Each DIR is what slam_replay or record_run.py wrote. Prints one line of figures for each run and the parameters in which
they differ, and draws the paths over the truth and the errors over time. Truth, alignment, matching and figures are
those of evaluate.py: see its help.
"""
import json
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

from slam_tools import cli
from slam_tools.comparison import ComparedRun, short_names, table, to_json
from slam_tools.evaluation import ALIGNMENTS, evaluate, read_truth
from slam_tools.provenance import read_provenance
from slam_tools.runs import read_estimate

EPILOG = """\
columns
  path ATE, heading, landmarks  root mean square errors of the path, its yaw and the matched landmarks
  pose NEES                     mean, laid on the truth at the start; 3 in the plane and 6 in space are expected
  mapped, missed, spurious      landmarks of the map, true ones without an estimate, estimates without a true one
  right                         share of the accepted detections with an identity that went to the right landmark
  ms/update, cpu (s)            mean time per message with detections; processor time of the whole run
--json also has the other figures of evaluation.json; null where unknown.

example
  for type in ekf invariant_ekf fastslam2; do
    slam_replay run.bag --set estimator/type=$type --out runs/$type
  done
  compare.py runs/ekf runs/invariant_ekf runs/fastslam2 --truth run.bag
"""


def main():
    parser = cli.ArgumentParser(description=__doc__, epilog=EPILOG)
    parser.add_argument("folders", metavar="DIR", nargs="+", help="folder of a run, two or more")
    parser.add_argument("--truth", metavar="BAG", required=True, help="bag with the ground truth")
    parser.add_argument("--align", choices=ALIGNMENTS, default="se2", help="as evaluate.py (default: %(default)s)")
    parser.add_argument("--name", metavar="TEXT", dest="names", action="append",
                        help="of a run, in their order, once for each; default: the ends of the paths that differ")
    parser.add_argument("--picture", metavar="FILE.png", default="comparison.png",
                        help="where to draw (default: %(default)s)")
    parser.add_argument("--json", metavar="FILE", help="write the figures there")
    arguments = parser.parse_args()
    if len(arguments.folders) < 2:
        parser.error("one folder given; two or more are needed")
    repeated = [folder for i, folder in enumerate(arguments.folders)
                if os.path.realpath(folder) in map(os.path.realpath, arguments.folders[:i])]
    if repeated:
        parser.error(f"{repeated[0]} is given twice; each run once is needed")
    names = arguments.names or short_names(arguments.folders)
    if len(names) != len(arguments.folders) or len(set(names)) != len(names):
        parser.error(f"--name is given {len(names)} times; {len(arguments.folders)} different ones are needed")

    with cli.atomic_output(arguments.picture) as picture:   # a place that cannot be written to shows at once
        truth = read_truth(arguments.truth)
        runs = []
        for name, folder in zip(names, cli.progress(arguments.folders, len(names), "Comparing")):
            estimate = read_estimate(folder)
            runs.append(ComparedRun(name, folder, estimate, read_provenance(folder),
                                    evaluate(estimate, truth, arguments.align)))
        from slam_tools.comparison_plot import draw_comparison   # late: matplotlib takes a while to load
        draw_comparison(picture, runs, truth)
        if arguments.json:
            with cli.atomic_output(arguments.json) as path, open(path, "w", encoding="utf-8") as file:
                json.dump(to_json(runs, arguments.truth, arguments.align), file, indent=2, allow_nan=False)
                file.write("\n")
    print("\n".join(table(runs)))
    print(f"\n{arguments.picture}")


if __name__ == "__main__":
    cli.run(main)
