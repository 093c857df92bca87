"""Which estimated landmark is which true one."""
import numpy as np

from .geometry import RigidTransform

MATCH_DISTANCE_MAX = 0.5       # m, between landmarks that are matched by position


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
