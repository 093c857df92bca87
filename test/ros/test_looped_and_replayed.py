#!/usr/bin/python3
"""Bags: played through slam_node as through slam_replay, and played again and again."""
import csv
import os
import subprocess
import sys
import tempfile

import numpy as np
import rospy
import rostest
from visualization_msgs.msg import Marker

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

import scenario  # noqa: E402
from slam_case import SlamCase  # noqa: E402
from node_process import executable  # noqa: E402
from waiting import wait_until  # noqa: E402
from write_bag import write_bag  # noqa: E402


def rows(path):
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


class Replayed(SlamCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.bag = os.path.join(cls.folder.name, "drive.bag")
        cls.sights = write_bag(cls.bag, seconds=30.0)
        subprocess.run([executable("slam_replay"), cls.bag, "--out", cls.folder.name], check=True, stdout=subprocess.DEVNULL)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def play(self, run, rate):
        """rosbag play into the run's namespace."""
        subprocess.run(["rosbag", "play", "--quiet", "--wait-for-subscribers", "--rate", str(rate), "--prefix",
                        run.namespace, self.bag], check=True, stdout=subprocess.DEVNULL, timeout=60)

    def test_slam_node_and_slam_replay_make_the_same_map(self):
        run = self.start()
        self.play(run, 1.0)
        replayed = rows(os.path.join(self.folder.name, "associations.csv"))
        stamps = sorted({int(row["t"].replace(".", "")) for row in replayed})
        self.assertGreaterEqual(len(stamps), self.sights - 2)
        wait_until(lambda: len(run.associations.messages) >= len(stamps), "as many triples formed")
        self.assertEqual([scenario.to_ns(message.header.stamp) for message in run.associations.messages], stamps)

        expected = {int(row["id"]): row for row in rows(os.path.join(self.folder.name, "landmarks.csv"))}
        landmarks = run.saved_map()["landmarks"]
        self.assertEqual(sorted(expected), [landmark["id"] for landmark in landmarks])
        self.assertEqual(len(landmarks), 4)
        for landmark in landmarks:
            row = expected[landmark["id"]]
            np.testing.assert_allclose(landmark["position"], (float(row["x"]), float(row["y"])), rtol=0.0, atol=1e-6)
            self.assertEqual(landmark["observations"], int(row["observations"]))
            true = scenario.LANDMARKS[landmark["source_id"]][1:]
            np.testing.assert_allclose(landmark["position"], true, atol=0.05)

    def test_the_bag_played_twice_makes_two_runs(self):
        run = self.start()
        self.play(run, 20.0)
        wait_until(lambda: len(run.map.last.landmarks) == 4, "the map is there")
        once = run.saved_map()
        self.play(run, 20.0)
        wait_until(lambda: "a new run starts" in run.process.said(), "time went back")
        twice = run.saved_map()
        self.assertEqual(len(twice["landmarks"]), 4)
        self.assertLessEqual(max(landmark["observations"] for landmark in twice["landmarks"]),
                             max(landmark["observations"] for landmark in once["landmarks"]))
        positions = [{item["source_id"]: item["position"] for item in saved["landmarks"]} for saved in (once, twice)]
        for identity, position in positions[0].items():
            np.testing.assert_allclose(positions[1][identity], position, atol=0.01)


class Looped(SlamCase):
    """Stamps that go back to the beginning, as `rosbag play --loop` without a clock makes them."""

    def loop(self, run, start):
        """Begins anew; the robot stands while the node finds out, and what it is sent until then is lost."""
        run.scenario = scenario.Scenario(start, speed=0.0, turn=0.0)
        for _ in range(10):
            step = run.scenario.step()
            run.publish("odom", step.odometry)
        wait_until(lambda: run.pose_stamp() == step.stamp, "the new run has a pose")
        run.scenario.step()
        run.scenario.speed, run.scenario.turn = 0.2, 0.05

    def test_looped_bag_starts_a_new_run(self):
        run = self.start()
        start = run.scenario.stamp
        run.drive(3.0)
        first = {item["source_id"]: item["position"] for item in run.saved_map()["landmarks"]}
        wait_until(lambda: len(run.map.last.landmarks) == 4, "the map is shown")
        for turn in (1, 2):
            markers = len(run.markers.messages)
            self.loop(run, start)
            self.assertEqual(run.saved_map()["landmarks"], [])
            wait_until(lambda: any(marker.action == Marker.DELETEALL for message in run.markers.messages[markers:]  # pylint: disable=cell-var-from-loop
                                   for marker in message.markers), "the markers were cleared")
            run.drive(3.0)
            landmarks = run.saved_map()["landmarks"]
            self.assertEqual(len(landmarks), 4)
            self.assertEqual({item["observations"] for item in landmarks}, {15})
            for item in landmarks:
                np.testing.assert_allclose(item["position"], first[item["source_id"]], atol=1e-6)
            self.assertEqual(run.process.said().count("a new run starts"), turn)
            self.assertNotIn("ERROR", run.process.said())

    def test_the_transform_goes_on_in_the_new_run(self):
        run = self.start()
        start = run.scenario.stamp
        run.drive(3.0)
        self.loop(run, start)
        count = len(run.tf.messages)
        run.drive(1.0)
        wait_until(lambda: len(run.tf.messages) >= count + 9, "each odometry message brings a transform")

    def test_two_strays_from_the_past_are_no_new_run(self):
        run = self.start()
        run.drive(2.0)
        before = run.saved_map()
        for i in range(2):
            run.publish("odom", scenario.odometry_message(run.scenario.stamp - 50 * scenario.SECOND + i, (0.0, 0.0, 0.0), 0.2, 0.0))
        run.wait_for_count("inputs", "refused, odometry: old", 2)
        self.assert_same_state(run.saved_map(), before)
        run.drive(0.4)
        self.assertEqual(len(run.saved_map()["landmarks"]), 4)

    def test_in_localization_the_map_stays(self):
        run = self.start()
        start = run.scenario.stamp
        run.drive(2.0)
        self.assertTrue(run.set_mode("localization").success)
        before = run.saved_map()
        self.loop(run, start)
        run.drive(2.0)
        self.assert_same_landmarks(run.saved_map(), before)


if __name__ == "__main__":
    rospy.init_node("test_looped_and_replayed")
    rostest.rosrun("kinect_ekf_slam", "test_looped_and_replayed", "test_looped_and_replayed")
