#!/usr/bin/python3
"""Turns one robot of a UTIAS MRCLAM dataset into a bag for slam_replay and slam_node.

The dataset (Leung et al., "The UTIAS multi-robot cooperative localization and mapping dataset", IJRR 30(8),
2011) is a folder with RobotN_Odometry.dat, RobotN_Measurement.dat, RobotN_Groundtruth.dat (optional),
Barcodes.dat and Landmark_Groundtruth.dat. The bag holds

  /odom                    nav_msgs/Odometry in frame odom, child base_footprint. Velocities as recorded, the
                           pose integrated along exact arcs. A row holds until the next one: gaps longer than
                           0.05 s are filled with repeated samples every 0.05 s. Of rows with the same stamp
                           the last one counts.
  /landmarks               kinect_ekf_slam/LandmarkDetectionArray in frame base_footprint. Rows less than 0.02
                           s after the first one of a group are one array. id is the subject number of the
                           barcode (6..20), -1 where no subject has the barcode. Sightings of robots (subjects
                           1..5) are left out; an array of nothing else stays, empty. Covariance zero: the
                           sensor model of the parameters counts.
  /ground_truth/pose       geometry_msgs/PoseStamped in frame map, when the dataset has it (about 100 Hz)
  /ground_truth/landmarks  kinect_ekf_slam/LandmarkMap in frame map, once at the start

--wrong-identities gives a share of the landmarks' detections the identity of another landmark, to see what
misread barcodes do. All else stays, so that the bag made without it tells which detections they are.
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
from slam_tools.bags import TRUE_LANDMARKS_TOPIC, TRUE_POSE_TOPIC, BagWriter, time_from_nanoseconds
from slam_tools.environment import package_messages
from slam_tools.geometry import integrate_arcs, quaternion_from_yaw
from slam_tools.recordings import (OUT_OF_PLANE_STD, keep_last_of_repeated_stamps, nanoseconds,
                                   odometry_messages, read_rows, true_pose_messages, whole_numbers)

ROBOT_SUBJECTS = range(1, 6)
LONGEST_GAP = 50_000_000      # ns, between odometry samples
GROUP_DURATION = 20_000_000   # ns, of the measurement rows of one array

SPEED_STD, TURN_RATE_STD = 0.02, 0.1   # m/s, rad/s: standard deviations of the recorded velocities


def fill_gaps(stamps, speeds, turn_rates):
    """Repeats a row every LONGEST_GAP until the next row comes."""
    samples = np.ones(len(stamps), dtype=np.int64)
    samples[:-1] = np.maximum(-(-np.diff(stamps) // LONGEST_GAP), 1)   # rounded up
    row = np.repeat(np.arange(len(stamps)), samples)
    position_in_row = np.arange(len(row)) - np.repeat(np.cumsum(samples) - samples, samples)
    return stamps[row] + position_in_row * LONGEST_GAP, speeds[row], turn_rates[row]


def odometry(rows):
    """(receipt time in ns, topic, message) for rows of time, speed, turn rate."""
    stamps, speeds, turn_rates = fill_gaps(nanoseconds(rows[:, 0]), rows[:, 1], rows[:, 2])
    poses = integrate_arcs(np.diff(stamps) * 1e-9, speeds[:-1], turn_rates[:-1])
    twists = np.column_stack([speeds, np.zeros(len(speeds)), turn_rates])
    return odometry_messages(stamps, poses, twists, (SPEED_STD, OUT_OF_PLANE_STD, TURN_RATE_STD),
                             "base_footprint")


def group_starts(stamps):
    """Index of the first row of every group, and the number of rows at the end."""
    starts = []
    for i, stamp in enumerate(stamps):
        if not starts or stamp - stamps[starts[-1]] >= GROUP_DURATION:
            starts.append(i)
    return starts + [len(stamps)]


def misread(subjects, landmarks, share, seed):
    """The subjects as read when a share of the landmarks' barcodes is taken for that of another landmark.

    subjects: n; landmarks: subject numbers that are landmarks; of the sightings of those, a share of exactly
    `share`, rounded to whole sightings, gets one of the other landmarks, each with the same probability.
    """
    random = np.random.default_rng(seed)
    landmarks = np.unique(landmarks)
    sightings = np.flatnonzero(np.isin(subjects, landmarks))
    wrong = random.choice(sightings, size=round(share * len(sightings)), replace=False)
    others = random.integers(1, len(landmarks), size=len(wrong))   # how far on in the list, never back at itself
    read = subjects.copy()
    read[wrong] = landmarks[(np.searchsorted(landmarks, subjects[wrong]) + others) % len(landmarks)]
    return read


def detection_messages(rows, subjects, messages):
    """(receipt time in ns, message) for rows of time, subject, range, bearing; robots are left out."""
    stamps = nanoseconds(rows[:, 0])
    x = rows[:, 2] * np.cos(rows[:, 3])
    y = rows[:, 2] * np.sin(rows[:, 3])
    starts = group_starts(stamps)
    for group, (first, end) in enumerate(zip(starts[:-1], starts[1:])):
        message = messages.LandmarkDetectionArray()
        message.header.seq = group
        message.header.stamp = time_from_nanoseconds(stamps[first])
        message.header.frame_id = "base_footprint"
        for i in range(first, end):
            if subjects[i] in ROBOT_SUBJECTS:
                continue
            detection = messages.LandmarkDetection(id=int(subjects[i]), score=1.0)
            detection.position.x, detection.position.y = x[i], y[i]
            message.detections.append(detection)
        yield int(stamps[first]), "/landmarks", message


def true_landmark_map(rows, stamp, messages):
    """The map message of rows of subject, x, y and their standard deviations."""
    message = messages.LandmarkMap()
    message.header.stamp = time_from_nanoseconds(stamp)
    message.header.frame_id = "map"
    for subject, x, y, std_x, std_y in rows:
        landmark = messages.Landmark(id=int(subject), source_id=int(subject),
                                     status=messages.Landmark.CONFIRMED)
        landmark.position.x, landmark.position.y = x, y
        landmark.covariance[0], landmark.covariance[4] = std_x**2, std_y**2
        message.landmarks.append(landmark)
    return message


def read_measurements(folder, name):
    """(rows of time, barcode, range, bearing; the barcodes as whole numbers)."""
    rows = read_rows(folder, name, ("time", "barcode", "range", "bearing"))
    if (rows[:, 2] < 0.0).any():
        row = int((rows[:, 2] < 0.0).argmax())
        raise cli.InputError(f"{os.path.join(folder, name)}: row {row + 1} of numbers: range is {rows[row, 2]:g} m; "
                             "0 or more is needed")
    return rows, whole_numbers(folder, name, "barcode", rows[:, 1])


def read_barcodes(folder):
    """{barcode: subject}."""
    name = "Barcodes.dat"
    rows = read_rows(folder, name, ("subject", "barcode"), ordered_by_time=False)
    subject_of_barcode = {}
    for subject, barcode in zip(whole_numbers(folder, name, "subject", rows[:, 0]).tolist(),
                                whole_numbers(folder, name, "barcode", rows[:, 1]).tolist()):
        if subject_of_barcode.setdefault(barcode, subject) != subject:
            raise cli.InputError(f"{os.path.join(folder, name)}: barcode {barcode} is that of subjects "
                                 f"{subject_of_barcode[barcode]} and {subject}; each subject needs one of its own")
    return subject_of_barcode


def convert(folder, robot, bag_path, wrong_identities=0.0, seed=1):
    """Writes the bag; wrong_identities: share of the landmarks' detections with the identity of another."""
    messages = package_messages()

    if not os.path.isdir(folder):
        raise cli.InputError(f"{folder}: no such folder; one with Robot{robot}_Odometry.dat is needed")
    rows = read_rows(folder, f"Robot{robot}_Odometry.dat", ("time", "speed", "turn_rate"))
    measurements, read_codes = read_measurements(folder, f"Robot{robot}_Measurement.dat")
    true_poses = np.empty((0, 4))
    if os.path.exists(os.path.join(folder, f"Robot{robot}_Groundtruth.dat")):
        true_poses = read_rows(folder, f"Robot{robot}_Groundtruth.dat", ("time", "x", "y", "yaw"))
    subject_of_barcode = read_barcodes(folder)
    true_landmarks = read_rows(folder, "Landmark_Groundtruth.dat", ("subject", "x", "y", "std_x", "std_y"),
                               ordered_by_time=False)
    landmark_subjects = whole_numbers(folder, "Landmark_Groundtruth.dat", "subject", true_landmarks[:, 0])

    repeated = len(rows)
    rows = keep_last_of_repeated_stamps(rows)
    repeated -= len(rows)
    subjects = np.array([subject_of_barcode.get(barcode, -1) for barcode in read_codes.tolist()])
    robots = int(np.isin(subjects, ROBOT_SUBJECTS).sum())
    read = subjects
    if wrong_identities > 0.0:
        if len(true_landmarks) < 2:
            raise cli.InputError(f"{folder}: has one landmark; --wrong-identities needs another to mistake it for")
        read = misread(subjects, landmark_subjects, wrong_identities, seed)

    start = int(min(nanoseconds(table[0, 0]) for table in (rows, measurements, true_poses) if len(table)))
    streams = heapq.merge(odometry(rows), detection_messages(measurements, read, messages),
                          true_pose_messages(nanoseconds(true_poses[:, 0]), true_poses[:, 1:3],
                                             quaternion_from_yaw(true_poses[:, 3])), key=lambda item: item[0])
    with BagWriter(bag_path) as bag:
        bag.write(TRUE_LANDMARKS_TOPIC, true_landmark_map(true_landmarks, start, messages),
                  time_from_nanoseconds(start), latched=True)
        about = len(rows) + len(true_poses) + len(group_starts(nanoseconds(measurements[:, 0])))
        for stamp, topic, message in cli.progress(streams, about, "Writing"):
            bag.write(topic, message, time_from_nanoseconds(stamp))

    samples = bag.counts["/odom"]
    poses = bag.counts.get(TRUE_POSE_TOPIC, 0)
    print(f"/odom                    {samples:6d} messages: {len(rows)} rows, {samples - len(rows)} "
          f"samples to fill gaps; {repeated} rows with a repeated stamp left out")
    unlisted = int((subjects < 0).sum())
    wrong = f"{int((read != subjects).sum())} with a wrong identity, " if wrong_identities > 0.0 else ""
    print(f"/landmarks               {bag.counts['/landmarks']:6d} messages: {len(subjects) - robots} detections, "
          f"{wrong}{unlisted} of them with an unlisted barcode; {robots} sightings of robots left out")
    print(f"{TRUE_POSE_TOPIC}       {poses:6d} messages{'' if poses else ': the dataset has no such file'}")
    print(f"{TRUE_LANDMARKS_TOPIC}       1 message: {len(true_landmarks)} landmarks")


def main():
    parser = cli.ArgumentParser(description=__doc__)
    parser.add_argument("folder", metavar="FOLDER", help="folder of the dataset")
    parser.add_argument("robot", metavar="ROBOT", type=int, choices=range(1, 6),
                        help="number of the robot, 1 to 5")
    parser.add_argument("bag", metavar="OUT.bag", help="bag to write; one that exists is replaced")
    parser.add_argument("--wrong-identities", metavar="SHARE", type=float, default=0.0,
                        help="share of the landmarks' detections that get the identity of another landmark "
                        "(default: none)")
    parser.add_argument("--seed", metavar="N", type=int, default=1, help="of these (default: %(default)d)")
    arguments = parser.parse_args()
    if not 0.0 <= arguments.wrong_identities <= 1.0:
        parser.error(f"--wrong-identities is {arguments.wrong_identities:g}; a share from 0 to 1 is needed")
    if arguments.seed < 0:
        parser.error(f"--seed is {arguments.seed}; a whole number from 0 is needed")
    convert(arguments.folder, arguments.robot, arguments.bag, arguments.wrong_identities, arguments.seed)


if __name__ == "__main__":
    cli.run(main)
