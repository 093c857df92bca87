"""Compares an estimated path and map with the truth; slam_tools/metrics.py says what the figures mean."""
from dataclasses import dataclass
from typing import Dict, Optional

import numpy as np

from .bags import Landmarks, open_bag, read_true_landmarks, read_true_path
from .cli import InputError
from .geometry import (Interpolation, Path, RigidTransform, align, align_robustly, quaternion_inverse,
                       quaternion_product, rotation_vector_of_quaternion, wrap_angle, yaw_of_quaternion)
from .landmark_matching import association_accuracy, match_landmarks
from .metrics import no_metrics

ALIGNMENTS = {
    "none": "estimate and truth are compared in their own frames",
    "se2": "the estimate is brought onto the truth by the least-squares rigid transform in the plane",
    "se3": "the estimate is brought onto the truth by the least-squares rigid transform in space",
    "robust": "the estimate is brought onto the truth by the rigid transform in the plane with the smallest sum of "
              "distances, which outliers of the truth hardly move"}
TRUTH_GAP_MAX = 0.5            # s, over which the truth is interpolated
STD_MIN = 1e-7                 # m or rad: a covariance below is singular


@dataclass(frozen=True)
class Truth:
    path: Optional[Path]
    landmarks: Optional[Landmarks]

    @property
    def is_known(self):
        return self.path is not None or self.landmarks is not None


NO_TRUTH = Truth(None, None)


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


def read_truth(bag_path):
    with open_bag(bag_path) as bag:
        truth = Truth(read_true_path(bag_path, bag), read_true_landmarks(bag_path, bag))
    if not truth.is_known:
        raise InputError(f"{bag_path}: holds no truth; /ground_truth/pose, /ground_truth/landmarks or "
                         "a topic of sensor_msgs/NavSatFix is needed")
    return truth


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


def is_planar(path):
    """The path stays in its plane: no height, no roll, no pitch."""
    return bool(np.abs(path.positions[:, 2]).max() < 1e-9 and np.abs(path.quaternions[:, :2]).max() < 1e-9)


