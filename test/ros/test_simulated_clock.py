#!/usr/bin/python3
"""slam_node on a simulated clock: it stands still, it goes back."""
import os
import sys
import threading

import rospy
import rostest
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool
from visualization_msgs.msg import Marker

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

import scenario  # noqa: E402
from slam_case import SlamCase  # noqa: E402
from waiting import wait_until  # noqa: E402

START = 1500000000 * scenario.SECOND


class SimulatedClock(SlamCase):
    @classmethod
    def setUpClass(cls):
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=100, latch=True, tcp_nodelay=True)

    def set_clock(self, stamp):
        self.clock.publish(Clock(scenario.to_ros(stamp)))
        wait_until(lambda: scenario.to_ns(rospy.Time.now()) == stamp, "the clock is set")

    def turn_clock_back(self, run, stamp):
        """Returns when the node's clock is back as well: it comes on another connection than the odometry."""
        self.set_clock(stamp)
        wait_until(lambda: run.diagnostics("inputs").get("stamp") == stamp, "the node's clock is set")

    def start_at(self, stamp, overrides=None, **options):
        self.set_clock(stamp)
        run = self.start(overrides, start=stamp, **options)
        wait_until(lambda: self.clock.get_num_connections() >= 2, "the node listens to the clock")
        return run

    def drive(self, run, seconds):
        """The scenario goes on and takes the clock along."""
        for _ in range(int(round(seconds * scenario.SECOND / scenario.PERIOD / 2))):
            self.set_clock(run.scenario.stamp)
            run.drive(0.2)

    def test_a_clock_that_goes_back_starts_a_new_run(self):
        run = self.start_at(START)
        self.drive(run, 2.0)
        wait_until(lambda: len(run.map.last.landmarks) == 4, "the map is there")
        markers = len(run.markers.messages)
        self.turn_clock_back(run, START)
        # The robot stands while the node finds out; what it is sent until then is lost.
        run.scenario = scenario.Scenario(START, speed=0.0, turn=0.0)
        for _ in range(4):
            step = run.scenario.step()
            run.publish("odom", step.odometry)
        wait_until(lambda: run.pose_stamp() == step.stamp, "the new run has a pose")
        wait_until(lambda: any(marker.action == Marker.DELETEALL for message in run.markers.messages[markers:]
                               for marker in message.markers), "the markers were cleared")
        run.scenario.speed = 0.2
        self.drive(run, 2.0)
        landmarks = run.saved_map()["landmarks"]
        self.assertEqual({item["observations"] for item in landmarks}, {10})
        for item in landmarks:
            label, x, y = scenario.LANDMARKS[item["source_id"]]
            self.assertAlmostEqual(item["position"][0], x, places=6, msg=label)
            self.assertAlmostEqual(item["position"][1], y, places=6, msg=label)
        wait_until(lambda: len(run.map.last.landmarks) == 4, "~map shows the new run")
        self.assertNotIn("ERROR", run.process.said())

    def test_a_stamp_ahead_of_the_clock_is_refused(self):
        run = self.start_at(START)
        self.drive(run, 1.0)
        run.publish("odom", scenario.odometry_message(run.scenario.stamp + 100 * scenario.SECOND, (9.0, 0.0, 0.0), 0.2, 0.0))
        self.drive(run, 1.0)
        self.assertEqual(len(run.saved_map()["landmarks"]), 4)
        self.set_clock(run.scenario.stamp + 2 * scenario.SECOND)
        run.wait_for_count("inputs", "refused, odometry: future")

    def test_diagnostics_come_while_the_clock_stands_still(self):
        run = self.start_at(START)
        run.drive(0.4)
        run.wait_for_count("estimate", "detections, matched", 4)
        run.drive(0.4)
        run.wait_for_count("estimate", "detections, matched", 12)

    def test_diagnostics_come_after_the_clock_went_back(self):
        run = self.start_at(START + 100 * scenario.SECOND)
        self.drive(run, 3.0)
        run.wait_for_count("estimate", "detections, created", 4)
        self.turn_clock_back(run, START)
        run.scenario = scenario.Scenario(START, speed=0.0, turn=0.0)
        for _ in range(4):
            run.publish("odom", run.scenario.step().odometry)
        wait_until(lambda: "a new run starts" in run.process.said(), "the new run began")
        self.set_clock(START + 5 * scenario.SECOND)
        wait_until(lambda: run.diagnostics("estimate")["detections, created"] == "0", "diagnostics tell of the new run")

    def test_an_unknown_frame_while_the_clock_stands_still_does_not_block_the_node(self):
        run = self.start_at(START)
        run.drive(1.0)
        step = run.scenario.step()
        step.detections.header.frame_id = "nowhere"
        run.send(step)
        run.publish("odom", run.scenario.step().odometry)
        answered = threading.Event()
        caller = threading.Thread(target=lambda: (run.call("pause", SetBool, False), answered.set()), daemon=True)
        caller.start()
        try:
            wait_until(answered.is_set, "a service answered")
        finally:
            self.set_clock(run.scenario.stamp + 10 * scenario.SECOND)  # lets a node that waits go on


if __name__ == "__main__":
    rospy.init_node("test_simulated_clock")
    rostest.rosrun("kinect_ekf_slam", "test_simulated_clock", "test_simulated_clock")
