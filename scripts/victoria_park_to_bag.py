#!/usr/bin/python3
"""Turns the Victoria Park dataset into a bag for slam_replay and slam_node.

The dataset (E. Nebot, ACFR, University of Sydney; a truck with a laser in a park, 25 minutes) is a folder with
the text files inputs.dat (time, speed, steering), measurements.dat (time, range, bearing, diameter: trees) and
gps.dat (time, x, y; optional). The base frame is the laser. The bag holds

  /odom               nav_msgs/Odometry in frame odom, child laser. The encoder sits on the rear left wheel, so
                      the rear axle's middle drives at v = speed / (1 - tan(steering) H / L) and turns at
                      w = v tan(steering) / L. The laser, a ahead of the axle and b to its left, then has
                      linear.x = v - w b and linear.y = w a. The pose is integrated along exact arcs, from
                      where the laser starts. L = 2.83 m, H = 0.76 m, a = 3.78 m, b = 0.50 m.
  /landmarks          kinect_ekf_slam/LandmarkDetectionArray in frame laser, one for each time of the file. The
                      file's bearing counts from the right, so that pi / 2 is ahead. radius is half the
                      diameter, id -1. Covariance zero: the sensor model of the parameters counts.
  /ground_truth/pose  geometry_msgs/PoseStamped in frame map: the GPS. It knows no heading: the quaternion is
                      zero, and evaluate.py then compares positions only. It has gaps and is now and then many
                      metres off: evaluate.py --align robust.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

import heapq

import numpy as np

from slam_tools import cli
from slam_tools.bags import TRUE_POSE_TOPIC, BagWriter, time_from_nanoseconds
from slam_tools.environment import package_messages
from slam_tools.geometry import integrate_arcs
from slam_tools.recordings import (keep_last_of_repeated_stamps, nanoseconds, odometry_messages, read_rows,
                                   true_pose_messages)

WHEEL_BASE, HALF_TRACK = 2.83, 0.76    # m
LASER_IN_AXLE = (3.78, 0.50)           # m: ahead of the rear axle's middle, and to its left
STEERING_MAX = np.pi / 3               # rad; no truck's wheels turn further
TWIST_STDS = (0.2, 0.2, 0.05)          # m/s, m/s, rad/s: the wheels slip on grass


def axle_velocity(rows):
    """(m/s forward, rad/s) of the rear axle's middle, for rows of time, speed of the left wheel, steering."""
    curvature = np.tan(rows[:, 2]) / WHEEL_BASE
    speeds = rows[:, 1] / (1.0 - curvature * HALF_TRACK)
    return speeds, speeds * curvature


def laser_poses(axle_poses):
    """x, y, yaw of the laser from where it starts, for those of the axle from where that starts."""
    a, b = LASER_IN_AXLE
    x, y, yaw = axle_poses.T
    return np.column_stack([x + a * np.cos(yaw) - b * np.sin(yaw) - a,
                            y + a * np.sin(yaw) + b * np.cos(yaw) - b, yaw])


def odometry(rows):
    """(receipt time in ns, topic, message) for rows of time, speed, steering."""
    stamps = nanoseconds(rows[:, 0])
    speeds, turn_rates = axle_velocity(rows)
    poses = laser_poses(integrate_arcs(np.diff(stamps) * 1e-9, speeds[:-1], turn_rates[:-1]))
    a, b = LASER_IN_AXLE
    twists = np.column_stack([speeds - turn_rates * b, turn_rates * a, turn_rates])
    return odometry_messages(stamps, poses, twists, TWIST_STDS, "laser")


def detection_messages(rows, messages):
    """(receipt time in ns, topic, message) for rows of time, range, bearing, diameter."""
    stamps = nanoseconds(rows[:, 0])
    x = rows[:, 1] * np.sin(rows[:, 2])
    y = -rows[:, 1] * np.cos(rows[:, 2])
    scans, firsts = np.unique(stamps, return_index=True)
    for scan, (stamp, first, end) in enumerate(zip(scans, firsts, np.append(firsts[1:], len(rows)))):
        message = messages.LandmarkDetectionArray()
        message.header.seq = scan
        message.header.stamp = time_from_nanoseconds(stamp)
        message.header.frame_id = "laser"
        for i in range(first, end):
            detection = messages.LandmarkDetection(id=-1, radius=0.5 * rows[i, 3], score=1.0)
            detection.position.x, detection.position.y = x[i], y[i]
            message.detections.append(detection)
        yield int(stamp), "/landmarks", message


def require(path, rows, good, what):
    if not good.all():
        row = int(np.argmin(good))
        raise cli.InputError(f"{path}: row at time {rows[row, 0]:.3f}: {what}")


def convert(folder, bag_path):
    messages = package_messages()
    if not os.path.isdir(folder):
        raise cli.InputError(f"{folder}: no such folder; one with inputs.dat and measurements.dat is needed")
    inputs = read_rows(folder, "inputs.dat", ("time", "speed", "steering"))
    measurements = read_rows(folder, "measurements.dat", ("time", "range", "bearing", "diameter"))
    gps = np.empty((0, 3))
    if os.path.exists(os.path.join(folder, "gps.dat")):
        gps = read_rows(folder, "gps.dat", ("time", "x", "y"))
    require(os.path.join(folder, "inputs.dat"), inputs, np.abs(inputs[:, 2]) < STEERING_MAX,
            f"the steering is not between -{STEERING_MAX:.3f} and {STEERING_MAX:.3f} rad")
    require(os.path.join(folder, "measurements.dat"), measurements,
            (measurements[:, 1] > 0.0) & (measurements[:, 3] >= 0.0), "range or diameter is negative")
    for name, table in (("inputs.dat", inputs), ("measurements.dat", measurements), ("gps.dat", gps)):
        require(os.path.join(folder, name), table, table[:, 0] >= 0.0, "the time is negative")

    rows = len(inputs)
    inputs = keep_last_of_repeated_stamps(inputs)
    streams = heapq.merge(odometry(inputs), detection_messages(measurements, messages),
                          true_pose_messages(nanoseconds(gps[:, 0]), gps[:, 1:], np.zeros((len(gps), 4))),
                          key=lambda item: item[0])
    with BagWriter(bag_path) as bag:
        about = len(inputs) + len(np.unique(measurements[:, 0])) + len(gps)
        for stamp, topic, message in cli.progress(streams, about, "Writing"):
            bag.write(topic, message, time_from_nanoseconds(stamp))

    poses = bag.counts.get(TRUE_POSE_TOPIC, 0)
    print(f"/odom               {bag.counts['/odom']:6d} messages; {rows - len(inputs)} rows with a repeated "
          "stamp left out")
    print(f"/landmarks          {bag.counts['/landmarks']:6d} messages: {len(measurements)} detections")
    print(f"{TRUE_POSE_TOPIC}  {poses:6d} messages{'' if poses else ': the dataset has no gps.dat'}")


def main():
    parser = cli.ArgumentParser(description=__doc__)
    parser.add_argument("folder", metavar="FOLDER", help="folder of the dataset")
    parser.add_argument("bag", metavar="OUT.bag", help="bag to write; one that exists is replaced")
    arguments = parser.parse_args()
    convert(arguments.folder, arguments.bag)


if __name__ == "__main__":
    cli.run(main)
