#!/usr/bin/python3
"""Bad messages: each is counted with its reason and leaves no trace in pose and map."""
import math
import os
import sys

import numpy as np
import rospy
import rostest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

import scenario  # noqa: E402
from slam_case import SlamCase  # noqa: E402
from slam_run import recent_start  # noqa: E402


class BadInput(SlamCase):
    """The same run with a bad message in its middle and without it."""

    start_stamp = recent_start()
    _clean_ends = {}  # how the runs without a bad message ended; each is needed many times

    def end_of(self, middle, overrides=None, **options):
        """The run, and what the node holds when `middle(run)` has come between two halves of a drive."""
        run = self.start(overrides, start=self.start_stamp, **options)
        run.drive(0.2, look=False)
        run.drive(1.0)
        run.drive(0.2, look=False)
        middle(run)
        run.drive(0.2, look=False)
        run.drive(1.0)
        return run, run.saved_map(), run.pose_in_map()

    def assert_no_trace(self, disturbed, clean, overrides=None, **options):
        """Both middles end in the same map, to the last bit, and the same pose; returns the disturbed run."""
        kind = (clean.__qualname__, repr(overrides), repr(options))
        if kind not in self._clean_ends:
            self._clean_ends[kind] = self.end_of(clean, overrides, **options)[1:]
        clean_state, clean_pose = self._clean_ends[kind]
        run, state, pose = self.end_of(disturbed, overrides, **options)
        self.assertEqual(len(state["landmarks"]), 4)
        self.assert_same_state(state, clean_state)
        np.testing.assert_allclose(pose, clean_pose, rtol=0.0, atol=1e-12)  # odometry that waits is added in parts
        return run

    def assert_bad_message_is_harmless(self, topic, reason, make, change, **options):
        """`change` spoils what `make(run)` made; it is refused for that reason."""
        def disturbed(run):
            message = make(run)
            change(message, run.scenario.stamp)
            run.publish(topic, message)
            run.drive(0.2, look=False)
            run.wait_for_count("inputs", "refused, %s: %s" % ({"odom": "odometry"}.get(topic, topic), reason))

        run = self.assert_no_trace(disturbed, drive_on, **options)
        self.assertGreaterEqual(int(run.diagnostics("inputs")["refused"]), 1)

    def assert_bad_odometry_is_harmless(self, reason, change):
        self.assert_bad_message_is_harmless(
            "odom", reason, lambda run: scenario.odometry_message(just_before(run), (0.3, 0.0, 0.0), 0.2, 0.5), change)

    def assert_bad_imu_is_harmless(self, reason, change):
        self.assert_bad_message_is_harmless(
            "imu", reason, lambda run: scenario.imu_message(just_before(run), 0.9), change, with_imu=True)

    def assert_bad_position_is_harmless(self, reason, change):
        self.assert_bad_message_is_harmless(
            "global_position", reason, lambda run: scenario.position_message(just_before(run), 3.0, 1.0), change)

    def assert_bad_sight_is_harmless(self, reason, change, **options):
        def make(run):
            message = run.scenario.detections()
            message.header.stamp = scenario.to_ros(run.scenario.stamp - scenario.PERIOD)
            for detection in message.detections:
                detection.position.x += 0.3
            return message

        self.assert_bad_message_is_harmless("landmarks", reason, make, change, **options)

    def assert_bad_detection_is_harmless(self, verdict, change, overrides=None):
        """`change(detection, pose)` spoils one detection beside the good ones of a message."""
        def spoiled(run):
            look(run, lambda pose: change(bad, pose), bad)

        bad = scenario.detection((0.0, 0.0, 0.0), 2.0, 0.9, 99, "white")
        run = self.assert_no_trace(spoiled, look, overrides)
        run.wait_for_count("estimate", "detections, " + verdict)
        self.assertEqual([item.verdict for item in run.verdicts], ["matched"] * 4 + [verdict])


def drive_on(run):
    """The middle of a run without a bad message."""
    run.drive(0.2, look=False)


def look(run, spoil=lambda pose: None, *more):
    """The middle of a run with one sighting and `more` detections in it."""
    step = run.scenario.step()
    spoil(step.pose)
    step.detections.detections.extend(more)
    run.send(step)
    run.send(run.scenario.step())
    run.verdicts = run.wait_for_associations(step.stamp).associations


