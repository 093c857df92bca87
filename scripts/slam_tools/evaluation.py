"""Compares an estimated path and map with the truth.

The result of slam_replay is read by `read_estimate`; `evaluate` makes the figures that evaluate.py documents.
"""
import json
import os
from collections import Counter
from dataclasses import dataclass
from typing import Dict, List, Optional

import numpy as np

from .bags import Landmarks, open_bag, read_true_landmarks, read_true_path
from .cli import InputError, atomic_output
from .geometry import (Interpolation, Path, RigidTransform, align, align_robustly, quaternion_inverse,
                       quaternion_product, rotation_vector_of_quaternion, wrap_angle, yaw_of_quaternion)
from .tables import read_csv, read_numbers

TRUTH_GAP_MAX = 0.5            # s, over which the truth is interpolated
MATCH_DISTANCE_MAX = 0.5       # m, between landmarks that are matched by position
ACCEPTED = ("matched", "created")
STD_MIN = 1e-7                 # m or rad: a covariance below is singular

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


@dataclass(frozen=True)
class Truth:
    path: Optional[Path]
    landmarks: Optional[Landmarks]


@dataclass(frozen=True)
class PathErrors:
    """Errors of an aligned path, in the axes of the truth."""
    stamps: np.ndarray
    aligned: Path
    true: Path
    position: np.ndarray                   # m, n x 3
    yaw: Optional[np.ndarray]              # rad; None: the truth is positions only
    covariances: Optional[np.ndarray]      # n x 6 x 6
    nees: Optional[np.ndarray]             # NaN where the covariance is singular


@dataclass(frozen=True)
class Evaluation:
    """metrics: what evaluation.json holds; the rest is for the picture."""
    metrics: Dict[str, object]
    planar: bool
    path_errors: Optional[PathErrors]
    start_nees: Optional[np.ndarray]       # of the path laid on the truth at its start, at path_errors' stamps
    path_in_truth: Path                    # the whole estimated path
    dead_reckoning_in_truth: Optional[Path]
    landmarks_in_truth: np.ndarray         # positions of all estimated landmarks
    landmark_covariances_in_truth: np.ndarray
    pairs: Dict[int, int]                  # index of the estimated -> index of the true landmark

    @property
    def nees_dimension(self):
        return 3 if self.planar else 6


# -------------------------------------------------------------------------------- reading


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


def read_truth(bag_path):
    with open_bag(bag_path) as bag:
        truth = Truth(read_true_path(bag_path, bag), read_true_landmarks(bag_path, bag))
    if truth.path is None and truth.landmarks is None:
        raise InputError(f"{bag_path}: holds no truth; /ground_truth/pose, /ground_truth/landmarks or "
                         "a topic of sensor_msgs/NavSatFix is needed")
    return truth


# -------------------------------------------------------------------------------- the path


def pair_paths(estimate, covariances, truth):
    """(estimated path, its covariances or None, true path) at common stamps.

    Where the truth has orientations it is interpolated at the estimate's stamps; positions alone come seldom
    and noisy, so that then the estimate is interpolated at theirs.
    """
    if truth.quaternions is not None:
        valid, true = truth.at(estimate.stamps, TRUTH_GAP_MAX)
        estimated = Path(true.stamps, estimate.positions[valid], estimate.quaternions[valid])
        return estimated, None if covariances is None else covariances[valid], true
    between = Interpolation.of(estimate.stamps, truth.stamps, TRUTH_GAP_MAX)
    _, estimated = estimate.at(truth.stamps, TRUTH_GAP_MAX)
    true = Path(estimated.stamps, truth.positions[between.valid], None)
    return estimated, None if covariances is None else between.linear(covariances), true


def nees(errors, covariances):
    """Normalised estimation error squared: e^T P^-1 e of every row; NaN where P is singular."""
    result = np.full(len(errors), np.nan)
    regular = np.linalg.eigvalsh(covariances)[:, 0] > STD_MIN**2
    solved = np.linalg.solve(covariances[regular], errors[regular][..., None])[..., 0]
    result[regular] = np.sum(errors[regular] * solved, axis=1)
    return result


