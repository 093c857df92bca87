#!/usr/bin/python3
"""The kidnapped robot: slam_node finds it again in a known map, when asked to or when it notices by itself."""
import os
import sys

import rospy
import rostest
from std_srvs.srv import Trigger

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

import scenario  # noqa: E402
from slam_case import SlamCase, matrix  # noqa: E402
from waiting import wait_until  # noqa: E402

# Landmarks all round a robot that drives in a circle: it sees some wherever it is.
ROOM = {1: ("red", 1.9, 0.3), 2: ("green", 1.6, 1.5), 3: ("blue", 0.5, 2.4), 4: ("red", -0.6, 2.2), 5: ("yellow", -1.7, 1.6),
        6: ("green", -1.5, 0.2), 7: ("blue", -1.2, -0.9), 8: ("yellow", 0.3, -1.3), 9: ("red", 1.3, -0.8)}
SPEED, TURN = 0.2, 0.4  # m/s, rad/s
ROUND = 16.0  # s
ELSEWHERE = (-0.5, 0.9, 2.5)  # m, m, rad; nowhere near where the robot believes to be
LOOK = scenario.STEPS_PER_SIGHT * scenario.PERIOD / scenario.SECOND  # s from one sighting to the next


class Relocalization(SlamCase):
    def start_in_saved_map(self, overrides=None):
        """A node that localises in the map that another has saved; it knows where the robot is."""
        mapper = self.start(landmarks=ROOM, speed=SPEED, turn=TURN)
        mapper.drive(ROUND)
        self.assertEqual(len(mapper.saved_map()["landmarks"]), len(ROOM))
        self.assertTrue(mapper.save_map("map.yaml").success)
        run = self.start({"mode": "localization", "map/load_at_start": True, **(overrides or {})},
                         map_directory=mapper.map_directory, landmarks=ROOM, speed=SPEED, turn=TURN)
        run.drive(2.0)
        self.assert_knows_its_place(run)
        self.wait_for_state(run, "tracking")
        return run

    def relocalize(self, run):
        return run.call("relocalize", Trigger)

    def state(self, run):
        return run.diagnostics("estimate").get("localization")

    def wait_for_state(self, run, state):
        wait_until(lambda: self.state(run) == state, lambda: "diagnostics say %s, not %s" % (state, self.state(run)))

    def is_unknown(self, run):
        """The pose as published is somewhere within many metres."""
        return matrix(run.pose.last.pose.covariance)[0, 0] > 25.0

    def drive_until(self, run, condition, what):
        def drive_and_ask():
            run.drive(LOOK)
            return condition()

        wait_until(drive_and_ask, lambda: "%s; diagnostics: %s" % (what, run.diagnostics("estimate")))

    def assert_knows_its_place(self, run):
        run.drive(LOOK)
        step = run.scenario.step()
        run.send(step)
        self.assert_pose_near(run.pose_in_map(), step.pose, 0.06)
        self.assertLess(matrix(run.pose.last.pose.covariance)[0, 0], 0.1**2)

    def assert_is_found(self, run, map_before):
        """The search ends at the truth, and the map is still the one that was loaded."""
        self.drive_until(run, lambda: not self.is_unknown(run), "the search ends")
        self.wait_for_state(run, "found")
        self.assert_knows_its_place(run)
        self.assert_same_landmarks(run.saved_map(), map_before)

    def test_a_robot_that_was_carried_away_is_found_when_asked_for(self):
        run = self.start_in_saved_map()
        before = run.saved_map()
        run.scenario.pose_in_map = ELSEWHERE
        reply = self.relocalize(run)
        self.assertTrue(reply.success, reply.message)
        run.drive(2.0, look=False)
        self.wait_for_state(run, "searching")
        self.assertTrue(self.is_unknown(run))
        self.assertIn("searching", run.diagnostics("estimate")["message"])
        self.assert_is_found(run, before)

    def test_a_robot_that_is_lost_notices_by_itself(self):
        run = self.start_in_saved_map({"map/relocalize_when_lost": True})
        before = run.saved_map()
        run.scenario.pose_in_map = ELSEWHERE
        self.drive_until(run, lambda: self.is_unknown(run), "the robot notices that it is lost")
        run.drive(2.0, look=False)
        self.wait_for_state(run, "searching")
        self.assert_is_found(run, before)

    def test_unless_that_is_wanted_nobody_searches(self):
        run = self.start_in_saved_map()
        run.scenario.pose_in_map = ELSEWHERE
        run.drive(ROUND)
        self.assertFalse(self.is_unknown(run))
        self.wait_for_state(run, "lost")

    def test_where_the_map_may_still_change_it_is_refused(self):
        run = self.start()
        run.drive(1.0)
        reply = self.relocalize(run)
        self.assertFalse(reply.success)
        self.assertIn("localization", reply.message)
        self.assert_knows_its_place(run)


if __name__ == "__main__":
    rospy.init_node("test_relocalization")
    rostest.rosrun("kinect_ekf_slam", "test_relocalization", "test_relocalization")
