import math
import os
import tempfile
import unittest

import support
import rosbag

ODOMETRY = """# Time [s]    forward velocity [m/s]    angular velocity[rad/s]
10.000 \t 1.0 \t 0.0
10.020    9.0   9.0
10.020    1.0   0.0
10.050    2.0   0.0
10.170    1.0   1.0
10.220    0.0   0.0
"""
MEASUREMENTS = """# Time [s]    Subject #    range [m]    bearing [rad]
10.030   45   2.0   0.0
10.040   5    1.0   0.1
10.049   99   1.0   1.5707963267948966
10.050   90   3.0   -1.5707963267948966
10.200   14   1.0   0.0
"""
BARCODES = "# Subject #    Barcode #\n1 5\n2 14\n6 45\n7 90\n"
LANDMARKS = "# Subject x y sx sy\n6 0.5 -4.5 0.01 0.02\n7 3.0 -5.0 0.03 0.04\n"
TRUE_POSES = "# Time x y theta\n9.990 1.0 2.0 0.5\n10.000 1.1 2.0 0.6\n"
FILES = {"Robot3_Odometry.dat": ODOMETRY, "Robot3_Measurement.dat": MEASUREMENTS, "Barcodes.dat": BARCODES,
         "Landmark_Groundtruth.dat": LANDMARKS, "Robot3_Groundtruth.dat": TRUE_POSES}


