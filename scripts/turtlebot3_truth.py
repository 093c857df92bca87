#!/usr/bin/python3
"""Adds landmark detections and ground truth to a bag of a TurtleBot3 (waffle) in Gazebo's turtlebot3_world.

IN.bag holds /odom, /imu and /scan of the simulated robot. OUT.bag holds, with the receipt times of IN.bag,

  /odom, /imu              as they are
  /landmarks               kinect_ekf_slam/LandmarkDetectionArray in the scan's frame, one for every scan: the
                           axes of the cylinders found in it, their radius, and the covariance of the circle
                           fit; id -1
  /ground_truth/pose       geometry_msgs/PoseStamped in frame map: the pose of every /odom, which the
                           simulator makes nearly perfect
  /ground_truth/landmarks  kinect_ekf_slam/LandmarkMap in frame map, once: the world's nine cylinders, ids
                           0..8, at the height at which the scan cuts them
  /tf_static               base_footprint -> base_scan, as in the robot's description, once

It ends with the error of the detections against the truth.
"""
import heapq
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

import numpy as np
from geometry_msgs.msg import PoseStamped, TransformStamped
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from slam_tools import cli
from slam_tools.bags import TRUE_LANDMARKS_TOPIC, TRUE_POSE_TOPIC, BagWriter, open_bag
from slam_tools.environment import executable, package_messages
from slam_tools.geometry import Path, yaw_of_quaternion

# m: base_footprint -> base_link is 0.010 up, base_link -> base_scan 0.064 back and 0.122 up
SCAN_FRAME_IN_BASE = (-0.064, 0.0, 0.132)
CYLINDERS_IN_MAP = [(x, y) for x in (-1.1, 0.0, 1.1) for y in (-1.1, 0.0, 1.1)]
CYLINDER_RADIUS = 0.15
FALSE_DETECTION_DISTANCE = 0.3   # m, from the nearest cylinder


def static_transform(stamp, scan_frame):
    transform = TransformStamped()
    transform.header.stamp = stamp
    transform.header.frame_id = "base_footprint"
    transform.child_frame_id = scan_frame
    translation = transform.transform.translation
    translation.x, translation.y, translation.z = SCAN_FRAME_IN_BASE
    transform.transform.rotation.w = 1.0
    return TFMessage([transform])


def true_landmark_map(stamp, messages):
    message = messages.LandmarkMap()
    message.header.stamp = stamp
    message.header.frame_id = "map"
    for identity, (x, y) in enumerate(CYLINDERS_IN_MAP):
        landmark = messages.Landmark(id=identity, source_id=identity, radius=CYLINDER_RADIUS,
                                     status=messages.Landmark.CONFIRMED)
        landmark.position.x, landmark.position.y, landmark.position.z = x, y, SCAN_FRAME_IN_BASE[2]
        message.landmarks.append(landmark)
    return message


def detect_cylinders(in_path, out_path, radius, range_sigma):
    """Writes what the package's detector finds in the scans."""
    command = [executable("detect_scans"), in_path, "--out", out_path, "--topic", "/scan",
               "--radius", *map(str, radius), "--range-sigma", str(range_sigma)]
    process = subprocess.run(command, stderr=subprocess.PIPE, universal_newlines=True, check=False)
    if process.returncode != 0:
        raise cli.InputError(process.stderr.strip())


def true_pose(odometry):
    header = odometry.header
    return PoseStamped(Header(header.seq, header.stamp, "map"), odometry.pose.pose)


def detection_errors(path, stamped_detections):
    """(errors along the ray and across it, of the radius, squared Mahalanobis distances, number of false ones)."""
    stamps = np.array([stamp for stamp, _ in stamped_detections])
    valid, poses = path.at(stamps, max_gap=0.5)
    yaws = yaw_of_quaternion(poses.quaternions)
    detections = [detection for (_, detection), inside in zip(stamped_detections, valid) if inside]
    errors, radii, distances, false_ones = [], [], [], 0
    for position, yaw, detection in zip(poses.positions, yaws, detections):
        rotation = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        in_base = (np.array(CYLINDERS_IN_MAP) - position[:2]) @ rotation
        center = np.array([detection.position.x, detection.position.y])
        error = center - (in_base - SCAN_FRAME_IN_BASE[:2])
        error = error[np.argmin(np.linalg.norm(error, axis=1))]
        if np.linalg.norm(error) > FALSE_DETECTION_DISTANCE:
            false_ones += 1
            continue
        ray = center / np.linalg.norm(center)
        errors.append((error @ ray, ray[0] * error[1] - ray[1] * error[0]))
        radii.append(detection.radius - CYLINDER_RADIUS)
        covariance = np.reshape(detection.covariance, (3, 3))[:2, :2]
        distances.append(error @ np.linalg.solve(covariance, error))
    return np.array(errors).reshape(-1, 2), np.array(radii), np.array(distances), false_ones


