"""Rotations, rigid transforms and paths. Quaternions are rows (x, y, z, w); angles are radians."""
from dataclasses import dataclass
from typing import Optional

import numpy as np


def wrap_angle(angle):
    """The same angle in [-pi, pi)."""
    return (np.asarray(angle) + np.pi) % (2.0 * np.pi) - np.pi


def quaternion_from_yaw(yaw):
    half = 0.5 * np.asarray(yaw, dtype=float)
    zero = np.zeros_like(half)
    return np.stack([zero, zero, np.sin(half), np.cos(half)], axis=-1)


def yaw_of_quaternion(q):
    x, y, z, w = np.moveaxis(np.asarray(q), -1, 0)
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def quaternion_product(a, b):
    a, b = np.broadcast_arrays(a, b)
    vector = (a[..., 3:] * b[..., :3] + b[..., 3:] * a[..., :3] + np.cross(a[..., :3], b[..., :3]))
    scalar = a[..., 3:] * b[..., 3:] - np.sum(a[..., :3] * b[..., :3], axis=-1, keepdims=True)
    return np.concatenate([vector, scalar], axis=-1)


def quaternion_inverse(q):
    return np.asarray(q) * np.array([-1.0, -1.0, -1.0, 1.0])


def rotation_vector_of_quaternion(q):
    """Logarithm: the rotation vector with an angle of at most pi."""
    q = np.where(q[..., 3:] < 0.0, -q, q)
    sine = np.linalg.norm(q[..., :3], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., 3:])
    return q[..., :3] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)


