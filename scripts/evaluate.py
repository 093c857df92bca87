#!/usr/bin/python3
"""Compares what slam_replay or record_run.py wrote to DIR with the truth in a bag.

Prints a table and writes DIR/evaluation.json and DIR/evaluation.png; with --report also DIR/report.html, a page with
the figures, the map, the errors, the parameters and the warnings that can be handed in: one file, no network. A report
needs no truth; without it errors are not known.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

from slam_tools import cli
from slam_tools.evaluation import ALIGNMENTS, NO_TRUTH, evaluate, read_truth
from slam_tools.metrics import definitions, table, write_metrics
from slam_tools.provenance import read_provenance
from slam_tools.runs import read_estimate

DEFINITIONS = """\
truth
  The path is /ground_truth/pose (geometry_msgs/PoseStamped), interpolated linearly at the stamps of the
  estimate; stamps outside of it or in a gap longer than 0.5 s are skipped. Without it the first topic of
  sensor_msgs/NavSatFix gives positions, east, north and up of the first fix. Where there are positions only
  (also /ground_truth/pose with quaternions of zero), the estimate is interpolated at their stamps. The
  landmarks are the last message on /ground_truth/landmarks (kinect_ekf_slam/LandmarkMap); identity is
  source_id, or else id.

alignment
  se2     least-squares rigid transform in the plane (Umeyama 1991, without scale); errors in x, y and yaw
          (default)
  se3     the same in space; errors in x, y, z and the rotation
  robust  as se2, but with the smallest sum of the distances, not of their squares: for a truth with
          outliers, such as a GPS has
  none    compares in the given frames; in the plane when the estimate stays in it, else in space
  Path, dead reckoning and landmarks are aligned each for itself, landmarks by their matched pairs. The
  _start_ figures are not fitted: the first estimated pose is put on the true pose of that time, and nothing
  else is done.

landmarks
  A landmark's identity is the source_id that most of its accepted detections (matched, created) carried; it
  matches the true landmark of that identity. Of several with one identity the one with most observations
  matches, the others are spurious. Landmarks without identity match as mutual nearest neighbours within 0.5 m
  among the true ones that are left, after the alignment of the path (without a true path: after the alignment
  that brings most of them together), again after the alignment by the pairs, until the pairs stay.

evaluation.json, null where unknown
"""


def main():
    parser = cli.ArgumentParser(description=__doc__, epilog=DEFINITIONS + definitions())
    parser.add_argument("folder", metavar="DIR",
                        help="folder that slam_replay wrote; gets evaluation.json and evaluation.png")
    parser.add_argument("--truth", metavar="BAG", help="bag with the ground truth; only a report goes without")
    parser.add_argument("--align", choices=ALIGNMENTS, default="se2",
                        help="how the estimate is brought into the frame of the truth (default: %(default)s)")
    parser.add_argument("--sigmas", metavar="N", type=float, default=3.0,
                        help="size of the bands and ellipses in the picture (default: %(default)g)")
    parser.add_argument("--report", action="store_true", help="also write DIR/report.html")
    parser.add_argument("--title", metavar="TEXT", help="heading of the report (default: the name of DIR)")
    arguments = parser.parse_args()
    if not 0.0 < arguments.sigmas <= 100.0:
        parser.error(f"--sigmas is {arguments.sigmas:g}; a number above 0, at most 100, is needed")
    if arguments.title is not None and not arguments.report:
        parser.error("--title is that of a report; --report is needed")
    estimate = read_estimate(arguments.folder)   # a DIR that is none is told before the truth that is missing too
    if arguments.truth is None and not arguments.report:
        parser.error("--truth BAG is needed; only --report goes without")
    provenance = read_provenance(arguments.folder) if arguments.report else None
    truth = NO_TRUTH if arguments.truth is None else read_truth(arguments.truth)
    evaluation = evaluate(estimate, truth, arguments.align)
    if arguments.truth is not None:   # else what an earlier evaluation found stays
        write_metrics(evaluation.metrics, os.path.join(arguments.folder, "evaluation.json"))
        from slam_tools.evaluation_plots import draw_evaluation   # late: matplotlib takes a while to load
        with cli.atomic_output(os.path.join(arguments.folder, "evaluation.png")) as path:
            draw_evaluation(path, estimate, truth, evaluation, arguments.sigmas)
    if arguments.report:
        from slam_tools.report import Run, write_report
        write_report(os.path.join(arguments.folder, "report.html"),
                     Run(arguments.folder, estimate, provenance, truth, arguments.truth, evaluation,
                         arguments.sigmas), arguments.title)
    print("\n".join(table(evaluation.metrics)))


if __name__ == "__main__":
    cli.run(main)
