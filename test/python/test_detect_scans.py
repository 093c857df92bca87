import math
import os
import subprocess
import tempfile
import unittest

import support
from slam_tools.environment import executable


def detect(*arguments):
    return subprocess.run([executable("detect_scans"), *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, check=False)


def write_scans(path, range_maxima):
    """A post of 0.1 m radius, 1.5 m ahead of a wall's middle, seen in one scan a second."""
    import rosbag
    import rospy
    from sensor_msgs.msg import LaserScan
    with rosbag.Bag(path, "w") as bag:
        for i, range_max in enumerate(range_maxima):
            scan = LaserScan(angle_min=-0.5, angle_increment=0.01, range_min=0.1, range_max=range_max)
            scan.header.stamp = rospy.Time(1 + i)
            for ray in range(101):
                angle = -0.5 + 0.01 * ray
                aside = 1.5 * math.sin(angle)
                meets = abs(aside) < 0.1
                scan.ranges.append(1.5 * math.cos(angle) - math.sqrt(0.01 - aside ** 2) if meets else 3.0)
            bag.write("/scan", scan, scan.header.stamp)


class DetectScans(unittest.TestCase):
    def test_scans_that_cannot_be_used_are_counted(self):
        import rosbag
        with tempfile.TemporaryDirectory() as folder:
            source, out = os.path.join(folder, "scans.bag"), os.path.join(folder, "out.bag")
            write_scans(source, [5.0, 0.0, math.nan, 5.0])
            process = detect(source, "--out", out)
            self.assertEqual(process.returncode, 0, process.stderr)
            self.assertIn("warning: 2 of 4 scans could not be used", process.stderr)
            with rosbag.Bag(out) as bag:
                found = [message.detections for _, message, _ in bag.read_messages("/landmarks")]
            self.assertEqual([len(detections) for detections in found], [1, 1])
            self.assertAlmostEqual(found[0][0].position.x, 1.5, delta=0.01)

    def test_another_type_is_refused_and_leaves_nothing(self):
        with tempfile.TemporaryDirectory() as folder:
            source, out = os.path.join(folder, "scans.bag"), os.path.join(folder, "out.bag")
            write_scans(source, [5.0])
            process = detect(os.path.join(support.ROOT, "bags", "room.bag"), "--topic", "/odom", "--out", out)
            self.assertEqual(process.returncode, 2)
            self.assertIn("/odom is no sensor_msgs/LaserScan", process.stderr)
            self.assertEqual(os.listdir(folder), ["scans.bag"])


if __name__ == "__main__":
    unittest.main()
