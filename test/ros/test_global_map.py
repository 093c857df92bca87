#!/usr/bin/python3
"""slam_node's global map: a robot with a GPS drives from one group of landmarks to another one, out of sight of both."""
import os
import sys
import unittest

import numpy as np
import rospy
import rostest
from kinect_ekf_slam.msg import LandmarkMap
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

from node_process import Recorder  # noqa: E402
from recording import Recording, positions  # noqa: E402
from slam_run import SlamRun  # noqa: E402
from waiting import wait_until  # noqa: E402

OVERRIDES = {"association/type": "nearest_neighbor", "global_map/enabled": True, "global_map/period": 0.5,
             "map/confirm_sightings": 5, "map/remove_after_visits": 4}  # as shipped, but for the first two


class GlobalMap(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.drive = Recording("yard.yaml")
        cls.run_of_drive = SlamRun(OVERRIDES, mountings=cls.drive.mountings)
        cls.addClassCleanup(cls.run_of_drive.close)
        name = cls.run_of_drive.process.name
        cls.maps = Recorder(name + "/global_map", LandmarkMap)
        cls.markers = Recorder(name + "/global_markers", MarkerArray)
        cls.transforms = Recorder(cls.run_of_drive.namespace + "/tf_static", TFMessage)
        for recorder in (cls.maps, cls.markers, cls.transforms):
            cls.addClassCleanup(recorder.close)
        cls.drive.play(cls.run_of_drive)
        end = cls.drive.of("/odom")[-1].header.stamp.to_sec()
        wait_until(lambda: cls.maps.last and cls.maps.last.header.stamp.to_sec() > end - 2.0, "the map of the whole drive")

    def test_the_landmarks_are_where_they_are_in_the_frame_of_the_positions(self):
        self.assertEqual(self.maps.last.header.frame_id, "earth")
        true = self.drive.true_landmarks
        found = positions(self.maps.last)  # the simulator tells who is who; the association does not ask
        self.assertEqual(set(found), set(true))
        errors = np.array([np.subtract(found[i], true[i])[:2] for i in sorted(true)])
        self.assertLess(np.sqrt((errors**2).sum(1).mean()), 0.2)  # the GPS: 0.42 m

    def test_the_covariances_are_those_of_the_errors(self):
        true, nees = self.drive.true_landmarks, []
        for item in self.maps.last.landmarks:
            covariance = np.array(item.covariance).reshape(3, 3)[:2, :2]
            error = np.subtract((item.position.x, item.position.y), true[item.source_id][:2])
            nees.append(error @ np.linalg.solve(covariance, error))
        self.assertLess(np.mean(nees), 6.0)  # of 2; the landmarks of one group err together

    def test_each_stretch_of_the_way_has_a_colour(self):
        stretches = [marker for marker in self.markers.last.markers if marker.ns == "segments"]
        self.assertGreater(len(stretches), 1)
        self.assertEqual({(marker.header.frame_id, marker.type) for marker in stretches}, {("earth", Marker.LINE_STRIP)})
        colours = {(marker.color.r, marker.color.g, marker.color.b) for marker in stretches}
        self.assertEqual(len(colours), len(stretches))

    def test_tf_leads_from_the_frame_of_the_positions_to_the_map(self):
        found = [(transform.header.frame_id, transform.child_frame_id)
                 for message in self.transforms.messages for transform in message.transforms]
        self.assertIn(("earth", "map"), found)

    def test_diagnostics_say_what_was_placed(self):
        status = wait_until(lambda: self.run_of_drive.diagnostics("global map"), "diagnostics of the global map")
        self.assertEqual(status["stretches placed"], status["stretches"])
        self.assertGreater(int(status["positions"]), 200)
        self.assertEqual(status["frame"], "earth")


class Reset(unittest.TestCase):
    def test_forgets_the_global_map(self):
        drive = Recording("yard.yaml", seconds=40)
        with SlamRun(OVERRIDES, mountings=drive.mountings) as run:
            maps = Recorder(run.process.name + "/global_map", LandmarkMap)
            self.addCleanup(maps.close)
            drive.play(run)
            wait_until(lambda: maps.last and maps.last.landmarks, "landmarks in the global frame")
            self.assertTrue(run.reset().success)
            wait_until(lambda: not maps.last.landmarks, "the global map is empty")


if __name__ == "__main__":
    rospy.init_node("test_global_map")
    rostest.rosrun("kinect_ekf_slam", "test_global_map", "test_global_map")
