#!/usr/bin/python3
"""landmark_detector_node: pictures and scans in, landmarks out; what it cannot use is counted and said."""
import os
import sys

import numpy as np
import rospy
import rostest
from sensor_msgs.msg import LaserScan

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

from detector_run import COLOUR, DEPTH, HEIGHT, WIDTH, DetectorCase, PictureCase  # noqa: E402
from waiting import wait_until  # noqa: E402


class Pictures(PictureCase):
    def test_finds_the_post_in_millimetres_and_in_metres(self):
        self.connect()
        self.assert_is_the_post(self.detections_of(*self.messages()))
        colour, depth, info = self.messages()
        depth.encoding, depth.step = "32FC1", 4 * WIDTH
        depth.data = (DEPTH / 1000.0).astype(np.float32).tobytes()
        self.assert_is_the_post(self.detections_of(colour, depth, info))

    def test_no_readings_are_an_empty_answer(self):
        self.connect()
        colour, depth, info = self.messages()
        depth.data = bytes(len(depth.data))
        self.assertEqual(self.detections_of(colour, depth, info), [])
        colour, depth, info = self.messages()
        depth.encoding, depth.step = "32FC1", 4 * WIDTH
        depth.data = np.full((HEIGHT, WIDTH), np.nan, dtype=np.float32).tobytes()
        self.assertEqual(self.detections_of(colour, depth, info), [])

    def test_what_cannot_be_used_is_counted_and_said(self):
        self.connect()

        def small_depth(_, depth, __):
            depth.width, depth.height, depth.step, depth.data = 320, 240, 640, depth.data[:640 * 240]

        def unknown_colour(colour, _, __):
            colour.encoding = "purple"

        def depth_of_colours(_, depth, __):
            depth.encoding, depth.step, depth.data = "rgb8", 3 * WIDTH, COLOUR.tobytes()

        def wrong_step(_, depth, __):
            depth.step = WIDTH

        def truncated(colour, _, __):
            colour.data = colour.data[:1000]

        def empty(colour, _, __):
            colour.width, colour.height, colour.step, colour.data = 0, 0, 0, b""

        def no_calibration(_, __, info):
            info.K, info.P = [0.0] * 9, [0.0] * 12

        def other_size(_, __, info):
            info.width = 1280

        def other_frame(_, depth, __):
            depth.header.frame_id = "camera_depth_optical_frame"

        damages = (small_depth, unknown_colour, depth_of_colours, wrong_step, truncated, empty, no_calibration,
                   other_size, other_frame)
        for count, damage in enumerate(damages, 1):
            messages = self.messages()
            damage(*messages)
            self.send(*messages)
            wait_until(lambda: self.detector.figures().get("inputs not usable") == str(count),
                       lambda: "%s is counted: %s" % (damage.__name__, self.detector.figures()))
            self.assertTrue(self.detector.figures()["last problem"], damage.__name__)
            self.assertTrue(self.detector.is_running(), damage.__name__)
        self.assertIn("registered depth is needed", self.detector.figures()["last problem"])
        self.assertIn("could not be used", self.detector.said())
        self.assert_is_the_post(self.detections_of(*self.messages()))


class Scans(DetectorCase):
    def test_finds_a_cylinder_in_a_scan_and_survives_a_bad_one(self):
        detector = self.start({"detector": {"type": "laser_cylinder"}})
        scans = detector.publisher("scan", LaserScan)
        wait_until(detector.landmarks.is_connected, "its landmarks can be heard")
        angles = np.radians(np.arange(360))
        across, along = 1.5 * np.sin(angles), 1.5 * np.cos(angles)
        ranges = np.where((np.abs(across) < 0.15) & (along > 0.0),
                          along - np.sqrt(np.maximum(0.15**2 - across**2, 0.0)), np.inf)
        scan = LaserScan(angle_increment=np.radians(1.0), range_min=0.1, range_max=3.5, ranges=list(ranges))
        scan.header.stamp, scan.header.frame_id = rospy.Time(100), "base_scan"
        bad = LaserScan(angle_increment=float("nan"), range_max=3.5, ranges=[1.0] * 360)
        scans.publish(bad)
        wait_until(lambda: detector.figures().get("inputs not usable") == "1", "the bad scan is counted")
        scans.publish(scan)
        wait_until(lambda: detector.landmarks.last, "it answers")
        (detection,) = detector.landmarks.last.detections
        self.assertAlmostEqual(detection.position.x, 1.5, delta=0.03)
        self.assertAlmostEqual(detection.position.y, 0.0, delta=0.03)
        self.assertAlmostEqual(detection.radius, 0.15, delta=0.02)


class Parameters(DetectorCase):
    def test_what_cannot_be_used_is_one_line(self):
        self.assert_refused({"detector": {"type": "cones"}}, "detector/type:", "'cones'", "kinect_cylinder")
        self.assert_refused({"kinect_cylinder": {"max_depth": -1.0}}, "kinect_cylinder/max_depth:", "from 0.1 to 20")
        self.assert_refused({"laser_cylinder": {"min_radius": 0.5}}, "laser_cylinder/min_radius:", "less than")
        self.assert_refused({"detector": {"palette": "/nowhere.yaml"}}, "/nowhere.yaml", "cannot be read")
        self.assert_refused({"detector": {"type": "aruco"}, "aruco": {"dictionary": "9X9"}}, "'9X9'", "4X4_50")

    def test_a_name_that_is_not_known_is_said(self):
        detector = self.start({"kinect_cylinder": {"colour": "red"}})
        wait_until(lambda: "kinect_cylinder/colour is not known" in detector.said(), "the unread key is named")


if __name__ == "__main__":
    rospy.init_node("test_detector")
    rostest.rosrun("kinect_ekf_slam", "test_detector", "test_detector")
