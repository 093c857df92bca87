#!/usr/bin/python3
"""landmark_detector_node: pictures and scans in, landmarks out; what it cannot use is counted and said."""
import itertools
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from kinect_ekf_slam.msg import LandmarkDetectionArray
from sensor_msgs.msg import CameraInfo, Image, LaserScan

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

from slam_run import Recorder, executable  # noqa: E402
from waiting import DEADLINE, wait_until  # noqa: E402

WIDTH, HEIGHT, FOCAL_LENGTH = 640, 480, 525.0
CAMERA_HEIGHT, POST, RADIUS, POST_HEIGHT = 0.3, (0.2, 1.4), 0.08, 0.45   # m; the post's x and z, level camera
FRAME = "camera_rgb_optical_frame"
PALETTE = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "config", "palette.yaml")
_numbers = itertools.count()


def scene():
    """(colour, depth in mm) of a red post on a floor before a wall."""
    x = (np.arange(WIDTH) - 319.5) / FOCAL_LENGTH
    y = ((np.arange(HEIGHT) - 239.5) / FOCAL_LENGTH)[:, None]
    floor = np.where(y > 1e-6, CAMERA_HEIGHT / np.maximum(y, 1e-6), np.inf) + 0.0 * x
    depth = np.minimum(floor, 2.8)
    a, b = 1.0 + x * x, POST[1] + x * POST[0]
    root = b * b - a * (POST[0]**2 + POST[1]**2 - RADIUS**2)
    post = np.where(root > 0.0, (b - np.sqrt(np.maximum(root, 0.0))) / a, np.inf) + 0.0 * y
    on_post = (post < depth) & (y * post < CAMERA_HEIGHT) & (y * post > CAMERA_HEIGHT - POST_HEIGHT)
    depth = np.where(on_post, post, depth)
    colour = np.where(on_post[:, :, None], (190, 35, 30), (120, 120, 120)).astype(np.uint8)
    return colour, np.round(1000.0 * depth).astype(np.uint16)


COLOUR, DEPTH = scene()


class Detector:
    """One landmark_detector_node in a namespace of its own."""

    def __init__(self, parameters):
        self.namespace = "/detector_%d" % next(_numbers)
        self.name = self.namespace + "/landmark_detector_node"
        rospy.set_param(self.name, parameters)
        self.landmarks = Recorder(self.namespace + "/landmarks", LandmarkDetectionArray)
        self._diagnostics = Recorder("/diagnostics", DiagnosticArray)
        self._stderr = tempfile.TemporaryFile(mode="w+")
        self._process = subprocess.Popen(
            [executable("landmark_detector_node"), "__ns:=" + self.namespace, "__name:=landmark_detector_node"],
            stdout=subprocess.DEVNULL, stderr=self._stderr)

    def publisher(self, topic, kind):
        publisher = rospy.Publisher(self.namespace + "/" + topic, kind, queue_size=10)
        wait_until(lambda: publisher.get_num_connections() > 0, "the node listens to " + topic)
        return publisher

    def said(self):
        self._stderr.seek(0)
        return self._stderr.read()

    def is_running(self):
        return self._process.poll() is None

    def exit_code(self):
        return self._process.wait(timeout=DEADLINE)

    def figures(self):
        """What the node's last diagnostics say."""
        for array in reversed(self._diagnostics.messages):
            for status in array.status:
                if status.name.startswith(self.name[1:]) or self.name in status.name:
                    return {entry.key: entry.value for entry in status.values}
        return {}

    def close(self):
        self._process.terminate()
        self._process.wait(timeout=DEADLINE)
        self.landmarks.close()
        self._diagnostics.close()


class DetectorCase(unittest.TestCase):
    def start(self, parameters):
        detector = Detector(parameters)
        self.addCleanup(detector.close)
        return detector

    def assert_refused(self, parameters, *expected_parts):
        detector = Detector(parameters)
        self.addCleanup(detector.close)
        self.assertNotEqual(detector.exit_code(), 0)
        self.assertEqual(detector.said().strip().count("\n"), 0, detector.said())
        for part in expected_parts:
            self.assertIn(part, detector.said())


class Pictures(DetectorCase):
    def connect(self):
        self.detector = self.start({"detector": {"type": "kinect_cylinder", "palette": PALETTE}})
        publisher = self.detector.publisher
        self.colours = publisher("camera/rgb/image_rect_color", Image)
        self.depths = publisher("camera/depth_registered/image_raw", Image)
        self.infos = publisher("camera/rgb/camera_info", CameraInfo)
        wait_until(self.detector.landmarks.is_connected, "its landmarks can be heard")
        self.stamps = itertools.count(100)

    def messages(self):
        colour = Image(width=WIDTH, height=HEIGHT, encoding="rgb8", step=3 * WIDTH, data=COLOUR.tobytes())
        depth = Image(width=WIDTH, height=HEIGHT, encoding="16UC1", step=2 * WIDTH, data=DEPTH.tobytes())
        info = CameraInfo(width=WIDTH, height=HEIGHT, distortion_model="plumb_bob", D=[0.0] * 5)
        info.K = [FOCAL_LENGTH, 0.0, 319.5, 0.0, FOCAL_LENGTH, 239.5, 0.0, 0.0, 1.0]
        info.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
        info.P = [FOCAL_LENGTH, 0.0, 319.5, 0.0, 0.0, FOCAL_LENGTH, 239.5, 0.0, 0.0, 0.0, 1.0, 0.0]
        stamp = rospy.Time(next(self.stamps))
        for message in (colour, depth, info):
            message.header.stamp, message.header.frame_id = stamp, FRAME
        return colour, depth, info

    def send(self, colour, depth, info):
        self.colours.publish(colour)
        self.depths.publish(depth)
        self.infos.publish(info)

    def detections_of(self, colour, depth, info):
        self.send(colour, depth, info)
        def answer():
            return [m for m in self.detector.landmarks.messages if m.header.stamp == colour.header.stamp]
        return wait_until(answer, "it answers")[0].detections

    def assert_is_the_post(self, detections):
        self.assertEqual(len(detections), 1)
        position = detections[0].position
        truth = (POST[0], CAMERA_HEIGHT - 0.5 * POST_HEIGHT, POST[1])
        np.testing.assert_allclose((position.x, position.y, position.z), truth, atol=0.015)
        self.assertAlmostEqual(detections[0].radius, RADIUS, delta=0.01)
        self.assertEqual((detections[0].label, detections[0].id), ("red", -1))
        self.assertGreater(np.linalg.eigvalsh(np.reshape(detections[0].covariance, (3, 3))).min(), 0.0)

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
