"""Detections in other packages' messages as ours. The messages come as objects; none of those packages is imported."""
import math


def _of_pose_array(message):
    return [(-1, pose.position, None) for pose in message.poses]


def _of_fiducial_transforms(message):
    return [(fiducial.fiducial_id, fiducial.transform.translation, None) for fiducial in message.transforms]


def _of_april_tags(message):
    """A bundle goes by the lowest identity of its tags; what has none is not known."""
    return [(min(tag.id, default=-1), tag.pose.pose.pose.position, tag.pose.pose.covariance) for tag in message.detections]


# Of a message, for each detection: identity or -1, place in the message's frame, 36 numbers of covariance or None.
READERS = {
    "geometry_msgs/PoseArray": _of_pose_array,
    "fiducial_msgs/FiducialTransformArray": _of_fiducial_transforms,
    "apriltag_ros/AprilTagDetectionArray": _of_april_tags,
}


def position_covariance(covariance, sigma):
    """9 numbers, m^2: of a pose's 36 if they say something, else of `sigma`; all zero: the sensor model is to be used."""
    if covariance is not None:
        block = [covariance[6 * row + column] for row in range(3) for column in range(3)]
        if all(map(math.isfinite, block)) and min(block[0], block[4], block[8]) > 0.0:
            return block
    return [sigma * sigma if row == column else 0.0 for row in range(3) for column in range(3)]


def convert(kind, message, messages, label="", sigma=0.0):
    """A message of the type `kind` as a LandmarkDetectionArray of `messages` (the module kinect_ekf_slam.msg).

    An empty message becomes an empty array: it was looked, and nothing seen.
    """
    array = messages.LandmarkDetectionArray()
    array.header.stamp, array.header.frame_id = message.header.stamp, message.header.frame_id
    for identity, place, covariance in READERS[kind](message):
        detection = messages.LandmarkDetection(id=identity, label=label, score=1.0)
        detection.position.x, detection.position.y, detection.position.z = place.x, place.y, place.z
        detection.covariance = position_covariance(covariance, sigma)
        array.detections.append(detection)
    return array