class Converting(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name
        for name, text in FILES.items():
            support.write(self.folder, name, text)

    def convert(self, *options):
        path = os.path.join(self.folder, "out.bag")
        return support.run_script("mrclam_to_bag.py", self.folder, 3, path, *options), path

    def messages(self, *options):
        process, path = self.convert(*options)
        self.assertEqual(process.returncode, 0, process.stderr)
        with rosbag.Bag(path) as bag:
            found = list(bag.read_messages())
        return process, found

    def test_odometry_is_filled_integrated_and_free_of_repeated_stamps(self):
        _, found = self.messages()
        odometry = [m for topic, m, _ in found if topic == "/odom"]
        stamps = [m.header.stamp.to_nsec() // 10**6 for m in odometry]
        # the row of 10.05 holds for 0.12 s: two samples more; a gap of exactly 0.05 s is none
        self.assertEqual(stamps, [10000, 10020, 10050, 10100, 10150, 10170, 10220])
        self.assertEqual([m.twist.twist.linear.x for m in odometry], [1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 0.0])
        self.assertEqual([m.twist.twist.angular.z for m in odometry], [0.0] * 5 + [1.0, 0.0])
        x = [0.0, 0.02, 0.05, 0.15, 0.25, 0.29, 0.29 + math.sin(0.05)]
        for message, expected in zip(odometry, x):
            self.assertAlmostEqual(message.pose.pose.position.x, expected, places=9)
        self.assertAlmostEqual(odometry[-1].pose.pose.position.y, 1.0 - math.cos(0.05), places=9)
        self.assertAlmostEqual(odometry[-1].pose.pose.orientation.z, math.sin(0.025), places=9)
        for message in odometry:
            self.assertEqual((message.header.frame_id, message.child_frame_id), ("odom", "base_footprint"))
            self.assertGreater(min(message.pose.covariance[::7]), 0.0)
            self.assertGreater(min(message.twist.covariance[::7]), 0.0)

    def test_detections_are_grouped_identified_and_free_of_robots(self):
        _, found = self.messages()
        arrays = [m for topic, m, _ in found if topic == "/landmarks"]
        self.assertEqual([m.header.stamp.to_nsec() // 10**6 for m in arrays], [10030, 10050, 10200])
        self.assertEqual([m.header.frame_id for m in arrays], ["base_footprint"] * 3)
        detections = [[(d.id, round(d.position.x, 9), round(d.position.y, 9)) for d in m.detections]
                      for m in arrays]
        self.assertEqual(detections, [[(6, 2.0, 0.0), (-1, 0.0, 1.0)], [(7, 0.0, -3.0)], []])
        for detection in (d for m in arrays for d in m.detections):
            self.assertEqual((detection.position.z, detection.label, detection.radius, detection.score),
                             (0.0, "", 0.0, 1.0))
            self.assertEqual(list(detection.covariance), [0.0] * 9)

    def test_a_share_of_the_identities_is_wrong_and_all_else_as_it_was(self):
        landmarks = range(6, 11)
        support.write(self.folder, "Barcodes.dat", "1 5\n" + "".join(f"{i} {10 * i}\n" for i in landmarks))
        support.write(self.folder, "Landmark_Groundtruth.dat", "".join(f"{i} {i} 0 0 0\n" for i in landmarks))
        support.write(self.folder, "Robot3_Measurement.dat", "".join(
            f"{10 + k:.3f} {5 if k % 10 == 0 else 99 if k % 10 == 1 else 60} 2.0 0.1\n" for k in range(500)))

        def identities(*options):
            process, found = self.messages(*options)
            return [[d.id for d in m.detections] for topic, m, _ in found if topic == "/landmarks"], process, [
                (topic, m) for topic, m, _ in found if topic != "/landmarks"]

        clean, _, clean_rest = identities()
        wrong, process, rest = identities("--wrong-identities", "0.5", "--seed", "7")
        self.assertEqual(rest, clean_rest)
        differing = [(a, b) for of_clean, of_wrong in zip(clean, wrong) for a, b in zip(of_clean, of_wrong) if a != b]
        self.assertEqual({a for a, _ in differing}, {6})   # no robot, and no barcode that nobody has
        self.assertEqual(len(differing), 200)              # half of the 400 sightings of landmarks
        for other in landmarks[1:]:                        # 50 expected, 6 their standard deviation
            self.assertAlmostEqual(sum(b == other for _, b in differing), 50, delta=25)
        self.assertIn("200 with a wrong identity", process.stdout)
        self.assertEqual(identities("--wrong-identities", "0.5", "--seed", "7")[0], wrong)
        self.assertNotEqual(identities("--wrong-identities", "0.5", "--seed", "8")[0], wrong)

    def test_truth_and_order(self):
        process, found = self.messages()
        times = [t.to_nsec() for _, _, t in found]
        self.assertEqual(times, sorted(times))
        self.assertEqual(times, [m.header.stamp.to_nsec() for _, m, _ in found])
        self.assertEqual(found[0].topic, "/ground_truth/landmarks")
        landmarks = [(l.id, l.source_id, l.position.x, l.position.y, l.status)
                     for l in found[0].message.landmarks]
        self.assertEqual(landmarks, [(6, 6, 0.5, -4.5, 1), (7, 7, 3.0, -5.0, 1)])
        self.assertAlmostEqual(found[0].message.landmarks[1].covariance[0], 0.03**2)
        self.assertAlmostEqual(found[0].message.landmarks[1].covariance[4], 0.04**2)
        poses = [m for topic, m, _ in found if topic == "/ground_truth/pose"]
        self.assertEqual([(p.pose.position.x, p.pose.position.y) for p in poses], [(1.0, 2.0), (1.1, 2.0)])
        self.assertAlmostEqual(poses[1].pose.orientation.z, math.sin(0.3))
        self.assertEqual({m.header.frame_id for m in poses + [found[0].message]}, {"map"})
        self.assertEqual(process.stdout.count("\n"), 4)
        self.assertIn("7 messages: 5 rows, 2 samples to fill gaps; 1 rows with a repeated stamp",
                      process.stdout)
        self.assertIn("3 messages: 3 detections, 1 of them with an unlisted barcode; 2 sightings of robots",
                      process.stdout)

    def test_a_dataset_without_true_poses_converts(self):
        os.remove(os.path.join(self.folder, "Robot3_Groundtruth.dat"))
        _, found = self.messages()
        self.assertNotIn("/ground_truth/pose", {topic for topic, _, _ in found})

    def test_bad_input_is_one_line_and_leaves_nothing_behind(self):
        cases = [
            ("Robot3_Odometry.dat", "# a comment\n10.0 1.0 0.0\n10.1 abc 0.0\n",
             ("Robot3_Odometry.dat:3", "abc")),
            ("Robot3_Odometry.dat", "10.0 1.0 0.0\n\n10.1 1.0\n",
             ("Robot3_Odometry.dat:3", "3 finite numbers")),
            ("Robot3_Odometry.dat", "10.0 1.0 nan\n", ("Robot3_Odometry.dat:1", "nan")),
            ("Robot3_Odometry.dat", "10.0 1 0\n# x\n9.0 1 0\n", ("Robot3_Odometry.dat:3", "order of time")),
            ("Robot3_Odometry.dat", "# nothing\n", ("Robot3_Odometry.dat", "no rows")),
            ("Robot3_Odometry.dat", "", ("Robot3_Odometry.dat", "empty")),
            ("Robot3_Measurement.dat", "10.0 5 1.0\n", ("Robot3_Measurement.dat:1", "barcode")),
            ("Robot3_Measurement.dat", None, ("Robot3_Measurement.dat", "no such file")),
            ("Robot3_Measurement.dat", "10.0 45 2.0 0.0\n10.1 45 -1.5 0.0\n",
             ("Robot3_Measurement.dat", "row 2", "range is -1.5 m", "0 or more")),
            ("Robot3_Measurement.dat", "10.0 4.5 2.0 0.0\n", ("Robot3_Measurement.dat", "barcode is 4.5", "whole")),
            ("Barcodes.dat", "6\n", ("Barcodes.dat:1", "subject barcode")),
            ("Barcodes.dat", "6 45\n7 90\n8 45\n", ("Barcodes.dat", "barcode 45", "subjects 6 and 8")),
            ("Barcodes.dat", "6 45\n3000000000 90\n",
             ("Barcodes.dat", "row 2", "subject is 3000000000", "2147483647")),
            ("Barcodes.dat", "6 45\n7 3000000000\n", ("Barcodes.dat", "row 2", "barcode is 3000000000")),
            ("Landmark_Groundtruth.dat", "-3000000000 0 0 0 0\n", ("Landmark_Groundtruth.dat", "subject is -3000000000")),
        ]
        for name, text, expected in cases:
            path = os.path.join(self.folder, name)
            if text is None:
                os.remove(path)
            else:
                support.write(self.folder, name, text)
            process, _ = self.convert()
            support.assert_one_line_error(self, process, *expected)
            self.assertEqual(sorted(set(os.listdir(self.folder)) - set(FILES)), [])
            support.write(self.folder, name, FILES[name])

    def test_bad_arguments_are_one_line(self):
        out_path = os.path.join(self.folder, "out.bag")
        missing = os.path.join(self.folder, "missing")
        for arguments, expected in [((self.folder, 7, out_path), "7"),
                                    ((self.folder, 3, out_path, "--wrong-identities", "1.5"), "1.5"),
                                    ((self.folder, 3, out_path, "--seed", "-1"), "-1"),
                                    ((missing, 3, out_path), "missing"),
                                    ((self.folder, 3, os.path.join(missing, "out.bag")), "does not exist")]:
            support.assert_one_line_error(self, support.run_script("mrclam_to_bag.py", *arguments), expected)


class RealData(unittest.TestCase):
    @unittest.skipUnless(support.data("mrclam6"), "no SLAM_DATA/mrclam6")
    def test_measurements_agree_with_the_truth(self):
        """True poses and landmarks predict what the camera measured: the frames and signs are right."""
        import numpy as np
        from slam_tools.bags import open_bag, read_true_landmarks, read_true_path
        from slam_tools.geometry import wrap_angle, yaw_of_quaternion
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "out.bag")
            process = support.run_script("mrclam_to_bag.py", support.data("mrclam6"), 1, path)
            self.assertEqual(process.returncode, 0, process.stderr)
            with open_bag(path) as bag:
                true_path, landmarks = read_true_path(path, bag), read_true_landmarks(path, bag)
                rows = np.array([(m.header.stamp.to_sec(), d.id, d.position.x, d.position.y)
                                 for _, m, _ in bag.read_messages("/landmarks") for d in m.detections
                                 if d.id >= 0])
                gaps = np.diff([m.header.stamp.to_sec() for _, m, _ in bag.read_messages("/odom")])
        self.assertEqual(sorted(set(landmarks.identities)), list(range(6, 21)))
        self.assertLess(gaps.max(), 0.0501)
        self.assertGreater(gaps.min(), 0.0)
        valid, poses = true_path.at(rows[:, 0], max_gap=0.5)
        rows = rows[valid]
        position_of = dict(zip(landmarks.identities.tolist(), landmarks.positions))
        offsets = np.array([position_of[int(i)] for i in rows[:, 1]]) - poses.positions
        bearing = np.arctan2(offsets[:, 1], offsets[:, 0]) - yaw_of_quaternion(poses.quaternions)
        bearing_error = wrap_angle(np.arctan2(rows[:, 3], rows[:, 2]) - bearing)
        range_error = np.hypot(rows[:, 2], rows[:, 3]) - np.hypot(offsets[:, 0], offsets[:, 1])
        self.assertLess(abs(np.median(bearing_error)), np.radians(0.5))
        self.assertLess(np.percentile(np.abs(bearing_error), 90), np.radians(3.0))
        self.assertLess(abs(np.median(range_error)), 0.1)


if __name__ == "__main__":
    unittest.main()
