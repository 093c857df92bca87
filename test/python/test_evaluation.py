import json
import math
import os
import unittest

import support
import numpy as np
from matplotlib.figure import Figure
from straight_run import ASSOCIATION_HEADER, COVARIANCE_HEADER, LANDMARK_HEADER, StraightRun

from slam_tools.bags import Landmarks
from slam_tools.evaluation import evaluate, nees, read_truth
from slam_tools.geometry import RigidTransform, align
from slam_tools.landmark_matching import association_accuracy, match_landmarks
from slam_tools.evaluation_plots import draw_consistency
from slam_tools.runs import Associations, majority_identities, read_estimate


def landmarks(positions, identities=None, observations=None):
    count = len(positions)
    positions = np.column_stack([positions, np.zeros(count)]) if count else np.empty((0, 3))
    return Landmarks(ids=np.arange(count), identities=np.array(identities or [-1] * count, dtype=int),
                     labels=[""] * count, positions=positions, covariances=np.tile(np.eye(3), (count, 1, 1)),
                     observations=np.array(observations or [1] * count, dtype=int))


def associations(rows):
    """rows: (identity, accepted, landmark)"""
    identities, accepted, ids = np.array(rows).T
    return Associations(stamps=np.arange(len(rows), dtype=float), identities=identities, landmarks=ids,
                        accepted=accepted.astype(bool), nis=np.full(len(rows), np.nan))


def align_planar(source, target):
    return align(source, target, planar=True)


PLACES = [(0.0, 0.0), (4.0, 0.0), (5.0, 3.0), (0.0, 3.0), (2.0, 6.0), (7.0, 7.0)]