def just_before(run):
    """ns; between the last step and the next."""
    return run.scenario.stamp - scenario.PERIOD // 2


def set_stamp(offset):
    """A change of a message: its stamp is that of the next step and `offset` ns."""
    def change(message, next_stamp):
        message.header.stamp = scenario.to_ros(next_stamp + offset)
    return change


def set_no_stamp(message, _):
    message.header.stamp = rospy.Time()


def set_future_stamp(message, _):
    message.header.stamp = rospy.Time.now() + rospy.Duration(100.0)


def set_field(path, value):
    """A change of a message: one field, for example "twist.twist.linear.x"."""
    def change(message, *_):
        *parents, name = path.split(".")
        for parent in parents:
            message = getattr(message, parent)
        setattr(message, name, value)
    return change


def twin_of_the_red_one(distance):
    """A change of a detection: it is the red landmark's, but that far aside (m)."""
    def change(detection, pose):
        label, x, y = scenario.LANDMARKS[7]
        twin = scenario.detection(pose, x, y + distance)
        detection.id, detection.label, detection.position = 7, label, twin.position
    return change


class BadOdometry(BadInput):
    def test_velocity_that_is_not_finite(self):
        self.assert_bad_odometry_is_harmless("not finite", set_field("twist.twist.linear.x", math.nan))

    def test_turn_rate_that_is_not_finite(self):
        self.assert_bad_odometry_is_harmless("not finite", set_field("twist.twist.angular.z", math.inf))

    def test_pose_that_is_not_finite(self):
        self.assert_bad_odometry_is_harmless("not finite", set_field("pose.pose.position.y", math.nan))

    def test_orientation_of_zero(self):
        self.assert_bad_odometry_is_harmless("not finite", set_field("pose.pose.orientation.w", 0.0))

    def test_wrong_frame(self):
        self.assert_bad_odometry_is_harmless("frame", set_field("header.frame_id", "map"))

    def test_wrong_child_frame(self):
        self.assert_bad_odometry_is_harmless("frame", set_field("child_frame_id", "camera"))

    def test_no_stamp(self):
        self.assert_bad_odometry_is_harmless("no stamp", set_no_stamp)

    def test_old_stamp(self):
        self.assert_bad_odometry_is_harmless("old", set_stamp(-4 * scenario.PERIOD))

    def test_very_old_stamp(self):
        self.assert_bad_odometry_is_harmless("old", set_stamp(-60 * scenario.SECOND))

    def test_repeated_stamp(self):
        self.assert_bad_odometry_is_harmless("repeated", set_stamp(-scenario.PERIOD))

    def test_future_stamp(self):
        self.assert_bad_odometry_is_harmless("future", set_future_stamp)

    def test_a_velocity_beyond_belief_is_clamped(self):
        run = self.start({"input/max_linear_speed": 0.22})
        run.drive(0.4)
        before = run.pose_in_map()
        message = scenario.odometry_message(run.scenario.stamp, (0.1, 0.0, 0.0), 1e300, 0.0)
        run.publish("odom", message)
        run.scenario.step()
        run.drive(0.1, look=False)
        self.assertLess(run.pose_in_map()[0] - before[0], 0.2 * 0.1 + 0.22 * 0.1 + 1e-6)


class Positions(BadInput):
    def test_another_frame(self):
        def change(message, _):
            message.header.frame_id = "utm"
        self.assert_bad_position_is_harmless("frame", change)

    def test_no_covariance(self):
        def change(message, _):
            message.pose.covariance = [0.0] * 36
        self.assert_bad_position_is_harmless("no covariance", change)


class BadImu(BadInput):
    def test_one_that_says_it_has_no_rates(self):
        def change(message, _):
            message.angular_velocity_covariance[0] = -1.0
        self.assert_bad_imu_is_harmless("no rates", change)

    def test_rate_that_is_not_finite(self):
        self.assert_bad_imu_is_harmless("not finite", set_field("angular_velocity.x", math.nan))

    def test_frame_without_a_transform(self):
        self.assert_bad_imu_is_harmless("no transform", set_field("header.frame_id", "nowhere"))

    def test_no_stamp(self):
        self.assert_bad_imu_is_harmless("no stamp", set_no_stamp)

    def test_old_stamp(self):
        self.assert_bad_imu_is_harmless("old", set_stamp(-4 * scenario.PERIOD))

    def test_repeated_stamp(self):
        self.assert_bad_imu_is_harmless("repeated", set_stamp(-scenario.PERIOD))

    def test_future_stamp(self):
        self.assert_bad_imu_is_harmless("future", set_future_stamp)


