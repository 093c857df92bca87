"""Reading and writing bags."""
import contextlib
import os
import struct
from dataclasses import dataclass
from typing import List

import genpy
import numpy as np
import rosbag

from .cli import InputError, atomic_output
from .geometry import Path, enu_from_geodetic
from .tables import LARGEST

TRUE_POSE_TOPIC = "/ground_truth/pose"
TRUE_LANDMARKS_TOPIC = "/ground_truth/landmarks"


@dataclass(frozen=True)
class Landmarks:
    """Landmarks of a map. identities: what a detector reads, -1 unknown; covariances in m^2."""
    ids: np.ndarray
    identities: np.ndarray
    labels: List[str]
    positions: np.ndarray
    covariances: np.ndarray
    observations: np.ndarray

    def __len__(self):
        return len(self.ids)


@contextlib.contextmanager
def open_bag(path):
    """An open bag; what makes it unreadable becomes one line."""
    try:
        with rosbag.Bag(path) as bag:
            yield bag
    except rosbag.ROSBagUnindexedException:
        raise InputError(f"{path}: the bag was not closed; 'rosbag reindex' repairs it") from None
    except (rosbag.ROSBagException, genpy.MessageException,
            struct.error, KeyError, UnicodeDecodeError) as error:   # the latter: rosbag on damaged records
        reason = " ".join(f"{type(error).__name__} {error}".split())
        raise InputError(f"{path}: not a readable bag ({reason})") from None


def topics_of_type(bag, type_name):
    """Names of the topics that hold messages of the type, in order of the names."""
    topics = bag.get_type_and_topic_info().topics
    return sorted(name for name, topic in topics.items() if topic.msg_type == type_name)


def read_true_path(path, bag):
    """The true path in the bag, or None: from TRUE_POSE_TOPIC, else positions from the first NavSatFix topic.

    Poses whose quaternion is zero have no orientation: such a path is positions only, as that of a GPS is.
    """
    poses = [(message.header.stamp.to_sec(), p.x, p.y, p.z, q.x, q.y, q.z, q.w)
             for _, message, _ in bag.read_messages(TRUE_POSE_TOPIC)
             for p, q in [(message.pose.position, message.pose.orientation)]]
    if poses:
        poses = np.array(poses)
        _require_usable(path, TRUE_POSE_TOPIC, poses)
        norms = np.linalg.norm(poses[:, 4:], axis=1, keepdims=True)
        quaternions = poses[:, 4:] / norms if (norms > 0.5).all() else None
        return Path.in_time_order(poses[:, 0], poses[:, 1:4], quaternions)
    for topic in topics_of_type(bag, "sensor_msgs/NavSatFix"):
        fixes = np.array([(fix.header.stamp.to_sec(), fix.latitude, fix.longitude, fix.altitude)
                          for _, fix, _ in bag.read_messages(topic) if fix.status.status >= 0])
        if len(fixes):
            fixes[:, 3] = np.nan_to_num(fixes[:, 3])   # a receiver without altitude says NaN
            _require_usable(path, topic, fixes)
            return Path.in_time_order(fixes[:, 0], enu_from_geodetic(*fixes[:, 1:].T), None)
    return None


def read_true_landmarks(path, bag):
    """The last map on TRUE_LANDMARKS_TOPIC, or None. A landmark without source_id is identified by its id."""
    message = None
    for _, message, _ in bag.read_messages(TRUE_LANDMARKS_TOPIC):
        pass
    if message is None:
        return None
    landmarks = message.landmarks
    positions = np.array([[l.position.x, l.position.y, l.position.z] for l in landmarks]).reshape(-1, 3)
    _require_usable(path, TRUE_LANDMARKS_TOPIC, positions)
    return Landmarks(
        ids=np.array([l.id for l in landmarks], dtype=int),
        identities=np.array([l.source_id if l.source_id >= 0 else l.id for l in landmarks], dtype=int),
        labels=[l.label for l in landmarks],
        positions=positions,
        covariances=np.array([l.covariance for l in landmarks]).reshape(-1, 3, 3),
        observations=np.array([l.observations for l in landmarks], dtype=int))


def _require_usable(path, topic, rows):
    for wrong, what in ((~np.isfinite(rows), "is not finite; finite numbers are needed"),
                        (np.abs(rows) > LARGEST, f"has a number beyond {LARGEST:g} in size; metres are needed")):
        bad = wrong.any(axis=1)
        if bad.any():
            raise InputError(f"{path}: entry {int(np.argmax(bad)) + 1} of {topic} {what}")


class BagWriter:
    """Writes messages and counts them per topic; a context manager that leaves no half-written file."""

    def __init__(self, path):
        self.path = path
        self.counts = {}

    def __enter__(self):
        if os.path.isfile(self.path):
            with open(self.path, "rb") as file:
                if file.read(7) not in (b"#ROSBAG", b""):
                    raise InputError(f"{self.path}: exists and is no bag, so it is not replaced; name another file")
        self._stack = contextlib.ExitStack()
        temporary_path = self._stack.enter_context(atomic_output(self.path))
        self._bag = self._stack.enter_context(rosbag.Bag(temporary_path, "w"))
        return self

    def __exit__(self, *exception):
        return self._stack.__exit__(*exception)

    def write(self, topic, message, receipt_time, latched=False):
        header = None
        if latched:   # players then latch it as well
            header = {"topic": topic, "type": message._type, "md5sum": message._md5sum,
                      "message_definition": message._full_text, "latching": "1"}
        self._bag.write(topic, message, receipt_time, connection_header=header)
        self.counts[topic] = self.counts.get(topic, 0) + 1


def time_from_nanoseconds(nanoseconds):
    seconds, rest = divmod(int(nanoseconds), 10**9)
    return genpy.Time(seconds, rest)


def fill_pose(pose, position, quaternion):
    """Sets a geometry_msgs/Pose."""
    pose.position.x, pose.position.y, pose.position.z = position
    pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w = quaternion
    return pose
