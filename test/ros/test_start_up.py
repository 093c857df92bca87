#!/usr/bin/python3
"""What slam_node does with parameters that it cannot use: one line that helps, and the end."""
import itertools
import os
import re
import sys
import tempfile
import unittest

import rospy
import rostest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

from slam_case import SlamCase  # noqa: E402
from slam_run import SlamProcess  # noqa: E402

_numbers = itertools.count()


class StartUp(unittest.TestCase):
    def assert_refused(self, overrides, *expected_parts):
        """The node ends with an error and one line on stderr that has these parts."""
        process = SlamProcess("/start_up_%d" % next(_numbers), overrides)
        self.addCleanup(process.stop)
        self.assertNotEqual(process.exit_code(), 0, overrides)
        said = re.sub("\033\\[[0-9;]*m", "", process.said())  # roscpp colours what is wrong
        self.assertEqual(said.strip().count("\n"), 0, said)
        for part in expected_parts:
            self.assertIn(part, said)

    def test_a_required_key_that_is_missing(self):
        for key in ("frames/map", "frames/odom", "frames/base", "estimator/type", "association/type"):
            self.assert_refused({key: None}, key + ":", "missing", "config/slam.yaml")

    def test_a_name_that_does_not_exist(self):
        self.assert_refused({"estimator/type": "foo"}, "estimator/type:", "'foo'", "allowed", "ekf, invariant_ekf")
        self.assert_refused({"association/type": "foo"}, "association/type:", "'foo'", "known, nearest_neighbor")
        self.assert_refused({"input/heading_source": "compass"}, "input/heading_source:", "'compass'", "gyrodometry, odometry, imu")
        self.assert_refused({"mode": "mapping"}, "mode:", "'mapping'", "slam, localization")

    def test_a_value_out_of_range(self):
        self.assert_refused({"sensor/max_depth": -1.0}, "sensor/max_depth:", "-1", ">= 0")
        self.assert_refused({"output/marker_rate": 0.0}, "output/marker_rate:", "'0'", "from 0.1 to 100")
        self.assert_refused({"sync/queue_size": 0}, "sync/queue_size:", "'0'", "from 1 to 100000")
        self.assert_refused({"sensor/min_depth": 3.0}, "sensor/min_depth:", "3", "sensor/max_depth, 2.6")

    def test_a_value_of_the_wrong_kind(self):
        self.assert_refused({"sensor/max_depth": "far"}, "sensor/max_depth:", "'far'", "a number")
        self.assert_refused({"output/publish_tf": "perhaps"}, "output/publish_tf:", "'perhaps'", "true or false")
        self.assert_refused({"sync/queue_size": 1.5}, "sync/queue_size:", "'1.5'", "a whole number")
        self.assert_refused({"sync/odometry_topic": ""}, "sync/odometry_topic:", "not empty")
        self.assert_refused({"frames/static_transforms": ["camera"]}, "frames/static_transforms:", "parent, child")

    def test_two_frames_that_are_the_same(self):
        for key, value in (("frames/map", "odom"), ("frames/odom", "base_footprint"), ("frames/base", "map")):
            self.assert_refused({key: value}, key, "'%s'" % value, "three different frames")

    def test_a_frame_with_a_leading_slash(self):
        self.assert_refused({"frames/map": "/map"}, "frames/map:", "'/map'", "no leading slash")

    def test_localization_without_a_map(self):
        self.assert_refused({"mode": "localization"}, "mode:", "localization", "map/load_at_start")

    def test_a_map_that_cannot_be_loaded(self):
        with tempfile.TemporaryDirectory() as folder:
            overrides = {"map/load_at_start": True, "map/directory": folder, "map/file_name": "room.yaml"}
            self.assert_refused(overrides, os.path.join(folder, "room.yaml"), "cannot be read")
            with open(os.path.join(folder, "room.yaml"), "w", encoding="utf-8") as file:
                file.write("image: room.pgm\n")
            self.assert_refused(overrides, os.path.join(folder, "room.yaml"), "not a map")
            self.assert_refused(dict(overrides, **{"map/file_name": "../room.yaml"}), "'../room.yaml'", "plain file name")

    def test_no_parameters_at_all(self):
        self.assert_refused({group: None for group in ("mode", "frames", "sync", "input", "motion", "sensor", "estimator",
                                                       "association", "map")}, "frames/map:", "missing")


class Unread(SlamCase):
    def test_a_key_that_nothing_reads_is_warned_about_and_the_node_runs(self):
        run = self.start({"sensor/max_dpeth": 3.0, "sensors/max_depth": 3.0, "speed": 1})
        for key in ("sensor/max_dpeth", "sensors/max_depth", "speed"):
            self.assertEqual(run.process.said().count("Parameter %s is not known" % key), 1, run.process.said())
        run.drive(0.4)
        self.assertEqual(len(run.saved_map()["landmarks"]), 4)

    def test_the_shipped_parameters_are_all_read(self):
        self.assertNotIn("not known", self.start().process.said())


if __name__ == "__main__":
    rospy.init_node("test_start_up")
    rostest.rosrun("kinect_ekf_slam", "test_start_up", "test_start_up")
