"""A run whose errors are known exactly, as files, and its truth as a bag."""
import math
import os
import tempfile
import unittest

import support
import numpy as np

from slam_tools.bags import BagWriter, fill_pose, time_from_nanoseconds
from slam_tools.geometry import RigidTransform, quaternion_from_yaw

COVARIANCE_HEADER = ("t,cxx,cxy,cxz,cxr,cxp,cxw,cyy,cyz,cyr,cyp,cyw,czz,czr,czp,czw,"
                     "crr,crp,crw,cpp,cpw,cww\n")
LANDMARK_HEADER = "id,label,x,y,z,cxx,cxy,cxz,cyy,cyz,czz,observations\n"
ASSOCIATION_HEADER = "t,detection,source_id,verdict,landmark,nis\n"


class StraightRun(unittest.TestCase):
    """A straight run of 40 s in a frame of its own. Errors are such that the best alignment undoes exactly
    the frame: position errors of 0.1 m to both sides of the path with no mean and no slope, landmarks spread
    by 0.05 m."""

    MOTION = RigidTransform.planar(5.0, -3.0, 0.8)   # from the frame of the estimate to that of the truth
    ALONG_STD, ACROSS_STD, YAW_STD, YAW_ERROR = 0.2, 0.05, 0.02, 0.03
    START = 1000.0

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = os.path.join(temporary.name, "run")
        os.mkdir(self.folder)
        self.bag = os.path.join(temporary.name, "truth.bag")
        self.write_truth()
        self.write_estimate()

    def write_truth(self, with_path=True, with_landmarks=True, fix_only=False, positions_with_outliers=False,
                    size=1.0):
        """size: what the positions are multiplied with."""
        from geometry_msgs.msg import PoseStamped
        from sensor_msgs.msg import NavSatFix
        from slam_tools.environment import package_messages
        messages = package_messages()
        with BagWriter(self.bag) as bag:
            start = time_from_nanoseconds(self.START * 1e9)
            if with_landmarks:
                message = messages.LandmarkMap()
                places = {21: (-3, -3), 22: (3, -3), 23: (3, 3), 24: (-3, 3), 25: (40, 40)}
                for identity, (x, y) in places.items():
                    landmark = messages.Landmark(id=identity, source_id=identity)
                    position = size * self.MOTION.points(np.array([x, y, 0.0]))
                    landmark.position.x, landmark.position.y = position[:2]
                    message.landmarks.append(landmark)
                bag.write("/ground_truth/landmarks", message, start, latched=True)
            for i in range(401 if with_path else 0):
                stamp = time_from_nanoseconds((self.START + 0.1 * i) * 1e9)
                position = size * self.MOTION.points(np.array([0.05 * i - 10.0, 0.0, 0.0]))
                if fix_only:
                    fix = NavSatFix(latitude=45.0 + np.degrees(position[1] / 6367381.8), altitude=0.0,
                                    longitude=7.0 + np.degrees(position[0] / 6388838.3 * math.sqrt(2.0)))
                    fix.header.stamp = stamp
                    bag.write("/fix", fix, stamp)
                else:
                    pose = PoseStamped()
                    pose.header.stamp = stamp
                    fill_pose(pose.pose, position, quaternion_from_yaw(0.8))
                    if positions_with_outliers:
                        fill_pose(pose.pose, position + (20.0 if i % 40 == 5 else 0.0), np.zeros(4))
                    bag.write("/ground_truth/pose", pose, stamp)

    def write_estimate(self):
        """Every 0.1 s, between the stamps of the truth; the signs have neither mean nor slope."""
        signs = np.tile([1, -1, -1, 1], 100)
        stamps = self.START + 0.05 + 0.1 * np.arange(400)
        x = 0.05 * (np.arange(400) + 0.5) - 10.0
        support.write(self.folder, "trajectory.tum", "".join(
            support.tum_line(t, px, 0.1 * s, self.YAW_ERROR) for t, px, s in zip(stamps, x, signs)))
        row = ["0"] * 21
        row[0], row[6], row[20] = repr(self.ALONG_STD**2), repr(self.ACROSS_STD**2), repr(self.YAW_STD**2)
        support.write(self.folder, "trajectory_covariance.csv",
                      COVARIANCE_HEADER + "".join(f"{t:.9f},{','.join(row)}\n" for t in stamps))
        support.write(self.folder, "dead_reckoning.tum", "".join(
            support.tum_line(t, px, 0.4 * s, 0.0) for t, px, s in zip(stamps, x, signs)))
        places = [(-3.05, -3.05), (3.05, -3.05), (3.05, 3.05), (-3.05, 3.05), (2.0, 2.0)]
        support.write(self.folder, "landmarks.csv", LANDMARK_HEADER + "".join(
            f"{i},red,{x},{y},0,0.01,0,0,0.02,0,0,{10 if i < 4 else 1}\n" for i, (x, y) in enumerate(places)))
        support.write(self.folder, "associations.csv", ASSOCIATION_HEADER + "".join(
            f"1000.1,0,{identity},{verdict},{landmark},{nis}\n" for identity, verdict, landmark, nis in [
                (21, "created", 0, ""), (22, "created", 1, ""),
                (23, "created", 2, "nan"), (24, "created", 3, ""),
                (21, "matched", 0, 0.5), (22, "matched", 1, 0.5), (23, "matched", 2, 2.5),
                (22, "matched", 0, 6.0),        # wrong
                (23, "created", 4, ""),         # a second landmark of the same thing: wrong
                (24, "gate", 3, 20.0),          # refused: does not count
                (-1, "matched", 3, 0.5)]))      # unknown: does not count
        support.write(self.folder, "associations_instant.csv", ASSOCIATION_HEADER + "".join(
            f"1000.1,0,{identity},{verdict},{landmark},\n" for identity, verdict, landmark in [
                (21, "created", 0), (22, "matched", 1), (23, "matched", 1), (24, "gate", -1)]))