def quaternion_of_rotation_vector(vector):
    """Exponential: the inverse of `rotation_vector_of_quaternion`."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate([0.5 * np.sinc(angle / (2.0 * np.pi)) * vector, np.cos(0.5 * angle)], axis=-1)


def rotation_of_quaternion(q):
    """The 3 x 3 rotation matrix of one quaternion."""
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def quaternion_of_rotation(r):
    """The quaternion of one 3 x 3 rotation matrix: the dominant eigenvector of Bar-Itzhack's matrix."""
    k = np.array([[r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
                  [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
                  [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
                  [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], np.trace(r)]])
    q = np.linalg.eigh(k)[1][:, -1]
    return q if q[3] >= 0.0 else -q


@dataclass(frozen=True)
class RigidTransform:
    """p -> R p + t. A planar one turns about z and leaves z alone."""
    rotation: np.ndarray
    translation: np.ndarray

    @staticmethod
    def identity():
        return RigidTransform(np.eye(3), np.zeros(3))

    @staticmethod
    def planar(x, y, yaw):
        return RigidTransform(rotation_of_quaternion(quaternion_from_yaw(yaw)), np.array([x, y, 0.0]))

    @staticmethod
    def between(source_position, source_quaternion, target_position, target_quaternion, planar):
        """The transform that puts the source pose on the target pose."""
        turn = quaternion_product(target_quaternion, quaternion_inverse(source_quaternion))
        if planar:
            yaw = yaw_of_quaternion(target_quaternion) - yaw_of_quaternion(source_quaternion)
            turn = quaternion_from_yaw(yaw)
        rotation = rotation_of_quaternion(turn)
        translation = target_position - rotation @ source_position
        if planar:
            translation[2] = 0.0
        return RigidTransform(rotation, translation)

    def after(self, first):
        """This transform applied to the result of `first`."""
        return RigidTransform(self.rotation @ first.rotation, self.points(first.translation))

    def points(self, points):
        return np.asarray(points) @ self.rotation.T + self.translation

    def quaternions(self, q):
        return quaternion_product(quaternion_of_rotation(self.rotation), q)

    def covariances(self, covariances):
        """Covariances of 3-vectors, or of stacked 3-vectors (position, rotation), in the new axes."""
        size = covariances.shape[-1]
        turn = np.kron(np.eye(size // 3), self.rotation)
        return turn @ covariances @ turn.T


def align(source, target, planar, weights=None) -> Optional[RigidTransform]:
    """The rigid transform that brings the source points nearest to the target points, by least squares.

    Umeyama, "Least-squares estimation of transformation parameters between two point patterns", IEEE PAMI
    13(4), 1991, without scale; never a reflection. Planar: x and y only. weights: of the pairs, alike when
    None. None where the points do not determine it: all of them in one place, or, in space, on one line.
    """
    size = 2 if planar else 3
    if len(source) < size:
        return None
    a, b = np.asarray(source)[:, :size], np.asarray(target)[:, :size]
    weights = np.full(len(a), 1.0 / len(a)) if weights is None else weights / np.sum(weights)
    a_mean, b_mean = weights @ a, weights @ b
    u, spread, vt = np.linalg.svd((weights[:, None] * (b - b_mean)).T @ (a - a_mean))
    if spread[size - 2] < 1e-12 + 1e-9 * spread[0]:
        return None
    signs = np.ones(size)
    signs[-1] = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    transform = RigidTransform.identity()
    transform.rotation[:size, :size] = u @ np.diag(signs) @ vt
    transform.translation[:size] = b_mean - transform.rotation[:size, :size] @ a_mean
    return transform


def align_robustly(source, target, planar) -> Optional[RigidTransform]:
    """As `align`, but it minimises the sum of the distances, not of their squares: outliers hardly pull.

    By iteratively reweighted least squares: a pair's weight is one over its distance.
    """
    size = 2 if planar else 3
    source, target = np.asarray(source), np.asarray(target)
    transform = align(source, target, planar)
    for _ in range(100):
        if transform is None:
            break
        distances = np.linalg.norm((transform.points(source) - target)[:, :size], axis=1)
        closer = align(source, target, planar, 1.0 / np.maximum(distances, 1e-3))
        moved = np.inf if closer is None else np.abs(closer.points(source) - transform.points(source)).max()
        transform = closer
        if moved < 1e-6:
            break
    return transform


@dataclass(frozen=True)
class Interpolation:
    """Where stamps fall between samples: before + weight * (after - before), for those that are `valid`."""
    valid: np.ndarray
    before: np.ndarray
    after: np.ndarray
    weight: np.ndarray

    @staticmethod
    def of(sample_stamps, stamps, max_gap):
        """Stamps outside of the samples, or inside of a gap longer than max_gap, are not valid."""
        before = np.searchsorted(sample_stamps, stamps, side="right") - 1
        inside = (before >= 0) & (stamps <= sample_stamps[-1])
        before = np.clip(before, 0, len(sample_stamps) - 1)
        after = np.minimum(before + 1, len(sample_stamps) - 1)
        gap = sample_stamps[after] - sample_stamps[before]
        weight = np.where(gap > 0.0, (stamps - sample_stamps[before]) / np.where(gap > 0.0, gap, 1.0), 0.0)
        valid = inside & ((gap <= max_gap) | (weight == 0.0))
        return Interpolation(valid, before[valid], after[valid], weight[valid])

    def linear(self, values):
        weight = self.weight.reshape((-1,) + (1,) * (values.ndim - 1))
        return values[self.before] + weight * (values[self.after] - values[self.before])

    def rotations(self, q):
        """Along the shortest turn at constant rate: for a robot on a floor, the heading on the circle."""
        turn = rotation_vector_of_quaternion(
            quaternion_product(quaternion_inverse(q[self.before]), q[self.after]))
        return quaternion_product(q[self.before], quaternion_of_rotation_vector(self.weight[:, None] * turn))


@dataclass(frozen=True)
class Path:
    """Poses over time, stamps strictly increasing. quaternions is None where only positions are known."""
    stamps: np.ndarray
    positions: np.ndarray
    quaternions: Optional[np.ndarray]

    @staticmethod
    def in_time_order(stamps, positions, quaternions):
        """Sorts by stamp; of repeated stamps the last one stays."""
        order = np.argsort(stamps, kind="stable")
        order = order[np.append(np.diff(stamps[order]) > 0.0, True)[:len(order)]]
        return Path(stamps[order], positions[order], None if quaternions is None else quaternions[order])

    def at(self, stamps, max_gap):
        """(valid, path at the valid ones of the stamps)."""
        between = Interpolation.of(self.stamps, stamps, max_gap)
        quaternions = None if self.quaternions is None else between.rotations(self.quaternions)
        return between.valid, Path(stamps[between.valid], between.linear(self.positions), quaternions)

    def transformed(self, transform):
        quaternions = None if self.quaternions is None else transform.quaternions(self.quaternions)
        return Path(self.stamps, transform.points(self.positions), quaternions)

    def __len__(self):
        return len(self.stamps)


def integrate_arcs(durations, speeds, turn_rates):
    """Poses (x, y, yaw) before each step and after the last one, from the origin.

    The body velocities hold over each step; it is integrated exactly along the arc.
    """
    turns = turn_rates * durations
    yaw = np.concatenate([[0.0], np.cumsum(turns)])
    chord = speeds * durations * np.sinc(turns / (2.0 * np.pi))
    direction = yaw[:-1] + 0.5 * turns
    x = np.concatenate([[0.0], np.cumsum(chord * np.cos(direction))])
    y = np.concatenate([[0.0], np.cumsum(chord * np.sin(direction))])
    return np.column_stack([x, y, yaw])


def ecef_from_geodetic(latitude, longitude, altitude):
    """WGS84: degrees and metres above the ellipsoid to metres, earth-centred and earth-fixed."""
    semi_major_axis, flattening = 6378137.0, 1.0 / 298.257223563
    e2 = flattening * (2.0 - flattening)
    phi, lam = np.radians(latitude), np.radians(longitude)
    n = semi_major_axis / np.sqrt(1.0 - e2 * np.sin(phi) ** 2)
    return np.stack([(n + altitude) * np.cos(phi) * np.cos(lam),
                     (n + altitude) * np.cos(phi) * np.sin(lam),
                     (n * (1.0 - e2) + altitude) * np.sin(phi)], axis=-1)


def enu_from_geodetic(latitude, longitude, altitude):
    """East, north, up in metres, in the plane that touches the ellipsoid at the first position."""
    ecef = ecef_from_geodetic(latitude, longitude, altitude)
    phi, lam = np.radians(latitude[0]), np.radians(longitude[0])
    enu_from_ecef = np.array([
        [-np.sin(lam), np.cos(lam), 0.0],
        [-np.sin(phi) * np.cos(lam), -np.sin(phi) * np.sin(lam), np.cos(phi)],
        [np.cos(phi) * np.cos(lam), np.cos(phi) * np.sin(lam), np.sin(phi)]])
    return (ecef - ecef[0]) @ enu_from_ecef.T
