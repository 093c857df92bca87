"""Messages whose numbers, names and stamps are what no sensor should send."""
import math

import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped
from kinect_ekf_slam.msg import LandmarkDetection

import scenario

NUMBERS = (0.0, -0.0, 1.0, -1.0, 1e-300, 1e9, -1e18, 1e300, math.inf, -math.inf, math.nan)
FRAMES = ("", "/", "odom", "/odom", scenario.BASE, "nowhere", "map", "/map", "x" * 100000, "a\nb")
TEXTS = ("", "red", "\n", "x" * 500, "x" * 50000)
OFFSETS = (-1e6, -100.0, -1.0, -0.01, 0.01, 0.5, 100.0, 1e6)  # s

FIELDS = {"odom": ("twist.twist.linear.x", "twist.twist.linear.y", "twist.twist.angular.z", "pose.pose.position.x",
                   "pose.pose.orientation.z", "pose.pose.orientation.w"),
          "imu": ("angular_velocity.x", "angular_velocity.y", "angular_velocity.z"),
          "initialpose": ("pose.pose.position.x", "pose.pose.position.z", "pose.pose.orientation.z", "pose.pose.orientation.w"),
          "landmarks": ()}


def _set(message, path, value):
    *parents, name = path.split(".")
    for parent in parents:
        message = getattr(message, parent)
    setattr(message, name, value)


def _spoil_header(header, choice):
    if choice.random() < 0.2:
        header.frame_id = choice.choice(FRAMES)
    kind = choice.random()
    if kind < 0.05:
        header.stamp = rospy.Time()
    elif kind < 0.1:
        header.stamp = rospy.Time(4294967295, 999999999)
    elif kind < 0.25:
        header.stamp = scenario.to_ros(max(0, scenario.to_ns(header.stamp) + int(choice.choice(OFFSETS) * scenario.SECOND)))


def _matrix(choice, size):
    """Zero, a diagonal, or anything."""
    kind = choice.randrange(3)
    diagonal = choice.choice(NUMBERS)
    return [0.0 if kind == 0 else choice.choice(NUMBERS) if kind == 1 else diagonal * (i % (size + 1) == 0) for i in range(size * size)]


def _detections(message, choice):
    sound = message.detections
    count = 3000 if choice.random() < 0.005 else choice.randrange(8)
    message.detections = [choice.choice(sound) if sound and choice.random() < 0.3 else _detection(choice) for _ in range(count)]


def _detection(choice):
    made = LandmarkDetection(id=choice.choice((-2147483648, -1, 0, 7, 2147483647)), label=choice.choice(TEXTS))
    made.position.x, made.position.y, made.position.z = (choice.choice((*NUMBERS, choice.uniform(-3.0, 3.0))) for _ in range(3))
    made.covariance = _matrix(choice, 3)
    made.radius, made.score = (min(max(choice.choice(NUMBERS), -1e38), 1e38) for _ in range(2))
    if choice.random() < 0.1:
        made.descriptor = [math.nan] * choice.choice((1, 32, 10000))
    return made


def spoiled(topic, step, choice):
    """A message of that topic, made of what the scenario's step says, with something wrong."""
    stamp = step.stamp + choice.randrange(1, scenario.PERIOD)  # newer than the step, older than the next
    if topic == "odom":
        message = scenario.odometry_message(stamp, step.pose, 0.1, 0.0)
    elif topic == "imu":
        message = scenario.imu_message(stamp, 0.0)
        if choice.random() < 0.3:
            message.angular_velocity_covariance = _matrix(choice, 3)
    elif topic == "landmarks":
        message = step.made_detections
        message.header.stamp = scenario.to_ros(stamp)
        _detections(message, choice)
    else:
        message = PoseWithCovarianceStamped()
        message.header.stamp, message.header.frame_id = scenario.to_ros(stamp), "map"
        message.pose.pose.orientation.w = 1.0
        message.pose.covariance = _matrix(choice, 6)
    for path in FIELDS[topic]:
        if choice.random() < 0.2:
            _set(message, path, choice.choice(NUMBERS))
    _spoil_header(message.header, choice)
    return message
