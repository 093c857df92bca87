"""What the package has to reach on recorded data by others; skipped without the data."""
import os
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "scripts"))

import evaluate_real_data as real  # noqa: E402
from slam_tools.refinements import means  # noqa: E402

DATA = real.default_data()


@unittest.skipUnless(os.path.isdir(os.path.join(DATA, "mrclam6")), "no recorded data: set SLAM_DATA to their folder")
class RealData(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.out = folder.name

    def test_mrclam_with_known_identities(self):
        results = real.mrclam(DATA, self.out)
        self.assertLessEqual(real.mean(results, "ate_rmse_m"), 0.21)
        self.assertLessEqual(max(result["ate_rmse_m"] for result in results), 0.33)
        self.assertLessEqual(real.mean(results, "landmark_rmse_m"), 0.08)
        self.assertGreaterEqual(real.mean(results, "pose_nees_mean"), 1.5)
        self.assertLessEqual(real.mean(results, "pose_nees_mean"), 5.0)
        for result in results:
            self.assertEqual((result["landmarks_estimated"], result["landmarks_missed"]), (15, 0))

    def test_a_refined_run_is_near_the_limit(self):
        results = real.refined(DATA, self.out, "mrclam6")
        _, path, _, landmarks = means(results)
        self.assertLessEqual(path, 0.10)
        self.assertLessEqual(landmarks, 0.06)
        for result in results:   # what the robots have in common, and what was never told: their cameras measure depth
            calibration = result["refinement"]["calibration"]
            self.assertAlmostEqual(calibration["sensor/depth_share"]["value"], 0.9, delta=0.15)
            self.assertAlmostEqual(calibration["input/angular_scale"]["value"], 0.937, delta=0.02)
            self.assertLessEqual(result["refinement"]["seconds"], 60.0)

    def test_most_misread_identities_are_caught(self):
        """That no robot is worse than without the check is printed by --misread, and not yet so."""
        results = real.misread(DATA, self.out, seed=1)
        wrong = sum(number for number, _ in results)
        self.assertGreater(wrong, 400)
        self.assertGreaterEqual(sum(result["checked"]["caught"] for _, result in results), 0.5 * wrong)

    def test_mrclam_with_identities_withheld(self):
        for robot, result in zip(real.ROBOTS, real.mrclam_unknown(DATA, self.out)):
            self.assertTrue(real.meets_unknown_goals(result), (robot, result))

    def test_turtlebot3_without_identities(self):
        result = real.turtlebot3(DATA, self.out)
        self.assertEqual((result["landmarks_estimated"], result["landmarks_spurious"]), (9, 0))
        self.assertLessEqual(result["landmark_max_m"], 0.05)

    def test_victoria_park_without_identities(self):
        result = real.victoria_park(DATA, self.out)
        self.assertLessEqual(result["path_error_median_m"], 1.0)
        self.assertLessEqual(result["path_error_p95_m"], 3.5)
        self.assertLess(result["landmarks_estimated"], 300)
        self.assertGreaterEqual(result["summary"]["times_real_time"], 20.0)

    def test_husky_heading_by_its_gyro(self):
        error = {source: result["ate_rmse_m"] for source, result in real.husky(DATA, self.out).items()}
        self.assertAlmostEqual(error["odometry"], 6.9, delta=0.3)
        for source in ("gyrodometry", "gyrodometry_report", "imu"):
            self.assertLessEqual(error[source], 3.3, source)


class BegunLater(unittest.TestCase):
    def test_rows_before_are_left_out_by_the_clock_of_the_odometry(self):
        files = {"Barcodes.dat": "6 45\n", "Landmark_Groundtruth.dat": "6 0 0 0 0\n",
                 "Robot2_Odometry.dat": "# t v w\n10.0 1 0\n110.0 2 0\n111.0 3 0\n",
                 "Robot2_Measurement.dat": "# t s r b\n9.0 45 1 0\n109.9 45 2 0\n110.5 45 3 0\n"}
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as target:
            for name, text in files.items():
                with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                    file.write(text)
            real.begin_later(folder, 2, 100, target)
            left = {}
            for name in files:
                with open(os.path.join(target, name), encoding="utf-8") as file:
                    left[name] = file.read()
        self.assertEqual(left, {**files, "Robot2_Odometry.dat": "110.0 2 0\n111.0 3 0\n",
                                "Robot2_Measurement.dat": "110.5 45 3 0\n"})


if __name__ == "__main__":
    unittest.main()