class _Comparison:
    """One evaluation while it is made: what the steps of `evaluate` hand on to each other."""

    def __init__(self, estimate, truth, alignment):
        self.estimate, self.truth, self.alignment = estimate, truth, alignment
        self.planar = alignment in ("se2", "robust") or (alignment == "none" and is_planar(estimate.path))
        self.size = 2 if self.planar else 3    # of the components that errors are counted in
        self.metrics = no_metrics(alignment)
        self.errors = self.start_nees = None
        self.path_transform = self.start_transform = self.dead_reckoning_transform = None
        self.landmark_transform = None
        self.pairs = {}

    def align_points(self, source, target):
        """The transform by pairs of points, None where they do not determine it."""
        if self.alignment == "none":
            return RigidTransform.identity()
        return (align_robustly if self.alignment == "robust" else align)(source, target, self.planar)

    def compare_paths(self):
        metrics, size, true_path = self.metrics, self.size, self.truth.path
        estimated, covariances, true = pair_paths(self.estimate.path, self.estimate.covariances, true_path)
        self.path_transform = self.align_points(estimated.positions, true.positions) if len(true) else None
        if self.path_transform is not None:
            self.errors = errors = path_errors(estimated, true, covariances, self.path_transform, self.planar)
            metrics["ate_rmse_m"] = root_mean_square(errors.position[:, :size])
            distances = np.linalg.norm(errors.position[:, :size], axis=1)
            metrics["path_error_median_m"], metrics["path_error_p95_m"] = np.percentile(distances, (50, 95)).tolist()
            if errors.yaw is not None:
                metrics["heading_rmse_deg"] = float(np.degrees(root_mean_square(errors.yaw)))
            metrics["pose_nees_mean"] = mean_or_none(errors.nees)
        if len(true) and true.quaternions is not None:
            self.start_transform = RigidTransform.between(estimated.positions[0], estimated.quaternions[0],
                                                          true.positions[0], true.quaternions[0], self.planar)
            start_errors = path_errors(estimated, true, covariances, self.start_transform, self.planar)
            metrics["ate_rmse_start_m"] = root_mean_square(start_errors.position[:, :size])
            self.start_nees = start_errors.nees
            metrics["pose_nees_start_mean"] = mean_or_none(self.start_nees)
        if self.estimate.dead_reckoning is not None:
            reckoned, _, true_there = pair_paths(self.estimate.dead_reckoning, None, true_path)
            self.dead_reckoning_transform = self.align_points(reckoned.positions, true_there.positions)
            if self.dead_reckoning_transform is not None and len(true_there):
                metrics["dead_reckoning_ate_rmse_m"] = root_mean_square(
                    (self.dead_reckoning_transform.points(reckoned.positions) - true_there.positions)[:, :size])
        return estimated if true.quaternions is None else true   # a GPS track's noise lengthens it

    def measure(self, path):
        if len(path):
            steps = np.diff(path.positions[:, :self.size], axis=0)
            self.metrics["path_length_m"] = float(np.linalg.norm(steps, axis=1).sum())
            self.metrics["duration_s"] = float(path.stamps[-1] - path.stamps[0])

    def compare_landmarks(self):
        metrics, size = self.metrics, self.size
        estimated, true = self.estimate.landmarks, self.truth.landmarks
        self.pairs, self.landmark_transform = match_landmarks(estimated, true, self.path_transform,
                                                              self.align_points, self.planar)
        metrics["landmarks_true"] = len(true)
        metrics["landmarks_missed"] = len(true) - len(self.pairs)
        metrics["landmarks_spurious"] = len(estimated) - len(self.pairs)
        metrics["association_accuracy"] = association_accuracy(estimated, true, self.pairs,
                                                               self.estimate.associations)
        if self.estimate.associations_instant is not None:
            metrics["association_accuracy_instant"] = association_accuracy(estimated, true, self.pairs,
                                                                           self.estimate.associations_instant)
        matched = estimated.positions[list(self.pairs.keys())].reshape(-1, 3)
        targets = true.positions[list(self.pairs.values())].reshape(-1, 3)
        if self.landmark_transform is not None and self.pairs:
            distances = np.linalg.norm((self.landmark_transform.points(matched) - targets)[:, :size], axis=1)
            metrics["landmark_rmse_m"] = root_mean_square(distances)
            metrics["landmark_max_m"] = float(distances.max())
        if self.start_transform is not None and self.pairs:
            metrics["landmark_rmse_start_m"] = root_mean_square(
                (self.start_transform.points(matched) - targets)[:, :size])

    def in_truth(self):
        """For pictures: everything in the frame of the truth, as well as it can be brought there."""
        path_there = (self.path_transform or self.start_transform or self.landmark_transform
                      or RigidTransform.identity())
        landmarks_there = self.landmark_transform or path_there
        path = self.estimate.path.transformed(path_there)
        dead_reckoning = self.estimate.dead_reckoning
        if dead_reckoning is not None:
            there = self.dead_reckoning_transform or RigidTransform.between(   # start where the estimate starts
                dead_reckoning.positions[0], dead_reckoning.quaternions[0], path.positions[0], path.quaternions[0],
                self.planar)
            dead_reckoning = dead_reckoning.transformed(there)
        landmarks = self.estimate.landmarks
        return Evaluation(
            metrics=self.metrics, planar=self.planar, path_errors=self.errors, start_nees=self.start_nees,
            path_in_truth=path, dead_reckoning_in_truth=dead_reckoning,
            landmarks_in_truth=landmarks_there.points(landmarks.positions),
            landmark_covariances_in_truth=landmarks_there.covariances(landmarks.covariances), pairs=self.pairs)


def evaluate(estimate, truth, alignment):
    """alignment: one of ALIGNMENTS."""
    comparison = _Comparison(estimate, truth, alignment)
    comparison.metrics["landmarks_estimated"] = len(estimate.landmarks)
    comparison.measure(estimate.path if truth.path is None else comparison.compare_paths())
    if truth.landmarks is not None:
        comparison.compare_landmarks()
    return comparison.in_truth()
