"""A robot that drives among four landmarks, as the messages that its sensors would send."""
import math
import random

import numpy as np
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from kinect_ekf_slam.msg import LandmarkDetection, LandmarkDetectionArray
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu

ODOM, BASE, CAMERA, IMU = "odom", "base_footprint", "camera_rgb_optical_frame", "imu_link"
SECOND = 1000000000  # ns
PERIOD = SECOND // 10  # ns between odometry messages
STEPS_PER_SIGHT = 2  # odometry messages from one detection message to the next
DETECTION_VARIANCE = 1e-4  # m^2

CAMERA_IN_BASE = np.array([0.1, 0.0, 0.4])  # m
BASE_FROM_CAMERA_ROTATION = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # columns: X, Y, Z

# identity: (label, x, y) in the map, m; the robot starts at its origin and looks along x
LANDMARKS = {7: ("red", 1.6, 0.6), 3: ("green", 2.0, -0.5), 12: ("blue", 2.3, 0.2), 5: ("yellow", 1.8, 1.2)}


class Step:
    """What the sensors say at one time, and where the robot truly is."""

    def __init__(self, stamp, pose, odometry, imu, detections):
        self.stamp, self.pose, self.odometry, self.imu, self.detections = stamp, pose, odometry, imu, detections


class Scenario:
    """Steps of 0.1 s; noise-free unless a seed is given."""

    def __init__(self, start, speed=0.2, turn=0.05, odometry_scale=1.0, odometry_turn_scale=1.0, with_imu=False,
                 landmarks=None, seed=None):
        self.stamp = int(start)  # ns
        self.speed, self.turn = speed, turn  # m/s, rad/s
        self.odometry_scale, self.odometry_turn_scale = odometry_scale, odometry_turn_scale
        self.with_imu = with_imu
        self.landmarks = dict(LANDMARKS if landmarks is None else landmarks)
        self.pose_in_map = (0.0, 0.0, 0.0)  # m, m, rad
        self.pose_in_odom = (0.0, 0.0, 0.0)
        self._random = random.Random(seed) if seed is not None else None
        self._steps = 0

    def step(self):
        """What is measured now; then the robot drives on until the next step."""
        speed, turn = self.odometry_scale * self.speed, self.odometry_turn_scale * self.turn
        speed, turn = speed + self._noise(0.01), turn + self._noise(0.01)
        odometry = odometry_message(self.stamp, self.pose_in_odom, speed, turn)
        imu = imu_message(self.stamp, self.turn + self._noise(0.002)) if self.with_imu else None
        detections = self.detections() if self._steps % STEPS_PER_SIGHT == 0 else None
        step = Step(self.stamp, self.pose_in_map, odometry, imu, detections)
        self.pose_in_map = drive(self.pose_in_map, self.speed, self.turn, PERIOD / SECOND)
        self.pose_in_odom = drive(self.pose_in_odom, speed, turn, PERIOD / SECOND)
        self.stamp += PERIOD
        self._steps += 1
        return step

    def detections(self):
        """All landmarks as the camera sees them now."""
        message = LandmarkDetectionArray()
        message.header.stamp, message.header.frame_id = to_ros(self.stamp), CAMERA
        for identity, (label, x, y) in sorted(self.landmarks.items()):
            noise = [self._noise(math.sqrt(DETECTION_VARIANCE)) for _ in range(3)]
            message.detections.append(detection(self.pose_in_map, x, y, identity, label, noise))
        return message

    def _noise(self, sigma):
        return self._random.gauss(0.0, sigma) if self._random else 0.0


def to_ros(stamp):
    return rospy.Time(stamp // SECOND, stamp % SECOND)


def to_ns(stamp):
    return stamp.secs * SECOND + stamp.nsecs


def drive(pose, speed, turn, seconds):
    """The pose after an arc."""
    x, y, heading = pose
    after = heading + turn * seconds
    if abs(turn) < 1e-9:
        return x + speed * seconds * math.cos(heading), y + speed * seconds * math.sin(heading), after
    radius = speed / turn
    return x + radius * (math.sin(after) - math.sin(heading)), y - radius * (math.cos(after) - math.cos(heading)), after


def heading_of(orientation):
    """rad, of a quaternion that turns about z alone."""
    return 2.0 * math.atan2(orientation.z, orientation.w)


def set_pose(message, pose):
    """Puts (x, y, heading) into a geometry_msgs/Pose."""
    message.position.x, message.position.y = pose[0], pose[1]
    message.orientation.z, message.orientation.w = math.sin(0.5 * pose[2]), math.cos(0.5 * pose[2])


def odometry_message(stamp, pose_in_odom, speed, turn):
    message = Odometry()
    message.header.stamp, message.header.frame_id, message.child_frame_id = to_ros(stamp), ODOM, BASE
    set_pose(message.pose.pose, pose_in_odom)
    message.twist.twist.linear.x, message.twist.twist.angular.z = speed, turn
    return message


def position_message(stamp, x, y, frame="map", variance=1e-4):
    message = PoseWithCovarianceStamped()
    message.header.stamp, message.header.frame_id = to_ros(stamp), frame
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    message.pose.pose.orientation.w = 1.0
    message.pose.covariance = np.diag([variance] * 3 + [0.0] * 3).ravel().tolist()
    return message


def imu_message(stamp, turn):
    """Of an IMU that lies on its left side: its y axis points up."""
    message = Imu()
    message.header.stamp, message.header.frame_id = to_ros(stamp), IMU
    message.orientation_covariance[0] = -1.0
    message.angular_velocity.y = turn
    return message


def detection(pose_in_map, x, y, identity=-1, label="", noise=(0.0, 0.0, 0.0)):
    """A landmark at (x, y) in the map and at the camera's height, seen from the robot's pose."""
    dx, dy = x - pose_in_map[0], y - pose_in_map[1]
    cosine, sine = math.cos(pose_in_map[2]), math.sin(pose_in_map[2])
    in_base = np.array([cosine * dx + sine * dy, -sine * dx + cosine * dy, CAMERA_IN_BASE[2]])
    in_camera = BASE_FROM_CAMERA_ROTATION.T.dot(in_base - CAMERA_IN_BASE) + np.array(noise)
    message = LandmarkDetection(id=identity, label=label, score=1.0)
    message.position.x, message.position.y, message.position.z = in_camera
    message.covariance = (DETECTION_VARIANCE * np.eye(3)).ravel().tolist()
    return message


def mountings():
    """base -> camera and base -> IMU, as /tf_static says them."""
    half = math.sqrt(0.5)
    return [_mounting(CAMERA, CAMERA_IN_BASE, (-0.5, 0.5, -0.5, 0.5)),
            _mounting(IMU, (0.0, 0.0, 0.1), (half, 0.0, 0.0, half))]


def _mounting(child, xyz, xyzw):
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = BASE, child
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = xyz
    rotation.x, rotation.y, rotation.z, rotation.w = xyzw
    return message
