import unittest

import support  # noqa: F401  (makes the tools importable)
import numpy as np

from slam_tools.geometry import (Interpolation, Path, RigidTransform, align, align_robustly,
                                 enu_from_geodetic, integrate_arcs, quaternion_from_yaw,
                                 quaternion_of_rotation, quaternion_of_rotation_vector,
                                 rotation_of_quaternion, rotation_vector_of_quaternion, wrap_angle,
                                 yaw_of_quaternion)


def random_quaternion(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


class Rotations(unittest.TestCase):
    def test_angles_are_wrapped(self):
        np.testing.assert_allclose(wrap_angle([0.0, 3.5, -3.5, 7.0]),
                                   [0.0, 3.5 - 2 * np.pi, 2 * np.pi - 3.5, 7.0 - 2 * np.pi])

    def test_conversions_are_inverse_to_each_other(self):
        rng = np.random.default_rng(1)
        for _ in range(50):
            q = random_quaternion(rng)
            same = quaternion_of_rotation(rotation_of_quaternion(q))
            self.assertAlmostEqual(abs(same @ q), 1.0, places=12)
            vector = rng.uniform(-1.8, 1.8, size=3)   # shorter than pi
            np.testing.assert_allclose(
                rotation_vector_of_quaternion(quaternion_of_rotation_vector(vector)), vector, atol=1e-12)

    def test_yaw_is_that_of_the_quaternion(self):
        yaw = np.linspace(-3.1, 3.1, 23)
        np.testing.assert_allclose(yaw_of_quaternion(quaternion_from_yaw(yaw)), yaw, atol=1e-12)


class Alignment(unittest.TestCase):
    def test_recovers_a_planar_transform(self):
        rng = np.random.default_rng(2)
        for yaw in (-3.0, -0.4, 0.0, 1.2, 3.1):
            known = RigidTransform.planar(3.0, -2.0, yaw)
            points = rng.normal(size=(20, 3))
            found = align(points, known.points(points), planar=True)
            np.testing.assert_allclose(found.rotation, known.rotation, atol=1e-12)
            np.testing.assert_allclose(found.translation, known.translation, atol=1e-12)

    def test_recovers_a_spatial_transform(self):
        rng = np.random.default_rng(3)
        for _ in range(20):
            known = RigidTransform(rotation_of_quaternion(random_quaternion(rng)), rng.normal(size=3))
            points = rng.normal(size=(15, 3))
            found = align(points, known.points(points), planar=False)
            np.testing.assert_allclose(found.rotation, known.rotation, atol=1e-12)
            np.testing.assert_allclose(found.translation, known.translation, atol=1e-12)

    def test_never_mirrors(self):
        rng = np.random.default_rng(4)
        for planar in (True, False):
            points = rng.normal(size=(20, 3))
            found = align(points, points * [1.0, -1.0, 1.0], planar)
            self.assertAlmostEqual(np.linalg.det(found.rotation), 1.0, places=12)

    def test_leaves_height_alone_in_the_plane(self):
        points = np.array([[0.0, 0.0, 5.0], [1.0, 0.0, 6.0], [0.0, 2.0, 7.0]])
        found = align(points, points + [1.0, 2.0, 30.0], planar=True)
        np.testing.assert_allclose(found.translation, [1.0, 2.0, 0.0], atol=1e-12)

    def test_is_undetermined_for_too_few_or_degenerate_points(self):
        line = np.outer(np.arange(5.0), [1.0, 2.0, 3.0])
        self.assertIsNone(align(line[:1], line[:1], planar=True))
        self.assertIsNone(align(line[:2], line[:2], planar=False))
        self.assertIsNone(align(np.ones((9, 3)), np.ones((9, 3)), planar=True))
        self.assertIsNotNone(align(line, line, planar=True))
        self.assertIsNone(align(line, line, planar=False))

    def test_outliers_hardly_pull_a_robust_one(self):
        rng = np.random.default_rng(5)
        known = RigidTransform.planar(300.0, -20.0, 2.0)
        points = rng.uniform(-100.0, 100.0, size=(1000, 3)) * [1.0, 1.0, 0.0]
        seen = known.points(points) + rng.normal(size=points.shape) * [0.5, 0.5, 0.0]
        seen[:200] += [60.0, 30.0, 0.0]   # all to one side

        def worst_error(found):
            return np.linalg.norm(found.points(points) - known.points(points), axis=1).max()

        self.assertGreater(worst_error(align(points, seen, planar=True)), 10.0)
        self.assertLess(worst_error(align_robustly(points, seen, planar=True)), 0.4)

    def test_a_robust_one_is_exact_and_undetermined_as_the_other(self):
        known = RigidTransform.planar(3.0, -2.0, 1.2)
        points = np.random.default_rng(6).normal(size=(20, 3)) * [1.0, 1.0, 0.0]
        found = align_robustly(points, known.points(points), planar=True)
        np.testing.assert_allclose(found.translation, known.translation, atol=1e-9)
        self.assertIsNone(align_robustly(np.ones((9, 3)), np.ones((9, 3)), planar=True))

    def test_covariances_turn_with_the_frame(self):
        quarter_turn = RigidTransform.planar(0.0, 0.0, np.pi / 2)
        turned = quarter_turn.covariances(np.diag([4.0, 1.0, 9.0, 0.4, 0.1, 0.9]))
        np.testing.assert_allclose(turned, np.diag([1.0, 4.0, 9.0, 0.1, 0.4, 0.9]), atol=1e-12)


class Interpolating(unittest.TestCase):
    def test_positions_are_linear_and_headings_go_round_the_circle(self):
        path = Path(np.array([0.0, 0.4]), np.array([[0.0, 0.0, 0.0], [4.0, 8.0, 0.0]]),
                    quaternion_from_yaw(np.array([3.0, -3.0])))
        valid, between = path.at(np.array([0.1, 0.2]), max_gap=0.5)
        self.assertTrue(valid.all())
        np.testing.assert_allclose(between.positions, [[1.0, 2.0, 0.0], [2.0, 4.0, 0.0]], atol=1e-12)
        short_way = 2 * np.pi - 6.0
        np.testing.assert_allclose(wrap_angle(yaw_of_quaternion(between.quaternions) - 3.0),
                                   [0.25 * short_way, 0.5 * short_way], atol=1e-12)

    def test_gaps_and_the_outside_are_skipped_but_samples_are_not(self):
        samples = np.array([0.0, 0.3, 1.0, 1.2])
        stamps = np.array([-0.1, 0.0, 0.1, 0.3, 0.5, 1.0, 1.1, 1.2, 1.3])
        found = Interpolation.of(samples, stamps, max_gap=0.5)
        self.assertEqual(found.valid.tolist(), [False, True, True, True, False, True, True, True, False])

    def test_of_repeated_stamps_the_last_counts(self):
        positions = np.array([[0.0] * 3, [1.0] * 3, [2.0] * 3])
        path = Path.in_time_order(np.array([2.0, 1.0, 2.0]), positions, None)
        self.assertEqual(path.stamps.tolist(), [1.0, 2.0])
        self.assertEqual(path.positions[:, 0].tolist(), [1.0, 2.0])


class DeadReckoning(unittest.TestCase):
    def test_arcs_are_exact(self):
        """Four quarters of a circle of radius 2, each in one step, then straight ahead."""
        poses = integrate_arcs(np.array([1.0, 1.0, 1.0, 1.0, 0.5]), np.array([np.pi] * 4 + [3.0]),
                               np.array([np.pi / 2] * 4 + [0.0]))
        np.testing.assert_allclose(poses[:, 0], [0.0, 2.0, 0.0, -2.0, 0.0, 1.5], atol=1e-12)
        np.testing.assert_allclose(poses[:, 1], [0.0, 2.0, 4.0, 2.0, 0.0, 0.0], atol=1e-12)
        np.testing.assert_allclose(poses[-1, 2], 2 * np.pi)


class Geodesy(unittest.TestCase):
    def test_degrees_have_their_known_lengths(self):
        """At 45 degrees north one degree of latitude is 111132 m long and one of longitude 78847 m."""
        step = 1e-5
        enu = enu_from_geodetic(np.array([45.0, 45.0 + step, 45.0]), np.array([7.0, 7.0, 7.0 + step]),
                                np.array([100.0, 100.0, 100.0]))
        # radii of curvature there plus the height of 100 m
        self.assertAlmostEqual(enu[1, 1], (6367381.8 + 100.0) * np.radians(step), places=4)
        self.assertAlmostEqual(enu[2, 0], (6388838.3 + 100.0) * np.radians(step) * np.sqrt(0.5), places=4)
        np.testing.assert_allclose(enu[[1, 2], [0, 1]], 0.0, atol=1e-5)

    def test_up_is_height(self):
        enu = enu_from_geodetic(np.array([-33.0] * 2), np.array([151.0] * 2), np.array([10.0, 35.5]))
        np.testing.assert_allclose(enu, [[0.0, 0.0, 0.0], [0.0, 0.0, 25.5]], atol=1e-8)


if __name__ == "__main__":
    unittest.main()
