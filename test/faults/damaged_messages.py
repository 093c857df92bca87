"""Damaged messages: to the pipeline and to perception in one process, and to slam_node over ROS."""
import math
import random
import time

from genpy import Message

import scenario
from programs import build_folder, fuzz
from row import Row, number
from slam_run import SlamRun
from spoiled import spoiled
from waiting import soon

TOPICS = ("odom", "imu", "landmarks", "initialpose")
BATCH = 5  # messages an input between two sound steps: fewer than any queue holds
MOST_STEPS = 200  # of sound data until the node takes them for the run again
START = int(time.time() - 1e6) * scenario.SECOND  # the data come faster than real time
OVERRIDES = {"frames/tf_timeout": 0.01, "estimator/max_landmarks": 60, "sync/queue_size": 1000, "output/marker_rate": 5.0}


def pipeline(quick):
    return fuzz("damaged `odom`, `imu` and `landmarks` messages into the pipeline, with each way to associate", "{} of each, 4 times",
                "the estimate is finite, what is refused is counted",
                "fuzz_slam", "FuzzSlam.DamagedMessagesLeave*", 300 if quick else 10000, build_folder("address", quick))


def perception(quick):
    return fuzz("damaged pictures into each of three detectors, damaged scans into the fourth", "{} of each",
                "refused with a reason, or what is found is finite", "fuzz_perception", "*", 100 if quick else 10000,
                build_folder("address", quick))


def is_finite(value):
    """Of all numbers in a message."""
    if isinstance(value, Message):
        return all(is_finite(getattr(value, slot)) for slot in value.__slots__)
    if isinstance(value, (list, tuple)):
        return all(is_finite(item) for item in value)
    return not isinstance(value, float) or math.isfinite(value)


def goes_on(run):
    """Sound data until a pose of the newest comes, as a jump of the stamps takes some to be believed: how many steps; 0: it never comes."""
    for steps in range(1, MOST_STEPS + 1):
        step = run.scenario.step()
        for topic, message in (("landmarks", step.detections), ("imu", step.imu), ("odom", step.odometry)):
            if message:
                run.publish(topic, message)
        if soon(lambda stamp=step.stamp: run.pose_stamp() == stamp, 0.05):
            return steps
        if not run.process.is_running():
            return 0
    return 0


def _send_spoiled(run, count, choice):
    """Returns how many messages an input were sent while the node was well."""
    sent = 0
    while sent < count:
        if not goes_on(run):
            break
        step = run.scenario.step()
        for _ in range(BATCH):
            for topic in TOPICS:
                step.made_detections = run.scenario.detections()
                run.publish(topic, spoiled(topic, step, choice))
        sent += BATCH
    return sent


def node(quick):
    count = 1000 if quick else 10000
    with SlamRun(OVERRIDES, with_imu=True, start=START) as run:
        sent = _send_spoiled(run, count, random.Random(5))
        alive = run.process.is_running() and goes_on(run) > 0
        outputs = (run.pose, run.odometry, run.map, run.tf)
        finite = all(is_finite(message) for output in outputs for message in output.messages)
        refused = int(run.diagnostics("inputs").get("refused", 0))
    result = (f"{number(sent)} sent, {'alive' if alive else 'NOT alive'}, output {'finite' if finite else 'NOT finite'}, "
              f"{number(refused)} messages refused and counted")
    return Row("damaged `odom`, `imu`, `landmarks` and `initialpose` messages to `slam_node`", f"{number(count)} of each",
               "the node lives and goes on with sound data, its output is finite, refusals are in `/diagnostics`", result,
               sent >= count and alive and finite and refused > count // 10)
