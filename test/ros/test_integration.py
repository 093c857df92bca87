#!/usr/bin/python3
"""slam_node beside other packages, by the launch files that the documentation gives; test/stand_ins has what Debian lacks."""
import math
import os
import signal
import subprocess
import sys
import tempfile
import unittest
import xmlrpc.client

import genpy.dynamic
import numpy as np
import rospy
import rostest
import yaml
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped, PoseWithCovarianceStamped, Transform, Twist, Vector3
from kinect_ekf_slam.msg import LandmarkDetectionArray, LandmarkMap
from nav_msgs.msg import Odometry
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

import scenario  # noqa: E402
from node_process import ROOT, Recorder, executable  # noqa: E402
from slam_case import SlamCase  # noqa: E402
from waiting import DEADLINE, wait_until  # noqa: E402

LONGEST = 60.0  # s of wall time, for a robot to drive some metres

FIDUCIALS = """std_msgs/Header header
int32 image_seq
fiducial_msgs/FiducialTransform[] transforms
"""
FIDUCIAL = """int32 fiducial_id
geometry_msgs/Transform transform
float64 image_error
float64 object_error
float64 fiducial_area
"""
TAGS = """std_msgs/Header header
apriltag_ros/AprilTagDetection[] detections
"""
TAG = """int32[] id
float64[] size
geometry_msgs/PoseWithCovarianceStamped pose
"""


class Launch:
    """roslaunch of a file in test/ros, with the stand-ins found."""

    def __init__(self, name):
        paths = [os.path.join(ROOT, "test", "stand_ins"), os.environ["ROS_PACKAGE_PATH"]]
        self._log = tempfile.TemporaryFile(mode="w+")
        self._process = subprocess.Popen(
            ["roslaunch", os.path.join(ROOT, "test", "ros", name)], stdout=self._log, stderr=subprocess.STDOUT,
            env=dict(os.environ, ROS_PACKAGE_PATH=os.pathsep.join(paths)))

    def said(self):
        self._log.seek(0)
        return self._log.read()

    def close(self):
        self._process.send_signal(signal.SIGINT)
        self._process.wait(timeout=DEADLINE)


def start_in_world():
    with open(os.path.join(ROOT, "config", "worlds", "room.yaml"), encoding="utf-8") as file:
        start = yaml.safe_load(file)["drive"]["start"]
    return start["x"], start["y"], math.radians(start["yaw_deg"])


def in_map(x, y):
    """Of a place in the room; the map begins where the robot does."""
    start_x, start_y, heading = start_in_world()
    dx, dy = x - start_x, y - start_y
    return (math.cos(heading) * dx + math.sin(heading) * dy, -math.sin(heading) * dx + math.cos(heading) * dy)


def distance(position, place):
    return math.hypot(position.x - place[0], position.y - place[1])


class LaunchCase(unittest.TestCase):
    def launch(self, name):
        launched = Launch(name)
        self.addCleanup(launched.close)
        return launched

    def record(self, topic, kind):
        recorder = Recorder(topic, kind)
        self.addCleanup(recorder.close)
        return recorder

    def true_position(self, truth):
        return in_map(truth.last.pose.position.x, truth.last.pose.position.y)


class RobotLocalization(LaunchCase):
    def test_its_odometry_is_used_and_it_uses_the_pose_with_its_covariance(self):
        truth = self.record("/ground_truth/pose", PoseStamped)
        pose = self.record("/slam_node/pose", PoseWithCovarianceStamped)
        fused = self.record("/odometry/filtered_map", Odometry)
        slam_map = self.record("/slam_node/map", LandmarkMap)
        tf = self.record("/tf", TFMessage)
        commands = rospy.Publisher("/cmd_vel", Twist, queue_size=1)
        self.addCleanup(commands.unregister)
        launched = self.launch("integration_robot_localization.launch")
        wait_until(lambda: truth.last and pose.last and fused.last, lambda: "all have begun:\n" + launched.said(), LONGEST)

        def has_driven():  # a robot that is told nothing stands still, so that all begin where it does
            commands.publish(linear=Vector3(x=0.2), angular=Vector3(z=0.2))
            return (slam_map.last and len(slam_map.last.landmarks) >= 3 and
                    math.hypot(*self.true_position(truth)) > 0.5)
        wait_until(has_driven, lambda: "three landmarks are mapped:\n" + launched.said(), LONGEST)
        commands.publish()

        def agree():
            place = self.true_position(truth)
            return max(distance(pose.last.pose.pose.position, place), distance(fused.last.pose.pose.position, place)) < 0.15
        wait_until(agree, lambda: "both are where the robot is: %s %s %s" % (truth.last, pose.last, fused.last))
        self.assertNotIn("ekf_localization_node: ", launched.said())
        publishers = {}
        for message in tf.messages:
            for transform in message.transforms:
                publishers.setdefault((transform.header.frame_id, transform.child_frame_id),
                                      set()).add(message._connection_header["callerid"])
        self.assertEqual(publishers, {("odom", "base_footprint"): {"/ekf_odom"}, ("map", "odom"): {"/ekf_map"}})


