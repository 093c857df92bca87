"""What the scripts share that turn the text files of a recorded dataset into a bag."""
import os

import numpy as np
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry

from .bags import TRUE_POSE_TOPIC, fill_pose, time_from_nanoseconds
from .cli import InputError
from .geometry import quaternion_from_yaw
from .tables import read_numbers

# Standard deviations of the integrated pose per distance and per angle travelled. The robot drives on a floor:
# what moves out of the plane is small.
START_STD, DRIFT, OUT_OF_PLANE_STD = 0.01, 0.05, 0.001   # m or rad, -, and m, rad, m/s or rad/s


LARGEST = 4e9         # what a bag's stamps can hold in seconds, and more than any number of a dataset
LONGEST_GAP = 86400   # s
LARGEST_IDENTITY = 2**31 - 1   # in a message


def read_rows(folder, name, columns, ordered_by_time=True):
    """The numbers of one of the dataset's files; a file without any is an error."""
    path = os.path.join(folder, name)
    rows = read_numbers(path, columns, ordered_by_time=ordered_by_time)
    if not len(rows):
        raise InputError(f"{path}: holds no rows; rows of {' '.join(columns)} are needed")
    too_large = np.abs(rows).max(axis=1) > LARGEST
    if too_large.any():
        raise InputError(f"{path}: row {int(too_large.argmax()) + 1} of numbers: beyond {LARGEST:.0f} in size")
    if columns[0] == "time" and ordered_by_time and len(rows) > 1 and np.diff(rows[:, 0]).max() > LONGEST_GAP:
        start = rows[np.diff(rows[:, 0]).argmax(), 0]
        raise InputError(f"{path}: nothing for more than a day after time {start:.3f}; is the next time right?")
    return rows


def whole_numbers(folder, name, column, values):
    """A column of one of the dataset's files as the whole numbers that a message can hold."""
    bad = (values != np.rint(values)) | (np.abs(values) > LARGEST_IDENTITY)
    if bad.any():
        row = int(bad.argmax())
        raise InputError(f"{os.path.join(folder, name)}: row {row + 1} of numbers: {column} is {values[row]:.10g}; "
                         f"a whole number of at most {LARGEST_IDENTITY} in size is needed")
    return values.astype(int)


def nanoseconds(seconds):
    """Stamps as whole nanoseconds; the files' resolution is a millisecond."""
    return np.rint(np.asarray(seconds) * 1e6).astype(np.int64) * 1000


def keep_last_of_repeated_stamps(table):
    return table[np.append(np.diff(table[:, 0]) > 0.0, True)[:len(table)]]


def odometry_messages(stamps, poses, twists, twist_stds, base_frame):
    """(receipt time in ns, topic, message) of odometry in frame odom.

    stamps: ns, n; poses: x, y, yaw in odom, n x 3; twists: the same components' rates in the base frame, n x 3,
    each held until the next; twist_stds: their standard deviations, 3.
    """
    durations = np.diff(stamps) * 1e-9
    quaternions = quaternion_from_yaw(poses[:, 2])
    distance = np.append(0.0, np.cumsum(np.hypot(twists[:-1, 0], twists[:-1, 1]) * durations))
    angle = np.append(0.0, np.cumsum(np.abs(twists[:-1, 2]) * durations))
    position_variance = START_STD**2 + (DRIFT * distance)**2
    yaw_variance = START_STD**2 + (DRIFT * angle)**2
    twist_covariance = [0.0] * 36
    twist_covariance[::7] = [twist_stds[0]**2, twist_stds[1]**2] + 3 * [OUT_OF_PLANE_STD**2] + [twist_stds[2]**2]

    for i, stamp in enumerate(stamps):
        message = Odometry()
        message.header.seq = i
        message.header.stamp = time_from_nanoseconds(stamp)
        message.header.frame_id = "odom"
        message.child_frame_id = base_frame
        fill_pose(message.pose.pose, (poses[i, 0], poses[i, 1], 0.0), quaternions[i])
        message.pose.covariance[::7] = [position_variance[i], position_variance[i], OUT_OF_PLANE_STD**2,
                                        OUT_OF_PLANE_STD**2, OUT_OF_PLANE_STD**2, yaw_variance[i]]
        message.twist.twist.linear.x, message.twist.twist.linear.y = twists[i, 0], twists[i, 1]
        message.twist.twist.angular.z = twists[i, 2]
        message.twist.covariance = twist_covariance
        yield int(stamp), "/odom", message


def true_pose_messages(stamps, positions, quaternions):
    """(receipt time in ns, topic, message) of the true path in frame map.

    stamps: ns, n; positions: x, y, n x 2; quaternions: n x 4; all zero where the truth is positions only.
    """
    for i, stamp in enumerate(stamps):
        message = PoseStamped()
        message.header.seq = i
        message.header.stamp = time_from_nanoseconds(stamp)
        message.header.frame_id = "map"
        fill_pose(message.pose, (positions[i, 0], positions[i, 1], 0.0), quaternions[i])
        yield int(stamp), TRUE_POSE_TOPIC, message
