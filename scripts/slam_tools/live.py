"""A run of slam_node as it is published, written as slam_replay writes one."""
import csv
import json
import math
import os
import threading
import time
from collections import Counter

import rospy
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from kinect_ekf_slam.cfg import SlamConfig
from kinect_ekf_slam.msg import AssociationArray, LandmarkMap
from nav_msgs.msg import Odometry

from .cli import InputError, atomic_output
from .environment import package_version
from .runs import ASSOCIATION_COLUMNS, COVARIANCE_COLUMNS, LANDMARK_COLUMNS

TIME_JUMP = 1.0    # s back that make a new run, as sync/time_jump of slam_node
QUEUE = 1000       # messages
REFUSED = "refused, "   # begins the names of counts in the diagnostics

UPPER_3 = [3 * i + j for i in range(3) for j in range(i, 3)]
UPPER_6 = [6 * i + j for i in range(6) for j in range(i, 6)]


def seconds(stamp):
    return f"{stamp.secs}.{stamp.nsecs:09d}"


def number(value):
    return "nan" if math.isnan(value) else f"{value:.9g}"


def pose_line(stamp, pose):
    values = (pose.position.x, pose.position.y, pose.position.z,
              pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w)
    return " ".join([seconds(stamp)] + [number(value) for value in values]) + "\n"


def hears(subscriber):
    """Whether a publisher's messages reach a rospy.Subscriber; connections count before their handshake, when they do not."""
    return any(connection.header for connection in subscriber.impl.connections)


def parameters_in_use(node):
    """The groups of a node's parameters, with what was changed while it ran; {} where the server has none."""
    given = rospy.get_param(node, {})
    live = given.pop("live", {})
    given.pop("diagnostic_period", None)
    for name, default in SlamConfig.defaults.items():
        group, _, key = name.partition("_")
        if name in live and (key in given.get(group, {}) or live[name] != default):
            given.setdefault(group, {})[key] = live[name]
    return given


class LiveRun:
    """Subscribes at once; `write` may be called at any time."""

    def __init__(self, node, odometry_topic):
        self._lock = threading.Lock()
        self._node = node
        self._wall_start = None
        self._poses = []           # messages, stamps ascending
        self._odometry = []
        self._associations = []
        self._map = None
        self._warnings = []        # of the node's diagnostics, each once
        self._refused = {}         # {reason: messages}
        self._subscribers = [
            rospy.Subscriber(topic, message_type, handler, queue_size=QUEUE)
            for topic, message_type, handler in (
                (f"{node}/pose", PoseWithCovarianceStamped, lambda m: self._add(self._poses, m)),
                (f"{node}/associations", AssociationArray, lambda m: self._add(self._associations, m)),
                (odometry_topic, Odometry, lambda m: self._add(self._odometry, m)),
                ("/diagnostics", DiagnosticArray, self._on_diagnostics),
                (f"{node}/map", LandmarkMap, self._on_map))]

    def is_connected(self):
        """Whether all topics have a publisher that is heard."""
        return all(hears(subscriber) for subscriber in self._subscribers)

    def close(self):
        for subscriber in self._subscribers:
            subscriber.unregister()

    def _on_map(self, message):
        with self._lock:
            self._map = message

    def _on_diagnostics(self, message):
        with self._lock:
            for status in message.status:
                if not status.name.startswith(self._node.lstrip("/") + ":"):
                    continue
                if status.level != DiagnosticStatus.OK and status.message not in self._warnings:
                    self._warnings.append(status.message)
                self._refused.update({item.key[len(REFUSED):]: int(item.value) for item in status.values
                                      if item.key.startswith(REFUSED)})

    def _add(self, messages, message):
        with self._lock:
            if messages and message.header.stamp <= messages[-1].header.stamp:
                if (messages[-1].header.stamp - message.header.stamp).to_sec() <= TIME_JUMP:
                    return         # repeated or late
                messages.clear()
            if self._wall_start is None:
                self._wall_start = time.monotonic()
            messages.append(message)

    def _data_seconds(self):
        return (self._poses[-1].header.stamp - self._poses[0].header.stamp).to_sec() if self._poses else 0.0

    def progress(self):
        """A line that says how far the run is."""
        with self._lock:
            landmarks = len(self._map.landmarks) if self._map else 0
            return f"  {self._data_seconds():4.0f} s of data, {landmarks} landmarks"

    def write(self, folder):
        """Writes all files; raises InputError when the node has said nothing."""
        with self._lock:
            if not self._poses or self._map is None:
                raise InputError(f"{self._node}/pose, {self._node}/map: nothing came; is the node running?")
            for name, write in (("trajectory.tum", self._write_trajectory),
                                ("trajectory_covariance.csv", self._write_covariances),
                                ("dead_reckoning.tum", self._write_dead_reckoning),
                                ("landmarks.csv", self._write_landmarks),
                                ("associations.csv", self._write_associations),
                                ("parameters.yaml", self._write_parameters),
                                ("summary.json", self._write_summary)):
                with atomic_output(os.path.join(folder, name)) as path:
                    with open(path, "w", encoding="utf-8", newline="") as file:
                        write(file)

    def _write_trajectory(self, file):
        for message in self._poses:
            file.write(pose_line(message.header.stamp, message.pose.pose))

    def _write_covariances(self, file):
        file.write(",".join(COVARIANCE_COLUMNS) + "\n")
        for message in self._poses:
            values = [number(message.pose.covariance[index]) for index in UPPER_6]
            file.write(",".join([seconds(message.header.stamp)] + values) + "\n")

    def _write_dead_reckoning(self, file):
        for message in self._odometry:
            file.write(pose_line(message.header.stamp, message.pose.pose))

    def _write_landmarks(self, file):
        table = csv.writer(file, lineterminator="\n")
        table.writerow(LANDMARK_COLUMNS)
        for landmark in self._map.landmarks:
            position = landmark.position
            values = (position.x, position.y, position.z, *(landmark.covariance[index] for index in UPPER_3))
            table.writerow([landmark.id, landmark.label, *map(number, values), landmark.observations])

    def _write_associations(self, file):
        table = csv.writer(file, lineterminator="\n")
        table.writerow(ASSOCIATION_COLUMNS)
        for message in self._associations:
            for item in message.associations:
                table.writerow([seconds(message.header.stamp), item.detection, item.source_id, item.verdict,
                                item.landmark, "" if math.isnan(item.nis) else f"{item.nis:.6g}"])

    def _write_parameters(self, file):
        file.write("# what was given; all else as built in\n")
        yaml.safe_dump(parameters_in_use(self._node), file)

    def _write_summary(self, file):
        verdicts = Counter(item.verdict for message in self._associations for item in message.associations)
        json.dump({"node": self._node,
                   "finished": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
                   "versions": {"kinect_ekf_slam": package_version()},
                   "warnings": self._warnings,
                   "messages_refused": self._refused,
                   "wall_seconds": round(time.monotonic() - self._wall_start, 3),
                   "data_seconds": self._data_seconds(),
                   "poses": len(self._poses),
                   "detection_frames": len(self._associations),
                   "detections": dict(sorted(verdicts.items())),
                   "landmarks": len(self._map.landmarks)}, file, indent=2)
        file.write("\n")
