"""What the tests of slam_node share: how a run is started and how its results are compared."""
import math
import unittest

import numpy as np

from slam_run import SlamRun


def matrix(values):
    size = int(round(math.sqrt(len(values))))
    return np.array(values).reshape(size, size)


class SlamCase(unittest.TestCase):
    """A test that drives one slam_node."""

    def start(self, overrides=None, **options):
        run = SlamRun(overrides, **options)
        self.addCleanup(run.close)
        return run

    def assert_pose_near(self, pose, expected, tolerance):
        self.assertLess(math.hypot(pose[0] - expected[0], pose[1] - expected[1]), tolerance, (pose, expected))
        self.assertLess(abs(math.remainder(pose[2] - expected[2], 2.0 * math.pi)), tolerance, (pose, expected))

    def assert_is_covariance(self, values):
        covariance = matrix(values)
        np.testing.assert_array_equal(covariance, covariance.T)
        self.assertGreater(np.linalg.eigvalsh(covariance).min(), 0.0)

    def assert_same_landmarks(self, actual, expected):
        """Two saved maps have the same landmarks with the same covariance, to the last bit."""
        self.assertEqual(actual["landmarks"], expected["landmarks"])
        self.assertEqual(landmark_covariance(actual), landmark_covariance(expected))

    def assert_same_state(self, actual, expected):
        """Likewise, and the robot is at the same pose, equally sure."""
        for key in ("landmarks", "pose", "stamp_ns", "covariance_lower_triangle"):
            self.assertEqual(actual[key], expected[key], key)


def landmark_covariance(saved_map):
    """The landmarks' block of a saved map's covariance: rows and columns behind those of the planar pose."""
    return [row[3:] for row in saved_map["covariance_lower_triangle"][3:]]