class Matching(unittest.TestCase):
    def match(self, estimated, true, path_transform=None):
        return match_landmarks(estimated, true, path_transform, align_planar, planar=True)

    def test_by_identity_whatever_the_distance(self):
        true = landmarks(PLACES, identities=[10, 11, 12, 13, 14, 15])
        order = [3, 0, 5]
        estimated = landmarks(RigidTransform.planar(50.0, 9.0, 2.0).points(true.positions[order])[:, :2],
                              identities=[13, 10, 15])
        pairs, transform = self.match(estimated, true)
        self.assertEqual(pairs, {0: 3, 1: 0, 2: 5})
        np.testing.assert_allclose(transform.points(estimated.positions), true.positions[order], atol=1e-9)

    def test_of_two_with_one_identity_the_better_observed_matches(self):
        true = landmarks(PLACES, identities=[10, 11, 12, 13, 14, 15])
        estimated = landmarks([(0, 0), (0.1, 0), (4, 0), (8, 8)], identities=[10, 10, 11, 99],
                              observations=[3, 40, 5, 100])
        pairs, _ = self.match(estimated, true)
        self.assertEqual(pairs, {1: 0, 2: 1})

    def test_by_position_after_the_alignment_of_the_path(self):
        """The path's alignment is off by 0.3 m: the pairs correct it."""
        true = landmarks(PLACES)
        moved = RigidTransform.planar(-3.0, 1.0, 0.7)
        estimated = landmarks(moved.points(true.positions[[4, 2, 0, 1]])[:, :2].tolist() + [(30.0, 30.0)])
        back = align_planar(moved.points(true.positions), true.positions)
        off = RigidTransform(back.rotation, back.translation + [0.3, 0.0, 0.0])
        pairs, transform = self.match(estimated, true, off)
        self.assertEqual(pairs, {0: 4, 1: 2, 2: 0, 3: 1})
        np.testing.assert_allclose(transform.translation, back.translation, atol=1e-9)

    def test_a_turned_path_needs_several_rounds(self):
        """Near landmarks match first; aligned by them the far ones come within reach."""
        true = landmarks(PLACES + [(10.0, 10.0), (13.0, 8.0)])
        pairs, _ = self.match(landmarks(true.positions[:, :2]), true, RigidTransform.planar(0.0, 0.0, 0.07))
        self.assertEqual(pairs, {i: i for i in range(8)})

    def test_by_position_only_the_nearest_matches(self):
        true = landmarks(PLACES)
        estimated = landmarks([(0.3, 0.0), (0.05, 0.0), (4.0, 0.0)])
        pairs, _ = self.match(estimated, true, RigidTransform.identity())
        self.assertEqual(pairs, {1: 0, 2: 1})

    def test_by_position_without_a_path(self):
        rng = np.random.default_rng(7)
        true = landmarks(PLACES)
        for yaw in (-2.5, 0.3, 1.9):
            moved = RigidTransform.planar(12.0, -4.0, yaw).points(true.positions)[:, :2]
            moved = moved + rng.normal(0.0, 0.02, moved.shape)
            pairs, _ = self.match(landmarks(moved[[5, 1, 2, 0, 3]]), true)
            self.assertEqual(pairs, {0: 5, 1: 1, 2: 2, 3: 0, 4: 3})

    def test_mixed(self):
        """One without identity matches among the true ones that are left, not one that is taken."""
        true = landmarks(PLACES, identities=[10, 11, 12, 13, 14, 15])
        estimated = landmarks([PLACES[0], PLACES[1], (5.1, 3.0), (0.1, 0.1)], identities=[10, 11, -1, -1])
        pairs, _ = self.match(estimated, true)
        self.assertEqual(pairs, {0: 0, 1: 1, 2: 2})

    def test_nothing_to_match(self):
        self.assertEqual(self.match(landmarks([]), landmarks(PLACES)), ({}, None))
        self.assertEqual(self.match(landmarks(PLACES), landmarks([])), ({}, None))
        self.assertEqual(self.match(landmarks(PLACES[:1]), landmarks(PLACES)), ({}, None))

    def test_identity_is_the_majority_of_accepted_detections(self):
        rows = associations([(7, 1, 0), (8, 1, 0), (8, 1, 0), (7, 0, 0), (7, 0, 0), (-1, 1, 1), (9, 1, 2),
                             (6, 1, 2)])
        self.assertEqual(majority_identities(np.array([0, 1, 2, 3]), rows).tolist(), [8, -1, 6, -1])

    def test_accuracy_counts_accepted_detections_with_an_identity(self):
        true = landmarks(PLACES, identities=[10, 11, 12, 13, 14, 15])
        estimated = landmarks(PLACES[:3], identities=[10, 11, 11], observations=[9, 9, 1])
        pairs = {0: 0, 1: 1}
        rows = associations([(10, 1, 0), (10, 1, 0), (11, 1, 1), (11, 1, 2), (12, 1, 0),
                             (-1, 1, 0), (10, 0, 1)])
        self.assertAlmostEqual(association_accuracy(estimated, true, pairs, rows), 3 / 5)
        self.assertIsNone(association_accuracy(estimated, true, pairs, associations([(-1, 1, 0)])))


class Consistency(unittest.TestCase):
    def test_sampled_gaussians_have_the_degrees_of_freedom_for_mean(self):
        rng = np.random.default_rng(8)
        for dimension in (3, 6):
            roots = rng.normal(size=(4000, dimension, dimension)) + 2.0 * np.eye(dimension)
            errors = (roots @ rng.normal(size=(4000, dimension, 1)))[..., 0]
            values = nees(errors, roots @ np.swapaxes(roots, 1, 2))
            # the mean of n chi-square values has the variance 2 dof / n
            self.assertLess(abs(np.nanmean(values) - dimension), 4.0 * math.sqrt(2.0 * dimension / 4000))

    def test_singular_covariances_are_skipped(self):
        values = nees(np.ones((2, 3)), np.array([np.eye(3), np.diag([1.0, 1.0, 0.0])]))
        self.assertEqual(values[0], 3.0)
        self.assertTrue(np.isnan(values[1]))