class BadSights(BadInput):
    """Detection messages that are bad as a whole."""

    def test_frame_without_a_transform(self):
        self.assert_bad_sight_is_harmless("no transform", set_field("header.frame_id", "nowhere"))

    def test_no_frame(self):
        self.assert_bad_sight_is_harmless("frame", set_field("header.frame_id", ""))

    def test_no_stamp(self):
        self.assert_bad_sight_is_harmless("no stamp", set_no_stamp)

    def test_old_stamp(self):
        self.assert_bad_sight_is_harmless("old", set_stamp(-6 * scenario.PERIOD))

    def test_very_old_stamp(self):
        self.assert_bad_sight_is_harmless("old", set_stamp(-60 * scenario.SECOND))

    def test_repeated_stamp(self):
        def change(message, next_stamp):  # that of the last good sighting
            message.header.stamp = scenario.to_ros(next_stamp - 4 * scenario.PERIOD)
        self.assert_bad_sight_is_harmless("repeated", change)

    def test_future_stamp(self):
        self.assert_bad_sight_is_harmless("future", set_future_stamp)

    def test_no_odometry_of_its_time(self):
        def disturbed(run):
            message = run.scenario.detections()
            message.header.stamp = scenario.to_ros(just_before(run))
            run.publish("landmarks", message)
            run.drive(0.2, look=False)

        run = self.assert_no_trace(disturbed, drive_on, {"sync/max_interval": 0.02})
        run.wait_for_count("inputs", "refused, landmarks: unsynchronized")

    def test_an_empty_message_means_that_nothing_was_seen(self):
        run = self.start()
        run.drive(1.0)
        before = run.saved_map()
        run.scenario.landmarks = {}
        run.drive(0.6)
        self.assertEqual(run.associations.last.associations, [])
        self.assert_same_landmarks(run.saved_map(), before)
        self.assertEqual(int(run.diagnostics("inputs").get("refused", 0)), 0)


class BadDetections(BadInput):
    """Single detections that are bad, among good ones."""

    def test_position_that_is_not_finite(self):
        for value in (math.nan, math.inf, -math.inf):
            self.assert_bad_detection_is_harmless("invalid", set_field("position.x", value))

    def test_covariance_that_is_not_finite(self):
        self.assert_bad_detection_is_harmless("invalid", set_field("covariance", [math.nan] * 9))

    def test_covariance_that_is_not_positive_definite(self):
        self.assert_bad_detection_is_harmless(
            "invalid", set_field("covariance", (1e-4 * np.diag([1.0, 1.0, -1.0])).ravel().tolist()))

    def test_covariance_that_is_not_symmetric(self):
        skewed = 1e-4 * np.eye(3)
        skewed[0, 2] = 5e-5
        self.assert_bad_detection_is_harmless("invalid", set_field("covariance", skewed.ravel().tolist()))

    def test_the_same_identity_twice(self):
        self.assert_bad_detection_is_harmless("duplicate", twin_of_the_red_one(0.015), {"association/type": "known"})

    def test_the_same_identity_twice_in_two_places(self):
        self.assert_bad_detection_is_harmless("outside_gate", twin_of_the_red_one(0.5), {"association/type": "known"})

    def test_the_same_landmark_twice(self):
        self.assert_bad_detection_is_harmless("duplicate", twin_of_the_red_one(0.015))

    def test_the_same_new_identity_twice_in_the_first_message(self):
        run = self.start({"association/type": "known"})
        step = run.scenario.step()
        step.detections.detections.append(scenario.detection(step.pose, 2.0, 0.9, 7))
        run.send(step)
        run.send(run.scenario.step())
        verdicts = [item.verdict for item in run.wait_for_associations(step.stamp).associations]
        self.assertEqual(sorted(verdicts), ["created"] * 4 + ["duplicate"])
        run.drive(1.0)
        self.assertEqual(len(run.saved_map()["landmarks"]), 4)


if __name__ == "__main__":
    rospy.init_node("test_bad_input")
    rostest.rosrun("kinect_ekf_slam", "test_bad_input", "test_bad_input")