def path_errors(estimated, true, covariances, transform, planar):
    """The errors of the estimated path after the transform."""
    aligned = estimated.transformed(transform)
    position = aligned.positions - true.positions
    if covariances is not None:
        covariances = transform.covariances(covariances)
    if true.quaternions is None:
        return PathErrors(true.stamps, aligned, true, position, None, covariances, None)
    yaw = wrap_angle(yaw_of_quaternion(aligned.quaternions) - yaw_of_quaternion(true.quaternions))
    squared = None
    if covariances is not None and planar:
        in_plane = [0, 1, 5]
        squared = nees(np.column_stack([position[:, :2], yaw]), covariances[:, in_plane][:, :, in_plane])
    elif covariances is not None:
        turn = quaternion_product(aligned.quaternions, quaternion_inverse(true.quaternions))
        squared = nees(np.column_stack([position, rotation_vector_of_quaternion(turn)]), covariances)
    return PathErrors(true.stamps, aligned, true, position, yaw, covariances, squared)


def root_mean_square(values):
    """Of numbers, or of the lengths of rows; None without any."""
    values = np.asarray(values)
    if not len(values):
        return None
    return float(np.sqrt(np.mean(np.sum(values.reshape(len(values), -1)**2, axis=1))))


def mean_or_none(values):
    values = None if values is None else values[np.isfinite(values)]
    return float(values.mean()) if values is not None and len(values) else None


# -------------------------------------------------------------------------------- landmarks


def match_by_identity(estimated, true):
    """{estimated: true} indices; of several landmarks with one identity that with most observations."""
    pairs = {}
    for j, identity in enumerate(true.identities.tolist()):
        candidates = np.flatnonzero(estimated.identities == identity) if identity >= 0 else []
        if len(candidates):
            pairs[int(candidates[np.argmax(estimated.observations[candidates])])] = j
    return pairs


def mutual_nearest(a, b, max_distance):
    """{index in a: index in b} of points that are each other's nearest, within max_distance."""
    if not len(a) or not len(b):
        return {}
    distances = np.linalg.norm(a[:, None] - b[None], axis=2)
    to_b, to_a = distances.argmin(axis=1), distances.argmin(axis=0)
    return {i: int(j) for i, j in enumerate(to_b) if to_a[j] == i and distances[i, j] <= max_distance}


def best_planar_transform(source, target, max_distance, hypotheses_max=20000):
    """The planar transform, of those by two pairs, under which most source points have a target point near.

    source: the most reliable points first; the first 15 make the hypotheses.
    """
    source, target = source[:15, :2], target[:, :2]
    if len(source) < 2 or len(target) < 2:
        return None
    i, j = np.triu_indices(len(source), 1)
    k, l = np.nonzero(~np.eye(len(target), dtype=bool))
    source_side, target_side = source[j] - source[i], target[l] - target[k]
    misfit = np.abs(np.linalg.norm(source_side, axis=1)[:, None] - np.linalg.norm(target_side, axis=1)[None])
    candidates = np.argsort(misfit, axis=None, kind="stable")[:hypotheses_max]
    candidates = candidates[misfit.ravel()[candidates] <= max_distance]
    best_score, best = 0.0, None
    for a, b in zip(*np.unravel_index(candidates, misfit.shape)):
        yaw = np.arctan2(*target_side[b, ::-1]) - np.arctan2(*source_side[a, ::-1])
        transform = RigidTransform.planar(0.0, 0.0, yaw)
        turned = source @ transform.rotation[:2, :2].T
        offset = 0.5 * (target[k[b]] + target[l[b]] - turned[i[a]] - turned[j[a]])
        nearest = np.linalg.norm((turned + offset)[:, None] - target[None], axis=2).min(axis=1)
        score = np.sum(np.maximum(1.0 - nearest / max_distance, 0.0))
        if score > best_score:
            best_score, best = score, RigidTransform.planar(offset[0], offset[1], yaw)
    return best


def match_landmarks(estimated, true, path_transform, align_pairs, planar):
    """({estimated: true} indices, transform of the estimated landmarks or None).

    By identity where there is one. The others by position: mutual nearest neighbours among those that are
    left, after the path's alignment, then after the alignment by the pairs found, until nothing changes.
    align_pairs(source, target): the transform by pairs, None where they do not determine it.
    """
    identified = match_by_identity(estimated, true)

    def transform_by(pairs):
        return align_pairs(estimated.positions[list(pairs.keys())], true.positions[list(pairs.values())])

    unknown = np.flatnonzero(estimated.identities < 0)
    free = np.array([j for j in range(len(true)) if j not in identified.values()], dtype=int)
    pairs = dict(identified)
    if len(unknown) and len(free):
        transform = path_transform or transform_by(identified)
        if transform is None:
            most_observed = unknown[np.argsort(-estimated.observations[unknown], kind="stable")]
            transform = best_planar_transform(estimated.positions[most_observed], true.positions[free],
                                              MATCH_DISTANCE_MAX)
        size = 2 if planar else 3
        for _ in range(50):
            if transform is None:
                break
            found = mutual_nearest(transform.points(estimated.positions[unknown])[:, :size],
                                   true.positions[free][:, :size], MATCH_DISTANCE_MAX)
            now = {**identified, **{int(unknown[i]): int(free[j]) for i, j in found.items()}}
            transform = transform_by(now) or transform
            if now == pairs:
                break
            pairs = now
    return pairs, transform_by(pairs)