class EndToEnd(StraightRun):
    def evaluate(self, *options):
        process = support.run_script("evaluate.py", self.folder, "--truth", self.bag, *options)
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertGreater(os.path.getsize(os.path.join(self.folder, "evaluation.png")), 20000)
        with open(os.path.join(self.folder, "evaluation.json"), encoding="utf-8") as file:
            return json.load(file, parse_constant=self.fail), process.stdout

    def start_errors(self):
        """Independently: positions as complex numbers; the first estimated pose is put on the true one."""
        k = np.arange(400)
        true = 0.05 * (k + 0.5) - 10.0 + 0j
        estimated = true + 0.1j * np.tile([1, -1, -1, 1], 100)
        return (estimated - estimated[0]) * np.exp(-1j * self.YAW_ERROR) + true[0] - true

    def test_exact_figures(self):
        metrics, text = self.evaluate()
        errors = self.start_errors()
        in_estimate = errors * np.exp(1j * self.YAW_ERROR)   # in the axes of the covariance
        expected = {
            "align": "se2",
            "ate_rmse_m": 0.1, "path_error_median_m": 0.1, "path_error_p95_m": 0.1,
            "dead_reckoning_ate_rmse_m": 0.4,
            "heading_rmse_deg": math.degrees(self.YAW_ERROR),
            "pose_nees_mean": (0.1 / self.ACROSS_STD)**2 + (self.YAW_ERROR / self.YAW_STD)**2,
            "ate_rmse_start_m": math.sqrt(np.mean(np.abs(errors)**2)),
            "pose_nees_start_mean": np.mean((in_estimate.real / self.ALONG_STD)**2
                                            + (in_estimate.imag / self.ACROSS_STD)**2),
            "landmark_rmse_m": 0.05 * math.sqrt(2.0),
            "landmark_max_m": 0.05 * math.sqrt(2.0),
            "landmarks_estimated": 5, "landmarks_true": 5, "landmarks_missed": 1, "landmarks_spurious": 1,
            "association_accuracy": 7 / 9, "association_accuracy_instant": 2 / 3,
            "path_length_m": 0.05 * 399,
            "duration_s": 39.9,
        }
        places = 0.05 * np.array([-61 - 61j, 61 - 61j, 61 + 61j, -61 + 61j])
        true_places = np.array([-3 - 3j, 3 - 3j, 3 + 3j, -3 + 3j])
        first, first_true = -9.975 + 0.1j, -9.975
        landmark_errors = (places - first) * np.exp(-1j * self.YAW_ERROR) + first_true - true_places
        expected["landmark_rmse_start_m"] = math.sqrt(np.mean(np.abs(landmark_errors)**2))
        self.assertEqual(set(metrics), set(expected))
        for name, value in expected.items():
            if isinstance(value, float):
                self.assertAlmostEqual(metrics[name], value, places=6, msg=name)
            else:
                self.assertEqual(metrics[name], value, name)
        self.assertIn("0.100 m", text)

    def test_none_compares_in_the_given_frames(self):
        metrics, _ = self.evaluate("--align", "none")
        distance = np.linalg.norm(self.MOTION.points(np.zeros(3)))
        self.assertGreater(metrics["ate_rmse_m"], distance)
        self.assertAlmostEqual(metrics["heading_rmse_deg"], math.degrees(0.8 - self.YAW_ERROR), places=6)
        self.assertGreater(metrics["landmark_rmse_m"], 1.0)

    def test_the_picture_judges_a_given_path_by_its_own_covariance(self):
        estimate, truth = read_estimate(self.folder), read_truth(self.bag)
        for alignment, figure, label in (("none", "pose_nees_mean", "NEES, as given"),
                                         ("se2", "pose_nees_start_mean", "NEES, from the start")):
            panel = Figure().subplots()
            evaluation = evaluate(estimate, truth, alignment)
            draw_consistency(panel, estimate, evaluation)
            self.assertEqual(panel.get_ylabel(), label)
            self.assertAlmostEqual(panel.lines[0].get_ydata().mean() / evaluation.metrics[figure], 1.0, places=6)

    def test_space(self):
        """The straight line leaves the roll about it open: only the landmarks can be aligned."""
        metrics, _ = self.evaluate("--align", "se3")
        self.assertIsNone(metrics["ate_rmse_m"])
        self.assertIsNone(metrics["pose_nees_mean"])   # singular in space
        self.assertAlmostEqual(metrics["landmark_rmse_m"], 0.05 * math.sqrt(2.0), places=6)

    def test_positions_from_satellites(self):
        self.write_truth(fix_only=True)
        metrics, _ = self.evaluate()
        self.assertAlmostEqual(metrics["ate_rmse_m"], 0.1, delta=0.05)   # the estimate is interpolated
        for name in ("heading_rmse_deg", "pose_nees_mean", "ate_rmse_start_m", "pose_nees_start_mean"):
            self.assertIsNone(metrics[name], name)

    def test_a_robust_alignment_leaves_the_outliers_alone(self):
        self.write_truth(positions_with_outliers=True)
        least_squares, _ = self.evaluate()
        self.assertGreater(least_squares["path_error_median_m"], 0.4)
        metrics, _ = self.evaluate("--align", "robust")
        self.assertEqual(metrics["align"], "robust")
        self.assertIsNone(metrics["heading_rmse_deg"])   # a quaternion of zero: positions only
        self.assertLess(metrics["path_error_median_m"], 0.1)
        self.assertLess(metrics["path_error_p95_m"], 0.15)
        self.assertGreater(metrics["ate_rmse_m"], 3.0)   # of all, the outliers too

    def test_truth_of_landmarks_alone(self):
        self.write_truth(with_path=False)
        metrics, _ = self.evaluate()
        self.assertIsNone(metrics["ate_rmse_m"])
        self.assertAlmostEqual(metrics["landmark_rmse_m"], 0.05 * math.sqrt(2.0), places=6)
        self.assertAlmostEqual(metrics["association_accuracy"], 7 / 9)

    def test_truth_of_the_path_alone_and_no_optional_files(self):
        self.write_truth(with_landmarks=False)
        os.remove(os.path.join(self.folder, "trajectory_covariance.csv"))
        os.remove(os.path.join(self.folder, "dead_reckoning.tum"))
        os.remove(os.path.join(self.folder, "associations_instant.csv"))
        metrics, _ = self.evaluate()
        self.assertAlmostEqual(metrics["ate_rmse_m"], 0.1, places=6)
        for name in ("landmark_rmse_m", "landmarks_true", "landmarks_missed", "landmarks_spurious",
                     "association_accuracy", "association_accuracy_instant", "pose_nees_mean",
                     "dead_reckoning_ate_rmse_m"):
            self.assertIsNone(metrics[name], name)
        self.assertEqual(metrics["landmarks_estimated"], 5)

    def test_degenerate_runs_give_null(self):
        support.write(self.folder, "trajectory.tum", support.tum_line(1001.0, 0.0, 0.0, 0.0))
        support.write(self.folder, "landmarks.csv", LANDMARK_HEADER)
        support.write(self.folder, "associations.csv", ASSOCIATION_HEADER)
        os.remove(os.path.join(self.folder, "trajectory_covariance.csv"))
        os.remove(os.path.join(self.folder, "dead_reckoning.tum"))
        os.remove(os.path.join(self.folder, "associations_instant.csv"))
        metrics, _ = self.evaluate()
        for name in ("ate_rmse_m", "landmark_rmse_m", "landmark_max_m", "association_accuracy"):
            self.assertIsNone(metrics[name], name)
        self.assertEqual((metrics["landmarks_estimated"], metrics["landmarks_missed"]), (0, 5))
        # a run at another time than the truth
        support.write(self.folder, "trajectory.tum",
                      support.tum_line(1.0, 0, 0, 0) + support.tum_line(2.0, 1, 0, 0))
        metrics, _ = self.evaluate()
        self.assertIsNone(metrics["ate_rmse_m"])

    def test_bad_input_is_one_line(self):
        good = {}
        for name in os.listdir(self.folder):
            with open(os.path.join(self.folder, name), encoding="utf-8") as file:
                good[name] = file.read()
        cases = [
            ("trajectory.tum", None, ("trajectory.tum", "no such file")),
            ("trajectory.tum", "", ("trajectory.tum", "empty")),
            ("trajectory.tum", "# t x y\n", ("trajectory.tum", "no poses")),
            ("trajectory.tum", "1 0 0 0 0 0 0 1\n2 0 0 0\n", ("trajectory.tum:2", "8 finite numbers")),
            ("trajectory.tum", "1 0 0 nan 0 0 0 1\n", ("trajectory.tum:1", "nan")),
            ("trajectory.tum", "1 0 0 0 0 0 0 0\n", ("trajectory.tum", "quaternion", "norm 0")),
            ("trajectory.tum", "1 1e300 0 0 0 0 0 1\n", ("trajectory.tum:1", "1e300", "at most 1e+12")),
            ("trajectory_covariance.csv", "t,a\n", ("trajectory_covariance.csv:1", "header")),
            ("trajectory_covariance.csv", COVARIANCE_HEADER, ("trajectory_covariance.csv", "(0)", "(400)")),
            ("landmarks.csv", None, ("landmarks.csv", "no such file")),
            ("landmarks.csv", "id,x\n", ("landmarks.csv:1", "header")),
            ("landmarks.csv", LANDMARK_HEADER + "0,red,1\n", ("landmarks.csv:2", "12 are needed")),
            ("landmarks.csv", LANDMARK_HEADER + "0,red,1,?,0,1,0,0,1,0,1,5\n",
             ("landmarks.csv:2", "y is '?'")),
            ("landmarks.csv", LANDMARK_HEADER + "0,red,1,1e300,0,1,0,0,1,0,1,5\n",
             ("landmarks.csv:2", "y is 1e+300", "at most 1e+12")),
            ("landmarks.csv", LANDMARK_HEADER + 2 * "0,red,1,1,0,1,0,0,1,0,1,5\n", ("landmark 0", "twice")),
            ("associations.csv", ASSOCIATION_HEADER + "1,0,,matched,0,\n",
             ("associations.csv:2", "source_id")),
        ]
        for name, text, expected in cases:
            if text is None:
                os.remove(os.path.join(self.folder, name))
            else:
                support.write(self.folder, name, text)
            process = support.run_script("evaluate.py", self.folder, "--truth", self.bag)
            support.assert_one_line_error(self, process, *expected)
            support.write(self.folder, name, good[name])
        self.assertEqual(sorted(os.listdir(self.folder)), sorted(good))

        text = support.write(os.path.dirname(self.folder), "text.bag", "no bag")
        self.write_truth(with_path=False, with_landmarks=False)
        for arguments, expected in [
                ((self.folder, "--truth", self.bag), ("holds no truth",)),
                ((self.folder, "--truth", text), ("text.bag", "not a readable bag")),
                ((self.folder, "--truth", self.bag + ".none"), ("truth.bag.none", "No such file")),
                ((self.folder + "x", "--truth", self.bag), ("runx", "no such folder")),
                ((self.folder,), ("--truth",)),
                ((self.folder + "x",), ("runx", "no such folder")),
                ((self.folder, "--truth", self.bag, "--align", "sim3"), ("sim3",)),
                ((self.folder, "--truth", self.bag, "--title", "A"), ("--title", "--report")),
                ((self.folder, "--truth", self.bag, "--sigmas", "0"), ("--sigmas",))]:
            support.assert_one_line_error(self, support.run_script("evaluate.py", *arguments), *expected)

    def test_a_truth_too_far_away_to_calculate_with_is_one_line(self):
        for options, topic in [({"with_landmarks": False}, "/ground_truth/pose"),
                               ({"with_path": False}, "/ground_truth/landmarks")]:
            self.write_truth(size=1e300, **options)
            process = support.run_script("evaluate.py", self.folder, "--truth", self.bag)
            support.assert_one_line_error(self, process, "truth.bag", "entry 1", topic, "1e+12")


if __name__ == "__main__":
    unittest.main()