def check_topics(in_path, topics):
    for topic, type_name in (("/odom", "nav_msgs/Odometry"), ("/scan", "sensor_msgs/LaserScan")):
        if topic not in topics or topics[topic].msg_type != type_name:
            raise cli.InputError(f"{in_path}: holds no {topic} of type {type_name}; "
                                 "a bag of a TurtleBot3 in turtlebot3_world is needed")


def convert(in_path, out_path, radius, range_sigma):
    messages = package_messages()
    poses, stamped_detections = [], []
    with open_bag(in_path) as bag, tempfile.TemporaryDirectory() as folder:
        topics = bag.get_type_and_topic_info().topics
        check_topics(in_path, topics)
        found_path = os.path.join(folder, "landmarks.bag")
        detect_cylinders(in_path, found_path, radius, range_sigma)
        total = sum(topics[topic].message_count for topic in ("/odom", "/imu", "/scan") if topic in topics)
        scan_frame = next(bag.read_messages("/scan")).message.header.frame_id
        with open_bag(found_path) as found, BagWriter(out_path) as out:
            in_order = heapq.merge(bag.read_messages(["/odom", "/imu"]), found.read_messages(),
                                   key=lambda entry: entry.timestamp)
            for topic, message, receipt_time in cli.progress(in_order, total, "Converting"):
                if not out.counts:
                    out.write("/tf_static", static_transform(receipt_time, scan_frame), receipt_time,
                              latched=True)
                    out.write(TRUE_LANDMARKS_TOPIC, true_landmark_map(receipt_time, messages), receipt_time,
                              latched=True)
                out.write(topic, message, receipt_time)
                if topic == "/landmarks":
                    stamped_detections += [(message.header.stamp.to_sec(), detection)
                                           for detection in message.detections]
                if topic == "/odom":
                    pose = true_pose(message)
                    out.write(TRUE_POSE_TOPIC, pose, receipt_time)
                    p, q = pose.pose.position, pose.pose.orientation
                    poses.append((pose.header.stamp.to_sec(), p.x, p.y, p.z, q.x, q.y, q.z, q.w))
    for topic, count in sorted(out.counts.items()):
        print(f"{topic:24s} {count:6d} messages")
    poses = np.array(poses)
    report(*detection_errors(Path.in_time_order(poses[:, 0], poses[:, 1:4], poses[:, 4:]), stamped_detections))


def report(errors, radii, distances, false_ones):
    if not len(errors):
        print(f"no cylinder was detected; {false_ones} false detections")
        return
    bias, std = 1e3 * errors.mean(axis=0), 1e3 * errors.std(axis=0)
    print(f"{len(errors)} detections of cylinders, {false_ones} false ones; error along the ray "
          f"{bias[0]:.1f} +- {std[0]:.1f} mm, across it {bias[1]:.1f} +- {std[1]:.1f} mm, "
          f"of the radius {1e3 * radii.mean():.1f} +- {1e3 * radii.std():.1f} mm; "
          f"mean squared Mahalanobis distance {distances.mean():.2f} (2 expected)")


def main():
    parser = cli.ArgumentParser(description=__doc__)
    parser.add_argument("in_bag", metavar="IN.bag", help="bag with /odom, /imu and /scan")
    parser.add_argument("out_bag", metavar="OUT.bag", help="bag to write; one that exists is replaced")
    parser.add_argument("--radius", nargs=2, type=float, metavar=("MIN", "MAX"),
                        default=(0.10, 0.20),
                        help="bounds of the cylinders' radius in m (default: %(default)s)")
    parser.add_argument("--range-std", type=float, metavar="M", default=0.01,
                        help="standard deviation of the scanner's ranges in m (default: %(default)s)")
    arguments = parser.parse_args()
    if not 0.0 < arguments.radius[0] < arguments.radius[1]:
        parser.error(f"--radius is {arguments.radius[0]} {arguments.radius[1]}; 0 < MIN < MAX is needed")
    if not arguments.range_std > 0.0:
        parser.error(f"--range-std is {arguments.range_std}; a positive number is needed")
    if os.path.realpath(arguments.in_bag) == os.path.realpath(arguments.out_bag):
        parser.error("OUT.bag is IN.bag; another name is needed")
    convert(arguments.in_bag, arguments.out_bag, arguments.radius, arguments.range_std)


if __name__ == "__main__":
    cli.run(main)
