import json
import os
import tempfile
import unittest

import support

CONSISTENCY = [{"estimator": "ekf", "time_step_s": 0.1, "nees_over_time": [2.0, 3.0, 4.0], "pose_nees": 3.0,
                "pose_nees_bounds": [2.4, 3.7], "pose_nees_inside_share": 0.9,
                "example_error": [[0.1, 0.0, 0.0]] * 3, "example_sigma": [[0.1, 0.1, 0.1]] * 3}]
FIGURES = {"success_share": [1.0, 0.5], "landmark_rmse_median_m": [0.01, 0.1], "landmark_rmse_worst_m": [0.02, None]}
ROBUSTNESS = [{"fault": "noise", "unit": "times", "strength": [1.0, 2.0], "base": 1.0, "runs": 5,
               "configured": FIGURES, "textbook": FIGURES}]
GLOBAL = {"path_rmse_m": 0.1, "slam_path_rmse_m": 1.0, "beacon_path_rmse_m": 0.3, "nees_bounds": [2.0, 4.0],
          "path_nees_over_time": [3.0, 3.1], "runs": [{}],
          "example": {name: [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]
                      for name in ("truth", "slam", "beacons", "landmarks", "true_landmarks", "global_positions")}}
GLOBAL["example"]["segments"] = [GLOBAL["example"]["truth"], []]


class PlotStudies(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name
        self.picture = os.path.join(self.folder, "picture.png")

    def test_draws_what_a_study_wrote(self):
        for study, results in (("consistency", CONSISTENCY), ("global", GLOBAL), ("robustness", ROBUSTNESS)):
            path = support.write(self.folder, study + ".json", json.dumps(results))
            process = support.run_script(f"plot_{study}.py", path, self.picture)
            self.assertEqual(process.returncode, 0, process.stderr)
            self.assertEqual(process.stdout.strip(), self.picture)
            with open(self.picture, "rb") as file:
                self.assertEqual(file.read(4), b"\x89PNG")

    def test_bad_input_is_one_line_and_leaves_the_old_picture(self):
        support.write(self.folder, "picture.png", "old")
        for study, text in (("consistency", "{"), ("consistency", "[1]"), ("consistency", "[]"), ("global", "[]"),
                            ("robustness", json.dumps(CONSISTENCY)), ("robustness", "[]")):
            path = support.write(self.folder, "results.json", text)
            process = support.run_script(f"plot_{study}.py", path, self.picture)
            support.assert_one_line_error(self, process, "results.json", f"not what slam_study {study} --json writes")
            with open(self.picture, encoding="utf-8") as file:
                self.assertEqual(file.read(), "old")
        support.assert_one_line_error(self, support.run_script("plot_robustness.py", path + ".none", self.picture),
                                      "results.json.none", "No such file")
        support.assert_one_line_error(self, support.run_script("plot_robustness.py", path), "PICTURE.png")


if __name__ == "__main__":
    unittest.main()
