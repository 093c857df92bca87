import math
import os
import re
import tempfile
import unittest

import support
import numpy as np

from slam_tools.circles import CylinderModel, find_cylinders, fit_circle, is_cylinder

MODEL = CylinderModel()
RAYS, RANGE_MAX = 360, 3.5
ANGLES = np.radians(np.arange(RAYS))


def scan(cylinders=(), walls=(), noise=None):
    """Ranges of a full turn; cylinders: (x, y, radius); walls: segments ((x, y), (x, y))."""
    ranges = np.full(RAYS, np.inf)
    for i, angle in enumerate(ANGLES):
        ray = np.array([math.cos(angle), math.sin(angle)])
        for x, y, radius in cylinders:
            along, across = ray @ (x, y), ray[0] * y - ray[1] * x
            if along > 0.0 and abs(across) < radius:
                ranges[i] = min(ranges[i], along - math.sqrt(radius**2 - across**2))
        for a, b in np.array(walls, dtype=float).reshape(-1, 2, 2):
            matrix = np.column_stack([ray, a - b])
            if abs(np.linalg.det(matrix)) > 1e-9:
                distance, share = np.linalg.solve(matrix, a)
                if distance > 0.0 and 0.0 <= share <= 1.0:
                    ranges[i] = min(ranges[i], distance)
    if noise is not None:
        ranges = ranges + noise
    ranges[ranges > RANGE_MAX] = np.inf
    return ranges


def find(ranges, model=MODEL):
    return find_cylinders(ranges, 0.0, math.radians(1.0), 0.12, RANGE_MAX, model)


class Fit(unittest.TestCase):
    def test_is_exact_without_noise(self):
        angles = np.radians(np.linspace(100, 260, 12))
        points = np.array([2.0, 0.5]) + 0.15 * np.column_stack([np.cos(angles), np.sin(angles)])
        circle = fit_circle(points, MODEL)
        np.testing.assert_allclose(circle.center, [2.0, 0.5], atol=1e-6)
        self.assertAlmostEqual(circle.radius, 0.15, places=6)

    def test_is_unbiased_and_its_covariance_is_honest(self):
        """Radii drawn as the model assumes; errors judged by the covariance of the fit."""
        rng = np.random.default_rng(5)
        errors, squared = [], []
        for _ in range(600):
            radius = rng.normal(MODEL.radius_mean, MODEL.radius_std)
            if not 0.11 < radius < 0.19:
                continue
            center = rng.uniform(0.8, 2.5) * np.array([math.cos(1.0), math.sin(1.0)])
            ranges = scan([(*center, radius)], noise=rng.normal(0.0, MODEL.range_std, RAYS))
            hit = np.isfinite(ranges)
            points = ranges[hit, None] * np.column_stack([np.cos(ANGLES[hit]), np.sin(ANGLES[hit])])
            circle = fit_circle(points, MODEL)
            error = circle.center - center
            errors.append(error)
            squared.append(error @ np.linalg.solve(circle.covariance[:2, :2], error))
        self.assertGreater(len(errors), 400)
        self.assertLess(np.abs(np.mean(errors, axis=0)).max(), 0.003)
        self.assertLess(np.mean(squared), 2.4)      # 2 expected; the truncated radii make it a little less
        self.assertGreater(np.mean(squared), 1.2)


