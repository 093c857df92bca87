import math
import os
import tempfile
import unittest

import support
import rosbag

# Along a straight line for one second, then round a left curve.
SPEED, STEERING = 2.0, 0.3
INPUTS = f"""# time speed steering
0.000  1.0  0.0
0.500  1.0  0.0
1.000  {SPEED}  {STEERING}
1.500  0.0  0.0
1.500  {SPEED}  {STEERING}
2.000  0.0  0.0
"""
MEASUREMENTS = """0.300  10.0  1.5707963267948966  0.5
0.300   4.0  0.0                 0.0
0.514   2.0  3.1415926535897931  1.2
"""
GPS = "0.100 -3.0 2.0\n5.0 -4.0 2.5\n"
FILES = {"inputs.dat": INPUTS, "measurements.dat": MEASUREMENTS, "gps.dat": GPS}
WHEEL_BASE, HALF_TRACK, AHEAD, LEFT = 2.83, 0.76, 3.78, 0.50


class Converting(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name
        for name, text in FILES.items():
            support.write(self.folder, name, text)

    def convert(self, name="out.bag"):
        path = os.path.join(self.folder, name)
        return support.run_script("victoria_park_to_bag.py", self.folder, path), path

    def messages(self):
        process, path = self.convert()
        self.assertEqual(process.returncode, 0, process.stderr)
        with rosbag.Bag(path) as bag:
            found = list(bag.read_messages())
        return process, found

    def test_odometry_is_that_of_the_laser(self):
        _, found = self.messages()
        odometry = [m for topic, m, _ in found if topic == "/odom"]
        self.assertEqual([m.header.stamp.to_nsec() // 10**6 for m in odometry], [1000, 1500, 2000, 2500, 3000], "the files count from zero, a bag cannot")
        self.assertEqual({(m.header.frame_id, m.child_frame_id) for m in odometry}, {("odom", "laser")})
        straight, curve = odometry[1], odometry[3]
        self.assertEqual((straight.twist.twist.linear.x, straight.twist.twist.linear.y), (1.0, 0.0))
        self.assertAlmostEqual(straight.pose.pose.position.x, 0.5, places=12)
        self.assertAlmostEqual(straight.pose.pose.position.y, 0.0, places=12)
        # In a left curve the left wheel is the inner one: it drives on a circle smaller by the half track.
        radius = WHEEL_BASE / math.tan(STEERING)
        rate = SPEED / (radius - HALF_TRACK)
        self.assertAlmostEqual(curve.twist.twist.angular.z, rate, places=12)
        # About the circle's centre, at (0, radius) of the axle, the laser turns at this rate.
        self.assertAlmostEqual(curve.twist.twist.linear.x, rate * (radius - LEFT), places=12)
        self.assertAlmostEqual(curve.twist.twist.linear.y, rate * AHEAD, places=12)
        # the pose after a second of it, by turning the laser about that centre; it started at the origin
        at_curve = odometry[2].pose.pose.position.x
        yaw = rate * 1.0
        from_centre = complex(AHEAD, LEFT - radius)
        expected = at_curve + from_centre * complex(math.cos(yaw), math.sin(yaw)) - from_centre
        end = odometry[4].pose.pose
        self.assertAlmostEqual(end.position.x, expected.real, places=9)
        self.assertAlmostEqual(end.position.y, expected.imag, places=9)
        self.assertAlmostEqual(end.orientation.z, math.sin(0.5 * yaw), places=12)
        for message in odometry:
            self.assertGreater(min(message.pose.covariance[::7]), 0.0)
            self.assertGreater(min(message.twist.covariance[::7]), 0.0)

    def test_detections_stand_in_the_lasers_frame(self):
        _, found = self.messages()
        arrays = [m for topic, m, _ in found if topic == "/landmarks"]
        self.assertEqual([m.header.stamp.to_nsec() // 10**6 for m in arrays], [1300, 1514])
        self.assertEqual({m.header.frame_id for m in arrays}, {"laser"})
        detections = [[(d.id, round(d.position.x, 9), round(d.position.y, 9), round(d.radius, 6))
                       for d in m.detections] for m in arrays]
        self.assertEqual(detections, [[(-1, 10.0, 0.0, 0.25), (-1, 0.0, -4.0, 0.0)], [(-1, 0.0, 2.0, 0.6)]])
        self.assertEqual({(tuple(d.covariance), d.label) for m in arrays for d in m.detections},
                         {((0.0,) * 9, "")})

    def test_the_gps_is_a_truth_without_headings(self):
        process, found = self.messages()
        times = [t.to_nsec() for _, _, t in found]
        self.assertEqual(times, sorted(times))
        self.assertEqual(times, [m.header.stamp.to_nsec() for _, m, _ in found])
        poses = [m for topic, m, _ in found if topic == "/ground_truth/pose"]
        self.assertEqual([(p.pose.position.x, p.pose.position.y) for p in poses], [(-3.0, 2.0), (-4.0, 2.5)])
        self.assertEqual({(q.x, q.y, q.z, q.w) for p in poses for q in [p.pose.orientation]}, {(0.0,) * 4})
        self.assertEqual(process.stdout.count("\n"), 3)
        self.assertIn("5 messages; 1 rows with a repeated stamp", process.stdout)
        self.assertIn("2 messages: 3 detections", process.stdout)

    def test_a_dataset_without_gps_converts(self):
        os.remove(os.path.join(self.folder, "gps.dat"))
        _, found = self.messages()
        self.assertNotIn("/ground_truth/pose", {topic for topic, _, _ in found})

    def test_the_same_folder_gives_the_same_bag(self):
        bags = []
        for name in ("a.bag", "b.bag"):
            with open(self.convert(name)[1], "rb") as file:
                bags.append(file.read())
        self.assertEqual(*bags)

    def test_bad_input_is_one_line_and_leaves_nothing_behind(self):
        cases = [
            ("inputs.dat", "0.0 1.0 0.0\n0.1 abc 0.0\n", ("inputs.dat:2", "abc")),
            ("inputs.dat", "0.0 1.0\n", ("inputs.dat:1", "3 finite numbers")),
            ("inputs.dat", "0.0 nan 0.0\n", ("inputs.dat:1", "nan")),
            ("inputs.dat", "2.0 1 0\n1.0 1 0\n", ("inputs.dat:2", "order of time")),
            ("inputs.dat", "0.0 1 1.5\n", ("inputs.dat", "0.000", "steering")),
            ("inputs.dat", "# nothing\n", ("inputs.dat", "no rows")),
            ("inputs.dat", "-1.0 1 0\n", ("inputs.dat", "negative")),
            ("inputs.dat", None, ("inputs.dat", "no such file")),
            ("measurements.dat", "0.3 -1.0 1.0 0.5\n", ("measurements.dat", "negative")),
            ("measurements.dat", "0.3 1.0 1.0\n", ("measurements.dat:1", "diameter")),
            ("gps.dat", "0.1 2.0\n", ("gps.dat:1", "time x y")),
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

    def test_a_file_that_is_no_bag_is_not_replaced(self):
        process, path = self.convert("inputs.dat")
        self.assertEqual(process.returncode, 2)
        self.assertIn("exists and is no bag", process.stderr)
        with open(path, encoding="utf-8") as file:
            self.assertEqual(file.read(), INPUTS)

    def test_times_that_no_bag_can_hold_are_refused(self):
        for row in ("1e300 1.0 0.0", "1e9 1.0 0.0"):
            support.write(self.folder, "inputs.dat", INPUTS + row + "\n")
            process, path = self.convert()
            self.assertEqual((process.returncode, process.stderr.count("\n"), os.path.exists(path)), (2, 1, False))

    def test_bad_arguments_are_one_line(self):
        missing = os.path.join(self.folder, "missing")
        for arguments, expected in [((missing, os.path.join(self.folder, "out.bag")), "missing"),
                                    ((self.folder, os.path.join(missing, "out.bag")), "does not exist"),
                                    ((self.folder,), "OUT.bag")]:
            support.assert_one_line_error(self, support.run_script("victoria_park_to_bag.py", *arguments),
                                          expected)


class RealData(unittest.TestCase):
    @unittest.skipUnless(support.data("victoria_park"), "no SLAM_DATA/victoria_park")
    def test_trees_stand_still_between_scans(self):
        """The odometry carries one scan onto the scan a second later: signs, axes and mounting are right."""
        import numpy as np
        from slam_tools.bags import open_bag
        from slam_tools.geometry import Path, yaw_of_quaternion
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "out.bag")
            process = support.run_script("victoria_park_to_bag.py", support.data("victoria_park"), path)
            self.assertEqual(process.returncode, 0, process.stderr)
            with open_bag(path) as bag:
                odometry = [(m.header.stamp.to_sec(), p.position, p.orientation)
                            for _, m, _ in bag.read_messages("/odom") for p in [m.pose.pose]]
                scans = [(m.header.stamp.to_sec(),
                          np.array([complex(d.position.x, d.position.y) for d in m.detections]))
                         for _, m, _ in bag.read_messages("/landmarks")]
        self.assertEqual((len(odometry), len(scans)), (61945, 7230))
        reckoned = Path(np.array([t for t, _, _ in odometry]),
                        np.array([(p.x, p.y, p.z) for _, p, _ in odometry]),
                        np.array([(q.x, q.y, q.z, q.w) for _, _, q in odometry]))
        valid, poses = reckoned.at(np.array([t for t, _ in scans]), max_gap=0.5)
        scans = [trees for (_, trees), there in zip(scans, valid) if there]
        place = poses.positions[:, 0] + 1j * poses.positions[:, 1]
        yaw = yaw_of_quaternion(poses.quaternions)
        turning, driving = [], []
        for k in range(0, len(scans) - 5):
            first, later = (place[i] + scans[i] * np.exp(1j * yaw[i]) for i in (k, k + 5))
            nearest = np.abs(first[:, None] - later[None]).min(axis=1)
            nearest = nearest[nearest < 1.5]   # the others went out of view
            if abs(yaw[k + 5] - yaw[k]) > 0.2:
                turning += nearest.tolist()
            elif abs(place[k + 5] - place[k]) > 2.0:
                driving += nearest.tolist()
        self.assertGreater(min(len(turning), len(driving)), 1000)
        # 0.18 and 0.29; 0.6 and 1.1 with the bearing or the steering the other way round
        self.assertLess(np.median(driving), 0.25)
        self.assertLess(np.median(turning), 0.4)


if __name__ == "__main__":
    unittest.main()
