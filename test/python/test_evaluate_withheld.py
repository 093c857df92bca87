"""A robot whose GPS is withheld for a minute: on recorded data by others; skipped without the data."""
import os
import sys
import tempfile
import unittest

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "scripts"))

import evaluate_withheld  # noqa: E402

DATA = evaluate_withheld.default_data()


class Withheld(unittest.TestCase):
    @unittest.skipUnless(os.path.isdir(os.path.join(DATA, "bags")), "no recorded data: set SLAM_DATA to their folder")
    def test_fused_is_at_most_half_as_far_off_as_dead_reckoning(self):
        with tempfile.TemporaryDirectory() as out:
            rows = evaluate_withheld.evaluate(DATA, out, 60.0, [])
        self.assertGreaterEqual(len(rows), 5)
        self.assertLessEqual(np.mean([row[2] for row in rows]), 0.5 * np.mean([row[3] for row in rows]))

    def test_a_path_is_laid_on_a_track_by_a_turn_and_a_shift(self):
        track = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [1.0, 5.0]])
        path = np.stack([-track[:, 1], track[:, 0]], axis=1) + np.array([7.0, -2.0])
        np.testing.assert_allclose(evaluate_withheld.laid_on(path, track), track, atol=1e-12)


if __name__ == "__main__":
    unittest.main()
