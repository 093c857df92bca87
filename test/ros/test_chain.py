#!/usr/bin/python3
"""From rendered pictures to the map: simulation.launch with pictures:=true."""
import math
import os
import sys
import unittest

import rospy
import rostest
import yaml
from kinect_ekf_slam.msg import LandmarkDetectionArray, LandmarkMap

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

from node_process import ROOT, Recorder  # noqa: E402
from waiting import wait_until  # noqa: E402

LONGEST = 240.0  # s of wall time; rendering on a loaded machine is slow
ENOUGH = 4       # landmarks; the robot sees so many in its first metres


def true_landmarks():
    """Of room.yaml as a map that starts at the robot has them: (x, y, landmark)."""
    with open(os.path.join(ROOT, "config", "worlds", "room.yaml"), encoding="utf-8") as file:
        world = yaml.safe_load(file)
    start = world["drive"]["start"]
    c, s = math.cos(math.radians(start["yaw_deg"])), math.sin(math.radians(start["yaw_deg"]))
    for landmark in world["landmarks"]:
        x, y = landmark["x"] - start["x"], landmark["y"] - start["y"]
        yield c * x + s * y, c * y - s * x, landmark


class Chain(unittest.TestCase):
    def test_pictures_become_a_map_with_the_right_landmarks(self):
        maps = Recorder("/slam_node/map", LandmarkMap)
        detections = Recorder("/landmarks", LandmarkDetectionArray)
        self.addCleanup(maps.close)
        self.addCleanup(detections.close)

        def seen_often():
            return [entry for entry in maps.last.landmarks if entry.observations >= 5] if maps.last else []
        wait_until(lambda: len(seen_often()) >= ENOUGH,
                   lambda: "%d landmarks are mapped; the map: %s" % (ENOUGH, maps.last), LONGEST)
        matched = set()
        for entry in seen_often():
            x, y, truth = min(true_landmarks(), key=lambda t: math.hypot(t[0] - entry.position.x, t[1] - entry.position.y))
            self.assertLess(math.hypot(x - entry.position.x, y - entry.position.y), 0.1, entry)
            self.assertEqual(entry.label, truth["label"])
            self.assertAlmostEqual(entry.radius, truth["radius"], delta=0.02)
            self.assertNotIn(truth["id"], matched, "one landmark is mapped twice")
            matched.add(truth["id"])
        self.assertTrue(all(detection.id == -1 for message in detections.messages for detection in message.detections),
                        "a colour is no identity")


if __name__ == "__main__":
    rospy.init_node("test_chain")
    rostest.rosrun("kinect_ekf_slam", "test_chain", "test_chain")
