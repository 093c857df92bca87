"""Upright cylinders in a planar laser scan: segments, circle fits, and checks that refuse the rest."""
from dataclasses import dataclass

import numpy as np

GRAZING_COSINE = 0.3   # where a ray grazes the surface, its residual is no longer linear in the range


@dataclass(frozen=True)
class CylinderModel:
    """What counts as a cylinder. Lengths in m, angles in rad."""
    radius_min: float = 0.10
    radius_max: float = 0.20
    range_std: float = 0.01          # of the scanner
    jump: float = 0.15               # between neighbouring ranges: another surface
    points_min: int = 5
    arc_min: float = np.radians(90)  # as seen from the axis
    misfit_max: float = 3.0          # mean squared residual, in units of the range variance

    @property
    def radius_mean(self):
        return 0.5 * (self.radius_min + self.radius_max)

    @property
    def radius_std(self):
        """The bounds are two standard deviations of what is known of the radius beforehand."""
        return 0.25 * (self.radius_max - self.radius_min)


@dataclass(frozen=True)
class Circle:
    """A fitted circle. covariance: of centre x, centre y and radius; chi_square: of the radial residuals."""
    center: np.ndarray
    radius: float
    covariance: np.ndarray
    chi_square: float


def fit_circle(points, model):
    """The circle with the least squared weighted residuals; None when it does not converge.

    Starts at the algebraic fit (Kasa, IEEE Trans. Instrum. Meas. 25(1), 1976) and refines by Gauss-Newton.
    Residuals are radial. The scanner, at the origin, errs along its rays, so a point's residual varies as the
    cosine of the ray's incidence. The knowledge of the radius enters as one more residual: a short arc
    determines its radius, and with it the distance of the axis, badly.
    """
    mean = points.mean(axis=0)
    x, y = (points - mean).T
    design = np.column_stack([2 * x, 2 * y, np.ones_like(x)])
    algebraic = np.linalg.lstsq(design, x * x + y * y, rcond=None)[0]
    radius = np.sqrt(max(algebraic[2] + algebraic[0]**2 + algebraic[1]**2, 0.0))
    center = mean + algebraic[:2]
    if not model.radius_min <= radius <= model.radius_max:   # start behind the surface that the scanner sees
        radius = model.radius_mean
        center = mean * (1.0 + radius / max(np.linalg.norm(mean), 1e-9))
    state = np.append(center, radius)
    rays = points / np.linalg.norm(points, axis=1, keepdims=True)
    for _ in range(50):
        offsets = points - state[:2]
        distances = np.maximum(np.linalg.norm(offsets, axis=1), 1e-9)
        cosines = np.abs(np.sum(offsets * rays, axis=1)) / distances
        weights = 1.0 / np.append(model.range_std * np.maximum(cosines, GRAZING_COSINE), model.radius_std)
        residuals = np.append(distances - state[2], state[2] - model.radius_mean) * weights
        jacobian = np.column_stack([-offsets / distances[:, None], -np.ones(len(points))])
        jacobian = np.vstack([jacobian, [0.0, 0.0, 1.0]]) * weights[:, None]
        step, _, rank, _ = np.linalg.lstsq(jacobian, -residuals, rcond=1e-9)
        state = state + step
        if rank < 3 or not np.isfinite(state).all() or np.linalg.norm(step) > 10.0:
            return None
        if np.linalg.norm(step) < 1e-7:
            return Circle(state[:2], float(state[2]), np.linalg.inv(jacobian.T @ jacobian),
                          float(np.sum(residuals[:-1]**2)))
    return None


def split_scan(ranges, valid, jump, full_turn):
    """Runs of neighbouring valid rays without a jump, as index arrays in the order of the rays.

    full_turn: the last ray is the neighbour of the first one.
    """
    count = len(ranges)
    ranges = np.where(valid, ranges, np.inf)
    if not valid.any():
        return []
    after = np.roll(ranges, -1)
    with np.errstate(invalid="ignore"):
        breaks = ~(valid & np.roll(valid, -1)) | ~(np.abs(after - ranges) <= jump)
    if not full_turn:
        breaks[-1] = True
    if not breaks.any():
        return [np.arange(count)]
    first = int(np.argmax(breaks)) + 1
    order = (np.arange(count) + first) % count
    segments = np.split(order, np.flatnonzero(breaks[order])[:-1] + 1)
    return [segment for segment in segments if valid[segment].all()]


def stands_free(segment, ranges, full_turn):
    """Beyond both ends there is something farther, or nothing: no nearer object hides a part of this one."""
    count = len(ranges)
    for end, neighbour in ((segment[0], segment[0] - 1), (segment[-1], segment[-1] + 1)):
        if not full_turn and not 0 <= neighbour < count:
            return False   # cut by the border of the scan
        if ranges[neighbour % count] < ranges[end]:
            return False
    return True


def find_cylinders(ranges, angle_min, angle_increment, range_min, range_max, model):
    """Circles of the cylinders in a scan, in the scanner's frame."""
    ranges = np.asarray(ranges, dtype=float)
    angles = angle_min + angle_increment * np.arange(len(ranges))
    full_turn = (len(ranges) + 0.5) * abs(angle_increment) >= 2.0 * np.pi
    valid = np.isfinite(ranges) & (ranges >= range_min) & (ranges <= range_max)
    background = np.where(valid, ranges, np.inf)
    background[ranges < range_min] = 0.0   # too near hides, too far does not
    cylinders = []
    for segment in split_scan(ranges, valid, model.jump, full_turn):
        if len(segment) < model.points_min or not stands_free(segment, background, full_turn):
            continue
        distance = ranges[segment]
        points = np.column_stack([distance * np.cos(angles[segment]), distance * np.sin(angles[segment])])
        if np.ptp(points, axis=0).max() > 2.0 * model.radius_max + 6.0 * model.range_std:
            continue
        circle = fit_circle(points, model)
        if circle is not None and is_cylinder(circle, points, range_max, model):
            cylinders.append(circle)
    return cylinders


def is_cylinder(circle, points, range_max, model):
    """Whether a fitted circle is one: size, side seen, length of the arc, residuals.

    A straight wall fits only circles that are large for it: it fails by the length of the arc.
    """
    center_range = np.linalg.norm(circle.center)
    if not model.radius_min <= circle.radius <= model.radius_max:
        return False
    if center_range + circle.radius > range_max:
        return False   # partly out of range: the ends of the arc may be the scanner's, not the object's
    if np.linalg.norm(points, axis=1).mean() > center_range:
        return False   # hollow side: a corner of walls
    toward_scanner = -circle.center / center_range
    offsets = points - circle.center
    bearing = np.arctan2(toward_scanner[0] * offsets[:, 1] - toward_scanner[1] * offsets[:, 0],
                         offsets @ toward_scanner)
    if np.ptp(bearing) < model.arc_min:
        return False
    return circle.chi_square <= model.misfit_max * len(points)
