"""Reads what a run left in its folder: the estimated path and map, and what became of the detections."""
import os
from collections import Counter
from dataclasses import dataclass
from typing import Optional

import numpy as np

from .bags import Landmarks
from .cli import InputError
from .geometry import Path
from .tables import read_csv, read_numbers

ACCEPTED = ("matched", "created")

POSE_COLUMNS = ("t", "x", "y", "z", "qx", "qy", "qz", "qw")
COVARIANCE_COLUMNS = ("t",) + tuple(f"c{a}{b}" for i, a in enumerate("xyzrpw") for b in "xyzrpw"[i:])
LANDMARK_COLUMNS = ("id", "label", "x", "y", "z", "cxx", "cxy", "cxz", "cyy", "cyz", "czz", "observations")
ASSOCIATION_COLUMNS = ("t", "detection", "source_id", "verdict", "landmark", "nis")


@dataclass(frozen=True)
class Associations:
    stamps: np.ndarray
    identities: np.ndarray    # that the detection carried, -1: none
    landmarks: np.ndarray     # id in the map, -1: none
    accepted: np.ndarray
    nis: np.ndarray           # NaN: none


@dataclass(frozen=True)
class Estimate:
    path: Path
    covariances: Optional[np.ndarray]      # n x 6 x 6: x y z roll pitch yaw, axes of the map
    dead_reckoning: Optional[Path]
    landmarks: Landmarks                   # identities: the majority of the associations
    associations: Associations             # as known at the end
    associations_instant: Optional[Associations]   # as told at once


def read_path(path):
    rows = read_numbers(path, POSE_COLUMNS)
    if not len(rows):
        raise InputError(f"{path}: holds no poses; lines of '{' '.join(POSE_COLUMNS)}' are needed")
    norms = np.linalg.norm(rows[:, 4:], axis=1)
    if (np.abs(norms - 1.0) > 1e-2).any():
        row = int(np.argmax(np.abs(norms - 1.0) > 1e-2))
        raise InputError(f"{path}: the quaternion of pose {row + 1} has norm {norms[row]:.3g}; 1 is needed")
    return rows[:, 0], rows[:, 1:4], rows[:, 4:] / norms[:, None]


def read_covariances(path, stamps):
    rows = read_numbers(path, COVARIANCE_COLUMNS, separator=",", header=True)
    if len(rows) != len(stamps) or (np.abs(rows[:, 0] - stamps) > 1e-4).any():
        raise InputError(f"{path}: its stamps ({len(rows)}) are not those of trajectory.tum ({len(stamps)}); "
                         "both have to come from the same run")
    covariances = np.empty((len(rows), 6, 6))
    upper = np.triu_indices(6)
    covariances[:, upper[0], upper[1]] = rows[:, 1:]
    covariances[:, upper[1], upper[0]] = rows[:, 1:]
    return covariances


def read_associations(path):
    rows = read_csv(path, ASSOCIATION_COLUMNS, ("t", "source_id", "landmark", "nis"))
    for row in rows:
        for name in ("t", "source_id", "landmark"):
            if not np.isfinite(row[name]):
                raise InputError(f"{path}:{row['line']}: {name} is not finite; a number is needed (-1: none)")
    return Associations(
        stamps=np.array([row["t"] for row in rows]),
        identities=np.array([row["source_id"] for row in rows], dtype=int),
        landmarks=np.array([row["landmark"] for row in rows], dtype=int),
        accepted=np.array([row["verdict"] in ACCEPTED for row in rows], dtype=bool),
        nis=np.array([row["nis"] for row in rows], dtype=float))


def read_landmarks(path, associations):
    """The landmarks of the map; their identities come from their detections."""
    numeric = tuple(name for name in LANDMARK_COLUMNS if name != "label")
    rows = read_csv(path, LANDMARK_COLUMNS, numeric)
    values = np.array([[row[name] for name in numeric] for row in rows]).reshape(-1, len(numeric))
    if not np.isfinite(values).all():
        row, column = np.argwhere(~np.isfinite(values))[0]
        raise InputError(f"{path}:{rows[row]['line']}: {numeric[column]} is not finite; "
                         "a finite number is needed")
    ids = values[:, 0].astype(int)
    repeated = [identity for identity, count in Counter(ids.tolist()).items() if count > 1]
    if repeated:
        raise InputError(f"{path}: landmark {repeated[0]} is there twice; ids have to be unique")
    xx, xy, xz, yy, yz, zz = values[:, 4:10].T
    covariances = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)
    return Landmarks(ids=ids, identities=majority_identities(ids, associations),
                     labels=[row["label"] for row in rows], positions=values[:, 1:4], covariances=covariances,
                     observations=values[:, 10].astype(int))


def majority_identities(ids, associations):
    """For every landmark the identity that most of its accepted detections carried, or -1.

    Of equally frequent ones the lowest.
    """
    votes = {}
    known = associations.accepted & (associations.identities >= 0)
    for landmark, identity in zip(associations.landmarks[known].tolist(),
                                  associations.identities[known].tolist()):
        votes.setdefault(landmark, Counter())[identity] += 1
    return np.array([max(votes[i].items(), key=lambda vote: (vote[1], -vote[0]))[0] if i in votes else -1
                     for i in ids.tolist()], dtype=int)


def read_estimate(folder):
    """What slam_replay wrote."""
    if not os.path.isdir(folder):
        raise InputError(f"{folder}: no such folder; one that 'slam_replay BAG --out DIR' wrote is needed")
    stamps, positions, quaternions = read_path(os.path.join(folder, "trajectory.tum"))
    covariance_path = os.path.join(folder, "trajectory_covariance.csv")
    covariances = read_covariances(covariance_path, stamps) if os.path.exists(covariance_path) else None
    # stamps in order, and the covariances with them
    order = Path.in_time_order(stamps, np.arange(len(stamps)), None).positions
    path = Path(stamps[order], positions[order], quaternions[order])
    dead_reckoning_path = os.path.join(folder, "dead_reckoning.tum")
    dead_reckoning = None
    if os.path.exists(dead_reckoning_path):
        dead_reckoning = Path.in_time_order(*read_path(dead_reckoning_path))
    associations = read_associations(os.path.join(folder, "associations.csv"))
    landmarks = read_landmarks(os.path.join(folder, "landmarks.csv"), associations)
    if covariances is not None:
        covariances = covariances[order]
    instant_path = os.path.join(folder, "associations_instant.csv")
    instant = read_associations(instant_path) if os.path.exists(instant_path) else None
    return Estimate(path, covariances, dead_reckoning, landmarks, associations, instant)
