"""One landmark_detector_node in a namespace of its own, and pictures of a red post for it."""
import itertools
import os
import unittest

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from kinect_ekf_slam.msg import LandmarkDetectionArray
from sensor_msgs.msg import CameraInfo, Image

from node_process import ROOT, NodeProcess, Recorder
from waiting import wait_until

WIDTH, HEIGHT, FOCAL_LENGTH = 640, 480, 525.0
CAMERA_HEIGHT, POST, RADIUS, POST_HEIGHT = 0.3, (0.2, 1.4), 0.08, 0.45   # m; the post's x and z, level camera
FRAME = "camera_rgb_optical_frame"
PALETTE = os.path.join(ROOT, "config", "palette.yaml")
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


class Detector(NodeProcess):
    """One landmark_detector_node in a namespace of its own."""

    def __init__(self, parameters):
        self.namespace = "/detector_%d" % next(_numbers)
        self.landmarks = Recorder(self.namespace + "/landmarks", LandmarkDetectionArray)
        self._diagnostics = Recorder("/diagnostics", DiagnosticArray)
        super().__init__("landmark_detector_node", self.namespace, parameters)

    def publisher(self, topic, kind):
        publisher = rospy.Publisher(self.namespace + "/" + topic, kind, queue_size=10)
        wait_until(lambda: publisher.get_num_connections() > 0, "the node listens to " + topic)
        return publisher

    def figures(self):
        """What the node's last diagnostics say."""
        for array in reversed(self._diagnostics.messages):
            for status in array.status:
                if status.name.startswith(self.name[1:]) or self.name in status.name:
                    return {entry.key: entry.value for entry in status.values}
        return {}

    def close(self):
        self.stop()
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


class PictureCase(DetectorCase):
    """A test that sends pictures to one node."""

    def connect(self, parameters=None):
        self.detector = self.start(parameters or {"detector": {"type": "kinect_cylinder", "palette": PALETTE}})
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