class Navigation(LaunchCase):
    def test_a_goal_in_the_map_is_reached(self):
        truth = self.record("/ground_truth/pose", PoseStamped)
        goals = rospy.Publisher("/move_base_simple/goal", PoseStamped, queue_size=1, latch=True)
        self.addCleanup(goals.unregister)
        launched = self.launch("integration_navigation.launch")
        goal = PoseStamped()
        goal.header.frame_id = "map"
        goal.pose.position.x, goal.pose.position.y = place = in_map(3.2, 2.9)
        goal.pose.orientation.w = 1.0
        goals.publish(goal)
        wait_until(lambda: truth.last and math.hypot(*np.subtract(self.true_position(truth), place)) < 0.15,
                   lambda: "the robot is at %s: %s\n%s" % (place, truth.last, launched.said()), LONGEST)


class CorrectionTime(SlamCase):
    """The robot drives blind with a wheel error, then sees the landmarks again."""
    TIME_CONSTANT = 0.5  # s

    def shown_pose(self, run):
        """(x, y) of the robot by tf and odometry."""
        stamp = run.pose_stamp()

        def newest():
            transform = run.tf.last.transforms[0] if run.tf.last else None
            ahead = transform and scenario.to_ns(transform.header.stamp) - stamp
            return transform.transform if transform and ahead == scenario.SECOND // 10 else None
        transform = wait_until(newest, "tf of this pose came")
        heading = scenario.heading_of(transform.rotation)
        x, y, _ = run.scenario_pose
        return np.array([transform.translation.x + math.cos(heading) * x - math.sin(heading) * y,
                         transform.translation.y + math.sin(heading) * x + math.cos(heading) * y])

    def steps(self, correction_time):
        """Of what is told on ~pose and by tf, m from one odometry message to the next, and how far both are apart at the end."""
        run = self.start({"output/correction_time": correction_time, "association/type": "known",
                          "motion/linear_noise_per_speed": 1.0}, odometry_scale=0.7, turn=0.0)
        run.drive(1.0)
        run.drive(3.0, look=False)
        told, shown = [], []
        for look in [False, False] + 20 * [True]:
            run.scenario_pose = run.scenario.pose_in_odom
            step = run.scenario.step()
            step.detections = step.detections if look else None
            run.send(step)
            told.append(run.pose_in_map()[:2])
            shown.append(self.shown_pose(run))
        lengths = [np.linalg.norm(np.diff(path, axis=0), axis=1) for path in (told, shown)]
        return (*lengths, np.linalg.norm(np.subtract(told[-1], shown[-1])))

    def test_without_it_tf_jumps_as_the_pose_does(self):
        told, shown, apart = self.steps(0.0)
        self.assertGreater(told.max(), 0.1)
        np.testing.assert_allclose(shown, told, atol=1e-6)
        self.assertLess(apart, 1e-6)

    def test_with_it_tf_moves_gradually_to_the_pose_which_still_jumps(self):
        told, shown, apart = self.steps(self.TIME_CONSTANT)
        self.assertGreater(told.max(), 0.1)
        odometry = 0.7 * 0.2 * 0.1
        first = 1.0 - math.exp(-0.1 / self.TIME_CONSTANT)
        self.assertLess(shown.max(), odometry + 1.1 * first * told.max())
        lag = (1.0 - 0.7) * 0.2 * self.TIME_CONSTANT   # the wheels stay wrong, so there is always something to correct
        self.assertLess(apart, 1.5 * lag)