def association_accuracy(estimated, true, pairs, associations):
    """Of the accepted detections with an identity, the share whose landmark matches the true one of it."""
    known = associations.accepted & (associations.identities >= 0)
    if not known.any():
        return None
    identity_of = {int(estimated.ids[i]): int(true.identities[j]) for i, j in pairs.items()}
    right = [identity_of.get(landmark) == identity for landmark, identity
             in zip(associations.landmarks[known].tolist(), associations.identities[known].tolist())]
    return float(np.mean(right))


# -------------------------------------------------------------------------------- together


def is_planar(path):
    """The path stays in its plane: no height, no roll, no pitch."""
    return bool(np.abs(path.positions[:, 2]).max() < 1e-9 and np.abs(path.quaternions[:, :2]).max() < 1e-9)


def evaluate(estimate, truth, alignment):
    """alignment: none, se2, se3 or robust."""
    planar = alignment in ("se2", "robust") or (alignment == "none" and is_planar(estimate.path))
    size = 2 if planar else 3

    def align_points(source, target):
        if alignment == "none":
            return RigidTransform.identity()
        return (align_robustly if alignment == "robust" else align)(source, target, planar)

    metrics = {name: None for name in (
        "align", "ate_rmse_m", "path_error_median_m", "path_error_p95_m", "heading_rmse_deg", "landmark_rmse_m", "landmark_max_m", "landmarks_estimated",
        "landmarks_true", "landmarks_missed", "landmarks_spurious", "association_accuracy",
        "association_accuracy_instant", "pose_nees_mean",
        "dead_reckoning_ate_rmse_m", "ate_rmse_start_m", "landmark_rmse_start_m", "pose_nees_start_mean",
        "path_length_m", "duration_s")}
    metrics["align"] = alignment
    metrics["landmarks_estimated"] = len(estimate.landmarks)

    # the path
    errors = start_nees = path_transform = start_transform = dead_reckoning_transform = None
    measured_path = estimate.path
    if truth.path is not None:
        estimated, covariances, true = pair_paths(estimate.path, estimate.covariances, truth.path)
        measured_path = estimated if true.quaternions is None else true   # a GPS track's noise lengthens it
        path_transform = align_points(estimated.positions, true.positions) if len(true) else None
        if path_transform is not None:
            errors = path_errors(estimated, true, covariances, path_transform, planar)
            metrics["ate_rmse_m"] = root_mean_square(errors.position[:, :size])
            distances = np.linalg.norm(errors.position[:, :size], axis=1)
            metrics["path_error_median_m"], metrics["path_error_p95_m"] = np.percentile(distances, (50, 95))
            if errors.yaw is not None:
                metrics["heading_rmse_deg"] = float(np.degrees(root_mean_square(errors.yaw)))
            metrics["pose_nees_mean"] = mean_or_none(errors.nees)
        if len(true) and true.quaternions is not None:
            start_transform = RigidTransform.between(estimated.positions[0], estimated.quaternions[0],
                                                     true.positions[0], true.quaternions[0], planar)
            start_errors = path_errors(estimated, true, covariances, start_transform, planar)
            metrics["ate_rmse_start_m"] = root_mean_square(start_errors.position[:, :size])
            start_nees = start_errors.nees
            metrics["pose_nees_start_mean"] = mean_or_none(start_nees)
        if estimate.dead_reckoning is not None:
            reckoned, _, true_there = pair_paths(estimate.dead_reckoning, None, truth.path)
            dead_reckoning_transform = align_points(reckoned.positions, true_there.positions)
            if dead_reckoning_transform is not None and len(true_there):
                metrics["dead_reckoning_ate_rmse_m"] = root_mean_square(
                    (dead_reckoning_transform.points(reckoned.positions) - true_there.positions)[:, :size])
    if len(measured_path):
        metrics["path_length_m"] = float(np.linalg.norm(np.diff(measured_path.positions[:, :size], axis=0),
                                                        axis=1).sum())
        metrics["duration_s"] = float(measured_path.stamps[-1] - measured_path.stamps[0])

    # the landmarks
    pairs, landmark_transform = {}, None
    if truth.landmarks is not None:
        estimated, true = estimate.landmarks, truth.landmarks
        pairs, landmark_transform = match_landmarks(estimated, true, path_transform, align_points, planar)
        metrics["landmarks_true"] = len(true)
        metrics["landmarks_missed"] = len(true) - len(pairs)
        metrics["landmarks_spurious"] = len(estimated) - len(pairs)
        metrics["association_accuracy"] = association_accuracy(estimated, true, pairs, estimate.associations)
        if estimate.associations_instant is not None:
            metrics["association_accuracy_instant"] = association_accuracy(estimated, true, pairs,
                                                                           estimate.associations_instant)
        matched = estimated.positions[list(pairs.keys())].reshape(-1, 3)
        targets = true.positions[list(pairs.values())].reshape(-1, 3)
        if landmark_transform is not None and pairs:
            distances = np.linalg.norm((landmark_transform.points(matched) - targets)[:, :size], axis=1)
            metrics["landmark_rmse_m"] = root_mean_square(distances)
            metrics["landmark_max_m"] = float(distances.max())
        if start_transform is not None and pairs:
            metrics["landmark_rmse_start_m"] = root_mean_square(
                (start_transform.points(matched) - targets)[:, :size])

    # for the picture: everything in the frame of the truth, as well as it can be brought there
    path_there = path_transform or start_transform or landmark_transform or RigidTransform.identity()
    landmarks_there = landmark_transform or path_there
    dead_reckoning = estimate.dead_reckoning
    if dead_reckoning is not None:
        if dead_reckoning_transform is None:   # start where the estimate starts
            first = estimate.path.transformed(path_there)
            dead_reckoning_transform = RigidTransform.between(
                dead_reckoning.positions[0], dead_reckoning.quaternions[0], first.positions[0],
                first.quaternions[0], planar)
        dead_reckoning = dead_reckoning.transformed(dead_reckoning_transform)
    return Evaluation(
        metrics=metrics, planar=planar, path_errors=errors, start_nees=start_nees,
        path_in_truth=estimate.path.transformed(path_there),
        dead_reckoning_in_truth=dead_reckoning,
        landmarks_in_truth=landmarks_there.points(estimate.landmarks.positions),
        landmark_covariances_in_truth=landmarks_there.covariances(estimate.landmarks.covariances),
        pairs=pairs)


