#!/usr/bin/python3
"""landmark_detector_node beside its landmarks: the debug picture, changes while it runs, the level frame, stereo."""
import math
import os
import sys

import dynamic_reconfigure.client
import numpy as np
import rospy
import rostest
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image
from stereo_msgs.msg import DisparityImage
from tf2_msgs.msg import TFMessage

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

from detector_run import COLOUR, FOCAL_LENGTH, FRAME, HEIGHT, PALETTE, WIDTH, PictureCase  # noqa: E402
from node_process import Recorder  # noqa: E402
from waiting import wait_until  # noqa: E402

GREEN, RED = (60, 220, 60), (60, 60, 230)    # blue, green, red: frames round what was found and what was refused


class DebugPicture(PictureCase):
    def connect(self, parameters=None):
        super().connect(parameters)
        self.debug = Recorder(self.detector.name + "/debug", Image)
        self.addCleanup(self.debug.close)
        wait_until(self.debug.is_connected, "the debug picture can be seen")

    def picture_after(self, messages):
        """(detections, debug picture) of these messages."""
        detections = self.detections_of(*messages)

        def drawn():
            return [m for m in self.debug.messages if m.header.stamp == messages[0].header.stamp]
        picture = wait_until(drawn, "the debug picture comes")[0]
        self.assertEqual((picture.encoding, picture.header.frame_id), ("bgr8", FRAME))
        return detections, np.frombuffer(picture.data, dtype=np.uint8).reshape(HEIGHT, WIDTH, 3)

    def test_shows_what_was_found(self):
        self.connect()
        detections, picture = self.picture_after(self.messages())
        self.assert_is_the_post(detections)
        rows, columns = np.nonzero((picture == GREEN).all(axis=2))
        self.assertGreater(len(rows), 100)
        post = np.nonzero((COLOUR == (190, 35, 30)).all(axis=2))
        self.assertAlmostEqual(columns.min(), post[1].min(), delta=15)
        self.assertAlmostEqual(rows.max(), post[0].max(), delta=15)
        np.testing.assert_array_equal(picture[-1], COLOUR[-1, :, ::-1], "the rest is as it was")

    def test_shows_what_a_live_change_makes_it_refuse(self):
        self.connect()
        client = dynamic_reconfigure.client.Client(self.detector.name + "/live", timeout=30.0)
        self.addCleanup(client.close)
        self.assertEqual(client.get_configuration()["kinect_cylinder_max_height"], 0.6)
        client.update_configuration({"kinect_cylinder_max_height": 0.3})
        detections, picture = self.picture_after(self.messages())
        self.assertEqual(detections, [])
        self.assertGreater((picture == RED).all(axis=2).sum(), 100)
        self.assertEqual((picture == GREEN).all(axis=2).sum(), 0)
        client.update_configuration({"kinect_cylinder_max_height": 0.6})
        self.assert_is_the_post(self.picture_after(self.messages())[0])
        client.update_configuration({"kinect_cylinder_min_height": 0.6})   # would leave no height
        self.assert_is_the_post(self.picture_after(self.messages())[0])


class LevelFrame(PictureCase):
    @classmethod
    def setUpClass(cls):
        cls.transforms = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        # A level camera; Z forward and X right, in a frame with X forward and Z up. And a frame that is not level.
        camera, slope = TransformStamped(child_frame_id=FRAME), TransformStamped(child_frame_id="slope")
        camera.header.frame_id = slope.header.frame_id = "level"
        turn = camera.transform.rotation
        turn.x, turn.y, turn.z, turn.w = -0.5, 0.5, -0.5, 0.5
        slope.transform.rotation.y, slope.transform.rotation.w = math.sin(0.2), math.cos(0.2)
        cls.transforms.publish(TFMessage([camera, slope]))

    def start_with(self, frame):
        self.connect({"detector": {"type": "kinect_cylinder", "palette": PALETTE}, "input": {"level_frame": frame}})

    def test_the_floor_is_where_the_frame_says(self):
        self.start_with("level")
        self.assert_is_the_post(self.detections_of(*self.messages()))

    def test_no_floor_is_steeper_than_the_frame_allows(self):
        self.start_with("slope")
        wait_until(lambda: self.detections_of(*self.messages()) == [], "the frame is known, and no floor fits it")

    def test_an_unknown_frame_is_no_obstacle(self):
        self.start_with("nowhere")
        self.assert_is_the_post(self.detections_of(*self.messages()))


class Features(PictureCase):
    """A patterned wall 1.5 m away."""
    DISTANCE, BASELINE = 1.5, 0.1   # m
    SHIFT = 8                       # pixels

    @classmethod
    def setUpClass(cls):
        cls.wall = np.kron(np.random.RandomState(1).randint(20, 235, (60, 90, 3)), np.ones((8, 8, 1))).astype(np.uint8)

    def wall_messages(self, shift):
        colour, depth, info = self.messages()
        colour.data = self.wall[:, shift:shift + WIDTH].tobytes()
        depth.data = np.full((HEIGHT, WIDTH), 1000 * self.DISTANCE, dtype=np.uint16).tobytes()
        return colour, depth, info

    def assert_are_tracks(self, answers):
        """Of successive pictures, each shifted against the one before."""
        self.assertEqual([len(answer) for answer in answers[:3]], [0, 0, 0])
        before, now = ({d.id: d for d in answer} for answer in answers[-2:])
        common = set(before) & set(now)
        self.assertGreater(len(common), 15)
        for track in common:
            self.assertGreaterEqual(track, 0)
            self.assertAlmostEqual(now[track].position.z, self.DISTANCE, delta=0.02)
            self.assertEqual(len(now[track].descriptor), 256)
        moved = [(now[track].position.x - before[track].position.x) * FOCAL_LENGTH / self.DISTANCE for track in common]
        self.assertAlmostEqual(np.mean(moved), -self.SHIFT, delta=1.0)
        self.assertLess(np.abs(np.array(moved) + self.SHIFT).max(), 6.0, "no track jumps")

    def test_tracks_are_landmarks(self):
        self.connect({"detector": {"type": "features"}})
        self.assert_are_tracks([self.detections_of(*self.wall_messages(self.SHIFT * i)) for i in range(7)])

    def test_a_stereo_camera_enters_the_same_way(self):
        self.detector = self.start({"detector": {"type": "features"},
                                    "input": {"depth_source": "disparity", "disparity_topic": "disparity",
                                              "colour_topic": "left", "info_topic": "info"}})
        self.colours = self.detector.publisher("left", Image)
        self.depths = self.detector.publisher("disparity", DisparityImage)
        self.infos = self.detector.publisher("info", CameraInfo)
        wait_until(self.detector.landmarks.is_connected, "its landmarks can be heard")
        self.stamps = iter(range(100, 200))
        answers = []
        for i in range(7):
            colour, depth, info = self.wall_messages(self.SHIFT * i)
            disparity = DisparityImage(header=depth.header, f=FOCAL_LENGTH, T=self.BASELINE, min_disparity=1.0)
            pixels = np.full((HEIGHT, WIDTH), FOCAL_LENGTH * self.BASELINE / self.DISTANCE, dtype=np.float32)
            disparity.image = Image(header=depth.header, width=WIDTH, height=HEIGHT, encoding="32FC1", step=4 * WIDTH,
                                    data=pixels.tobytes())
            answers.append(self.detections_of(colour, disparity, info))
        self.assert_are_tracks(answers)


if __name__ == "__main__":
    rospy.init_node("test_detector_topics")
    rostest.rosrun("kinect_ekf_slam", "test_detector_topics", "test_detector_topics")