class Converter(SlamCase):
    """Other packages' detections become landmarks; the packages are not there."""

    def start_with_converter(self, kind, *parameters, association="known"):
        run = self.start({"association/type": association})
        process = subprocess.Popen([executable("convert_detections.py"), "__ns:=" + run.namespace, *parameters],
                                   stderr=subprocess.PIPE)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait, DEADLINE)
        self.addCleanup(process.terminate)
        publisher = rospy.Publisher(run.namespace + "/detections", kind, queue_size=10)
        self.addCleanup(publisher.unregister)
        wait_until(publisher.get_num_connections, "the converter listens")
        wait_until(lambda: run.process.name in self.listeners(run), "slam_node hears the converter")
        return run, publisher

    @staticmethod
    def listeners(run):
        """The nodes that are connected to the converter's output."""
        try:
            uri = rospy.get_master().lookupNode(run.namespace + "/convert_detections")[2]
            connections = xmlrpc.client.ServerProxy(uri).getBusInfo(rospy.get_name())[2]
        except OSError:
            return []
        return [connection[1] for connection in connections if connection[2] == "o" and connection[4].endswith("/landmarks")]

    def outcomes(self, run, publisher, convert):
        """What became of the detections of the third look."""
        converted = Recorder(run.namespace + "/landmarks", LandmarkDetectionArray)
        self.addCleanup(converted.close)
        wait_until(lambda: rospy.get_name() in self.listeners(run), "the test hears the converter")
        for _ in range(5):
            step = run.scenario.step()
            detections, step.detections = step.detections, None
            if detections:
                publisher.publish(convert(detections))
                looked = step.stamp
                wait_until(lambda: converted.last and scenario.to_ns(converted.last.header.stamp) == looked,
                           "the detections were converted")
            run.send(step)
        run.drive(0.2, look=False)
        return run.wait_for_associations(looked).associations

    def assert_all_matched(self, outcomes):
        self.assertEqual({outcome.verdict for outcome in outcomes}, {"matched"})
        self.assertEqual(sorted(outcome.source_id for outcome in outcomes), sorted(scenario.LANDMARKS))

    def test_fiducial_transforms(self):
        kinds = classes_of({"fiducial_msgs/FiducialTransformArray": FIDUCIALS, "fiducial_msgs/FiducialTransform": FIDUCIAL}, [Header, Transform])

        def convert(detections):
            message = kinds["fiducial_msgs/FiducialTransformArray"](header=detections.header)
            for detection in detections.detections:
                fiducial = kinds["fiducial_msgs/FiducialTransform"](fiducial_id=detection.id)
                fiducial.transform.translation = Vector3(*xyz(detection))
                message.transforms.append(fiducial)
            return message

        run, publisher = self.start_with_converter(kinds["fiducial_msgs/FiducialTransformArray"], "_sigma:=0.01", "_label:=tag")
        self.assert_all_matched(self.outcomes(run, publisher, convert))
        wait_until(lambda: {landmark.label for landmark in run.map.last.landmarks} == {"tag"}, "the label is told")

    def test_april_tags(self):
        kinds = classes_of({"apriltag_ros/AprilTagDetectionArray": TAGS, "apriltag_ros/AprilTagDetection": TAG},
                           [Header, PoseWithCovarianceStamped])

        def convert(detections):
            message = kinds["apriltag_ros/AprilTagDetectionArray"](header=detections.header)
            for detection in detections.detections:
                tag = kinds["apriltag_ros/AprilTagDetection"](id=[detection.id], size=[0.1])
                tag.pose.pose.pose.position = Point(*xyz(detection))
                tag.pose.pose.covariance = (1e-4 * np.eye(6)).ravel().tolist()
                message.detections.append(tag)
            return message

        run, publisher = self.start_with_converter(kinds["apriltag_ros/AprilTagDetectionArray"])
        self.assert_all_matched(self.outcomes(run, publisher, convert))

    def test_pose_array(self):
        def convert(detections):
            return PoseArray(header=detections.header,
                             poses=[Pose(position=Point(*xyz(detection))) for detection in detections.detections])

        run, publisher = self.start_with_converter(PoseArray, association="nearest_neighbor")
        outcomes = self.outcomes(run, publisher, convert)
        self.assertEqual([(outcome.verdict, outcome.source_id) for outcome in outcomes], 4 * [("matched", -1)])


def xyz(detection):
    return detection.position.x, detection.position.y, detection.position.z


def classes_of(texts, used):
    """Classes of the messages `texts` {type: definition}, which no installed package has; the first one is the outermost."""
    rule = 80 * "=" + "\n"
    parts = {}
    for kind in used:
        own, *others = kind._full_text.split(rule)
        parts[kind._type] = own
        parts.update(section[len("MSG: "):].split("\n", 1) for section in others)
    outermost, *inner = texts.items()
    sections = [outermost[1]] + ["MSG: %s\n%s" % part for part in [*inner, *parts.items()]]
    return genpy.dynamic.generate_dynamic(outermost[0], rule.join(sections))


if __name__ == "__main__":
    rospy.init_node("test_integration")
    rostest.rosrun("kinect_ekf_slam", "test_integration", "test_integration")