def write_metrics(metrics, path):
    with atomic_output(path) as temporary_path:
        with open(temporary_path, "w", encoding="utf-8") as file:
            json.dump(metrics, file, indent=2, allow_nan=False)
            file.write("\n")


def table(metrics) -> List[str]:
    """The metrics as lines of text."""
    rows = [("path", None, None),
            ("position error, RMSE", "ate_rmse_m", "m"), ("  median", "path_error_median_m", "m"),
            ("  95th percentile", "path_error_p95_m", "m"), ("  aligned at the start", "ate_rmse_start_m", "m"),
            ("  of dead reckoning", "dead_reckoning_ate_rmse_m", "m"),
            ("heading error, RMSE", "heading_rmse_deg", "deg"),
            ("pose NEES, mean", "pose_nees_mean", ""), ("  aligned at the start", "pose_nees_start_mean", ""),
            ("length", "path_length_m", "m"), ("duration", "duration_s", "s"),
            ("landmarks", None, None),
            ("position error, RMSE", "landmark_rmse_m", "m"),
            ("position error, largest", "landmark_max_m", "m"),
            ("  RMSE, aligned at the start", "landmark_rmse_start_m", "m"),
            ("estimated", "landmarks_estimated", ""), ("true", "landmarks_true", ""),
            ("missed", "landmarks_missed", ""), ("spurious", "landmarks_spurious", ""),
            ("associations that are right", "association_accuracy", ""),
            ("  as told at once", "association_accuracy_instant", "")]
    lines = []
    for title, name, unit in rows:
        if name is None:
            lines.append(title)
            continue
        value = metrics[name]
        text = "-" if value is None else str(value) if isinstance(value, int) else f"{value:.3f}"
        lines.append(f"  {title:30s}{text:>12s} {unit if value is not None else ''}".rstrip())
    return lines
