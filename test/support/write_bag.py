#!/usr/bin/python3
"""Writes a bag of a robot that drives among landmarks: odometry, IMU, detections and the sensors' mountings."""
import argparse

import rosbag
from tf2_msgs.msg import TFMessage

import scenario

START = 1600000000 * scenario.SECOND
REST = 10  # steps at the beginning and at the end: nothing is lost while a player and its listeners find each other


def write_bag(path, seconds, seed=1):
    """Returns the number of detection messages."""
    run = scenario.Scenario(START, speed=0.0, turn=0.0, with_imu=True, seed=seed)
    steps = int(seconds * scenario.SECOND / scenario.PERIOD)
    sights = 0
    with rosbag.Bag(path, "w") as bag:
        bag.write("/tf_static", TFMessage(scenario.mountings()), scenario.to_ros(START - scenario.PERIOD))
        for i in range(steps):
            # A slow circle; the robot stands at both ends.
            moves = REST <= i < steps - REST
            run.speed, run.turn = (0.15, 0.3) if moves else (0.0, 0.0)
            step = run.step()
            at = scenario.to_ros(step.stamp)
            bag.write("/odom", step.odometry, at)
            bag.write("/imu", step.imu, at)
            if step.detections and REST // 2 <= i < steps - REST // 2:
                bag.write("/landmarks", step.detections, at)
                sights += 1
    return sights


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bag")
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    sights = write_bag(arguments.bag, arguments.seconds, arguments.seed)
    print("%s: %d detection messages" % (arguments.bag, sights))


if __name__ == "__main__":
    main()
