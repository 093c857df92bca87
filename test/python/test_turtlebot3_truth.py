import os
import re
import tempfile
import unittest

import support


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
            count, false, along, across, radius, squared = re.search(
                r"(\d+) detections of cylinders, (\d+) false ones; error along the ray (\S+) \+- .* mm, "
                r"across it (\S+) \+- .* mm, of the radius (\S+) \+- .* distance (\S+)",
                process.stdout).groups()
            self.assertGreater(int(count), 2000)
            self.assertEqual(int(false), 0)
            self.assertLess(abs(float(along)), 20.0)
            self.assertLess(abs(float(across)), 20.0)
            self.assertLess(abs(float(radius)), 20.0)
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
