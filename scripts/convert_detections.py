#!/usr/bin/python3
"""A node that publishes other packages' detections as kinect_ekf_slam/LandmarkDetectionArray on `landmarks`.

  rosrun kinect_ekf_slam convert_detections.py detections:=/tag_detections

It reads from the topic `detections`, of any of these types: geometry_msgs/PoseArray (places without identity),
fiducial_msgs/FiducialTransformArray (aruco_detect), apriltag_ros/AprilTagDetectionArray. None of these packages needs to
be installed here: what a message looks like is learnt from its publisher. Identities are obeyed with association/type: known.

Parameters: ~label (text, default empty) of every detection; ~sigma (m, default 0): standard deviation on each axis where
the message tells no covariance, 0: slam_node's sensor model.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from slam_tools.environment import package_messages, use_system_python  # noqa: E402

use_system_python()

import genpy  # noqa: E402
import genpy.dynamic  # noqa: E402
import rospy  # noqa: E402

from slam_tools.foreign_detections import READERS, convert  # noqa: E402


class Converter:
    def __init__(self):
        self._label = rospy.get_param("~label", "")
        self._sigma = rospy.get_param("~sigma", 0.0)
        if not isinstance(self._sigma, (int, float)) or not 0.0 <= self._sigma < 100.0:
            sys.exit(f"convert_detections.py: ~sigma: '{self._sigma}' given, allowed: from 0 to 100 m")
        self._messages = package_messages()
        self._classes = {}   # by type and checksum
        self._publisher = rospy.Publisher("landmarks", self._messages.LandmarkDetectionArray, queue_size=10)
        self._subscriber = rospy.Subscriber("detections", rospy.AnyMsg, self._on_message, queue_size=10)

    def _on_message(self, raw):
        kind = raw._connection_header["type"]
        if kind not in READERS:
            rospy.logwarn_throttle(10.0, "%s: %s cannot be converted, allowed: %s", self._subscriber.resolved_name, kind,
                                   ", ".join(READERS))
            return
        try:
            message = self._class_of(kind, raw._connection_header)().deserialize(raw._buff)
            self._publisher.publish(convert(kind, message, self._messages, self._label, self._sigma))
        except (genpy.DeserializationError, AttributeError) as error:
            rospy.logwarn_throttle(10.0, "%s: a message is not what %s should be: %s", self._subscriber.resolved_name, kind, error)

    def _class_of(self, kind, header):
        key = kind, header["md5sum"]
        if key not in self._classes:
            self._classes[key] = genpy.dynamic.generate_dynamic(kind, header["message_definition"])[kind]
        return self._classes[key]


def main():
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__)
        return
    rospy.init_node("convert_detections")
    Converter()
    rospy.spin()


if __name__ == "__main__":
    main()
