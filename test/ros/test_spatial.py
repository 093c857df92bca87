#!/usr/bin/python3
"""slam_node in space: a simulated robot flies through a room of balls; what is published is right in all six axes."""
import copy
import os
import sys
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import PoseWithCovarianceStamped
from visualization_msgs.msg import Marker

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

from node_process import ROOT  # noqa: E402
from recording import Recording, positions  # noqa: E402
from slam_run import SlamRun  # noqa: E402
from waiting import wait_until  # noqa: E402

sys.path.insert(0, os.path.join(ROOT, "scripts"))

from slam_tools.spherical import position_and_covariance  # noqa: E402

FLIGHT = 60.0  # s: the first of two loops
OVERRIDES = {"estimator/space": "spatial", "estimator/type": "invariant_ekf"}  # as config/spatial.yaml


def matrix_of(position, orientation):
    """4 x 4, of a pose's or transform's parts."""
    x, y, z, w = orientation.x, orientation.y, orientation.z, orientation.w
    result = np.eye(4)
    result[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    result[:3, 3] = position.x, position.y, position.z
    return result


def pose_matrix(pose):
    return matrix_of(pose.position, pose.orientation)


def near(messages, stamp):
    """The message of that time, or None."""
    return next((message for message in reversed(list(messages)) if message.header.stamp == stamp), None)


def landmark_rmse(found, true):
    """m, after the best rigid motion."""
    assert set(found) == set(true), (found, true)
    target, source = (np.array([places[i] for i in sorted(true)]) for places in (true, found))
    u, _, vt = np.linalg.svd((target - target.mean(0)).T @ (source - source.mean(0)))
    rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    errors = (source - source.mean(0)) @ rotation.T - (target - target.mean(0))
    return np.sqrt((errors**2).sum(1).mean())


class Spatial(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.flight = Recording("room_3d.yaml", FLIGHT)
        cls.run_of_flight = SlamRun(OVERRIDES, mountings=cls.flight.mountings)
        cls.addClassCleanup(cls.run_of_flight.close)
        cls.flight.play(cls.run_of_flight)
        cls.flight.wait_for_the_map(cls.run_of_flight)

    def test_landmarks_are_at_their_places_and_heights(self):
        found = positions(self.run_of_flight.map.last)
        self.assertLess(landmark_rmse(found, self.flight.true_landmarks), 0.06)
        self.assertGreater(np.ptp([place[2] for place in found.values()]), 0.8)

    def test_every_landmark_has_a_whole_covariance(self):
        for item in self.run_of_flight.map.last.landmarks:
            covariance = np.array(item.covariance).reshape(3, 3)
            np.testing.assert_array_equal(covariance, covariance.T)
            self.assertGreater(np.linalg.eigvalsh(covariance).min(), 1e-8)

    def test_the_pose_follows_the_robot_in_all_six_axes(self):
        pose = self.run_of_flight.pose.last
        covariance = np.array(pose.pose.covariance).reshape(6, 6)
        self.assertGreater(np.linalg.eigvalsh(covariance).min(), 0.0)
        truth = self.flight.of("/ground_truth/pose")
        end = near(truth, pose.header.stamp)
        expected = np.linalg.inv(pose_matrix(truth[0].pose)) @ pose_matrix(end.pose)
        error = np.linalg.inv(expected) @ pose_matrix(pose.pose.pose)
        self.assertLess(np.linalg.norm(error[:3, 3]), 0.2)
        self.assertLess(np.arccos(np.clip((np.trace(error[:3, :3]) - 1) / 2, -1, 1)), 0.1)

    def test_markers_are_ellipsoids_of_the_covariances(self):
        run = self.run_of_flight

        def of_landmark(array, space):
            return {marker.id: marker for marker in array.markers if marker.ns == space and marker.action == Marker.ADD}
        array = wait_until(lambda: next((message for message in reversed(run.markers.messages)
                                         if len(of_landmark(message, "covariance")) == len(self.flight.true_landmarks)), None),
                           "markers of all landmarks")
        spreads, bodies = of_landmark(array, "covariance"), of_landmark(array, "landmarks")
        landmarks = wait_until(lambda: near(run.map.messages, array.markers[0].header.stamp), "the map of that time")
        for item in landmarks.landmarks:
            marker = spreads[item.id]
            self.assertEqual((marker.type, bodies[item.id].type), (Marker.SPHERE, Marker.SPHERE))
            rotation = pose_matrix(marker.pose)[:3, :3]
            half_axes = np.array([marker.scale.x, marker.scale.y, marker.scale.z]) / 2.0 / 3.0  # output/marker_sigmas
            drawn = rotation @ np.diag(half_axes**2) @ rotation.T
            np.testing.assert_allclose(drawn, np.array(item.covariance).reshape(3, 3), atol=2e-6)

    def test_map_to_odom_completes_the_odometry_to_the_pose(self):
        run, odometry_messages = self.run_of_flight, self.flight.of("/odom")

        def matching():
            for message in reversed(run.tf.messages):
                for transform in message.transforms:
                    if transform.header.frame_id == "map" and transform.child_frame_id == "odom":
                        stamp = transform.header.stamp - rospy.Duration(0.1)  # output/transform_tolerance
                        found = near(run.pose.messages, stamp), near(odometry_messages, stamp)
                        if all(found):
                            return (transform.transform, *found)
            return None
        transform, pose, odometry = wait_until(matching, "tf, pose and odometry of one time")
        map_from_odom = matrix_of(transform.translation, transform.rotation)
        np.testing.assert_allclose(map_from_odom @ pose_matrix(odometry.pose.pose), pose_matrix(pose.pose.pose), atol=1e-6)


class RangeBearingElevation(unittest.TestCase):
    """A sensor that measures a range and two angles, as MRPT's data has it: they enter as a position with its covariance."""

    SIGMAS = (0.03, 0.02, 0.02)  # m, rad, rad

    def as_readings(self, message, rng):
        """The detections anew: the camera's points as such a sensor, which looks along x, would read them."""
        message = copy.deepcopy(message)
        message.header.frame_id = "ranger"
        for detection in message.detections:
            right, down, depth = detection.position.x, detection.position.y, detection.position.z
            exact = np.linalg.norm([right, down, depth]), np.arctan2(-right, depth), np.arctan2(-down, np.hypot(right, depth))
            reading = exact + self.SIGMAS * rng.normal(size=3)
            place, covariance = position_and_covariance(*reading, *self.SIGMAS)
            detection.position.x, detection.position.y, detection.position.z = place
            detection.covariance = covariance.ravel().tolist()
        return message

    def test_a_room_is_mapped_from_ranges_and_angles(self):
        flight = Recording("room_3d.yaml", FLIGHT, {"sensor": {"noise_scale": 0.0}})
        rng = np.random.default_rng(5)
        flight.messages = [(topic, self.as_readings(message, rng) if topic == "/landmarks" else message)
                           for topic, message in flight.messages]
        ranger = copy.deepcopy(next(item for item in flight.mountings if item.child_frame_id != "imu_link"))
        ranger.child_frame_id = "ranger"
        rotation = ranger.transform.rotation
        rotation.x, rotation.y, rotation.z, rotation.w = 0.0, 0.0, 0.0, 1.0
        run = SlamRun(OVERRIDES, mountings=[*flight.mountings, ranger])
        self.addCleanup(run.close)
        flight.play(run)
        flight.wait_for_the_map(run)
        self.assertLess(landmark_rmse(positions(run.map.last), flight.true_landmarks), 0.05)


class InitialPose(unittest.TestCase):
    def test_rvizs_says_nothing_of_height_and_tilt(self):
        """Its covariance has zeros there, which would be certainty."""
        run = SlamRun(OVERRIDES)
        self.addCleanup(run.close)
        run.drive(1.0, look=False)
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.pose.position.x, message.pose.pose.position.z, message.pose.pose.orientation.w = 3.0, 1.0, 1.0
        covariance = np.zeros((6, 6))
        covariance[0, 0], covariance[1, 1], covariance[5, 5] = 0.25, 0.25, 0.07
        message.pose.covariance = covariance.ravel().tolist()
        run.publish("initialpose", message)

        def moved():
            run.send(run.scenario.step())
            return run.pose.last.pose.pose.position.x > 2.9

        wait_until(moved, "the pose is the one given")
        self.assertAlmostEqual(run.pose.last.pose.pose.position.z, 1.0, places=3)
        self.assertGreater(np.diag(np.array(run.pose.last.pose.covariance).reshape(6, 6)).min(), 0.05)


if __name__ == "__main__":
    rospy.init_node("test_spatial")
    rostest.rosrun("kinect_ekf_slam", "test_spatial", "test_spatial")
