import json
import os
import tempfile
import unittest

import support

HEADER = "frame,label,class,x,y,z,radius,height\n"


class EvaluateDetector(unittest.TestCase):
    def test_real_kinect_frames(self):
        folder = support.data("kinect_cylinders")
        if folder is None:
            self.skipTest("no data: SLAM_DATA/kinect_cylinders")
        with tempfile.TemporaryDirectory() as out:
            path = os.path.join(out, "figures.json")
            process = support.run_script("evaluate_detector.py", folder, "--json", path)
            self.assertEqual(process.returncode, 0, process.stderr)
            with open(path, encoding="utf-8") as file:
                figures = json.load(file)
        self.assertEqual(figures["expected"], 19)
        self.assertGreaterEqual(figures["found"], 18)
        self.assertEqual(figures["recall"], figures["found"] / 19)
        self.assertEqual(figures["false_positives"], 0)
        self.assertLess(figures["center_rmse_m"], 0.005)
        self.assertLess(figures["radius_rmse_m"], 0.003)
        self.assertGreater(figures["ms_per_frame"], 0.0)

    def test_bad_input_is_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            process = support.run_script("evaluate_detector.py", os.path.join(folder, "none"))
            support.assert_one_line_error(self, process, "none", "No such file")
            support.write(folder, "truth.csv", "frame,label\nlearn33,20\n")
            process = support.run_script("evaluate_detector.py", folder)
            support.assert_one_line_error(self, process, "truth.csv", "needed")
            for row in ("a,20,upright,nan,0,1,0.05,0.1\n", "../a,20,upright,0,0,1,0.05,0.1\n",
                        '"a""b",20,upright,0,0,1,0.05,0.1\n'):
                support.write(folder, "truth.csv", HEADER + row)
                process = support.run_script("evaluate_detector.py", folder)
                support.assert_one_line_error(self, process, "truth.csv", "needed")
            support.write(folder, "truth.csv", HEADER)
            process = support.run_script("evaluate_detector.py", folder)
            support.assert_one_line_error(self, process, "truth.csv", "holds no frames")
            with open(os.path.join(folder, "truth.csv"), "wb") as file:
                file.write(b"\xff\xfe\x00")
            process = support.run_script("evaluate_detector.py", folder)
            support.assert_one_line_error(self, process, "truth.csv", "not a table")
            support.write(folder, "truth.csv", HEADER + "a,20,upright,0,0,1,0.05,0.1\n")
            process = support.run_script("evaluate_detector.py", folder)
            support.assert_one_line_error(self, process, "a_rgb.png", "cannot be read")


if __name__ == "__main__":
    unittest.main()