class Finding(unittest.TestCase):
    def test_finds_free_cylinders_also_across_the_ends_of_the_scan(self):
        places = [(1.0, 0.0, 0.15), (-1.5, 0.8, 0.12), (0.2, -2.0, 0.18)]
        found = find(scan(places))
        self.assertEqual(len(found), 3)
        for x, y, radius in places:
            nearest = min(found, key=lambda circle: np.linalg.norm(circle.center - (x, y)))
            np.testing.assert_allclose(nearest.center, (x, y), atol=0.02)
            self.assertAlmostEqual(nearest.radius, radius, delta=0.02)

    def test_refuses_walls_and_corners(self):
        rng = np.random.default_rng(6)
        scenes = {
            "wall": [((2, -2), (2, 2))],
            "short wall": [((1.5, -0.12), (1.5, 0.12))],
            "hexagon from inside": [((2 * math.cos(a), 2 * math.sin(a)),
                                     (2 * math.cos(a + math.pi / 3), 2 * math.sin(a + math.pi / 3)))
                                    for a in np.arange(6) * math.pi / 3],
            "corner towards the scanner": [((2.6, -0.6), (2.2, 0)), ((2.2, 0), (2.6, 0.6))],
            "corner away from the scanner": [((2.2, -0.3), (2.5, 0)), ((2.5, 0), (2.2, 0.3))],
        }
        for name, walls in scenes.items():
            for _ in range(20):
                ranges = scan(walls=walls, noise=rng.normal(0.0, MODEL.range_std, RAYS))
                self.assertEqual(find(ranges), [], name)

    def test_refuses_the_wrong_size_the_hidden_and_the_too_far(self):
        self.assertEqual(find(scan([(1.5, 0.0, 0.35)])), [])
        self.assertEqual(find(scan([(1.0, 0.0, 0.04)])), [])
        self.assertEqual(find(scan([(3.45, 0.0, 0.15)])), [])
        partly_hidden = [((0.8, -0.4), (0.8, -0.065))]   # of the 15 rays that meet the cylinder, two
        self.assertEqual(len(find(scan([(1.5, 0.0, 0.15)]))), 1)
        self.assertEqual(find(scan([(1.5, 0.0, 0.15)], walls=partly_hidden)), [])

    def test_refuses_the_hollow_side_the_ragged_and_the_short(self):
        def judge(bearings, noise=0.0):
            angles = np.radians(bearings)
            points = np.column_stack([1.5 + 0.15 * np.cos(angles), 0.15 * np.sin(angles)])
            points[:, 0] += noise * np.resize([1, -1], len(points))
            return is_cylinder(fit_circle(points, MODEL), points, RANGE_MAX, MODEL)

        self.assertTrue(judge(np.linspace(110, 250, 12)))
        self.assertTrue(judge(np.linspace(110, 250, 12), noise=0.01))
        self.assertFalse(judge(np.linspace(-70, 70, 12)))               # from inside
        self.assertFalse(judge(np.linspace(110, 250, 12), noise=0.03))
        self.assertFalse(judge(np.linspace(150, 210, 12)))

    def test_points_in_a_row_are_no_crash(self):
        for distance in (0.2, 1.5, 3.0):
            for width in (0.1, 0.3, 0.35, 1.0):
                y = np.linspace(-0.5 * width, 0.5 * width, 6)
                fit_circle(np.column_stack([np.full(6, distance), y]), MODEL)

    def test_an_empty_scan_has_none(self):
        self.assertEqual(find(np.full(RAYS, np.inf)), [])
        self.assertEqual(find(np.full(RAYS, np.nan)), [])


class Script(unittest.TestCase):
    @unittest.skipUnless(support.data("bags", "turtlebot3_world.bag"),
                         "no SLAM_DATA/bags/turtlebot3_world.bag")
    def test_real_bag(self):
        import rosbag
        source = support.data("bags", "turtlebot3_world.bag")
        with tempfile.TemporaryDirectory() as folder:
            out_path = os.path.join(folder, "out.bag")
            process = support.run_script("turtlebot3_truth.py", source, out_path)
            self.assertEqual(process.returncode, 0, process.stderr)
            count, false, along, across, squared = re.search(
                r"(\d+) detections of cylinders, (\d+) false ones; error along the ray (\S+) \+- .* mm, "
                r"across it (\S+) \+- .* distance (\S+)", process.stdout).groups()
            self.assertGreater(int(count), 2000)
            self.assertEqual(int(false), 0)
            self.assertLess(abs(float(along)), 20.0)
            self.assertLess(abs(float(across)), 20.0)
            self.assertLess(abs(float(squared) - 2.0), 0.5)
            with rosbag.Bag(source) as before, rosbag.Bag(out_path) as after:
                for topic in ("/odom", "/imu"):   # copied as they are
                    a = [(t, m[1]) for _, m, t in before.read_messages(topic, raw=True)]
                    b = [(t, m[1]) for _, m, t in after.read_messages(topic, raw=True)]
                    self.assertEqual(a, b)
                headers = [str(m.header) for _, m, _ in before.read_messages("/scan")]
                arrays = [m for _, m, _ in after.read_messages("/landmarks")]
                self.assertEqual([str(m.header) for m in arrays], headers)
                detection = next(d for m in arrays for d in m.detections)
                self.assertEqual((detection.id, detection.label), (-1, ""))
                self.assertGreater(min(detection.covariance[0], detection.covariance[4]), 0.0)
                poses = [m for _, m, _ in after.read_messages("/ground_truth/pose")]
                self.assertEqual({m.header.frame_id for m in poses}, {"map"})
                self.assertEqual(len(poses), before.get_message_count("/odom"))
                _, true_map, _ = next(after.read_messages("/ground_truth/landmarks"))
                self.assertEqual([l.id for l in true_map.landmarks], list(range(9)))

    def test_bad_input_is_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            text = support.write(folder, "text.bag", "no bag\n")
            out_path = os.path.join(folder, "out.bag")
            process = support.run_script("turtlebot3_truth.py", text, out_path)
            support.assert_one_line_error(self, process, "text.bag", "not a readable bag")
            process = support.run_script("turtlebot3_truth.py", os.path.join(folder, "none.bag"), out_path)
            support.assert_one_line_error(self, process, "none.bag", "No such file")
            self.assertEqual(os.listdir(folder), ["text.bag"])


if __name__ == "__main__":
    unittest.main()
