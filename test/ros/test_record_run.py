#!/usr/bin/python3
"""A recorded live run is read as one of slam_replay, and says what it was run with."""
import os
import sys
import tempfile

import rospy
import rostest
from dynamic_reconfigure.client import Client

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

from node_process import ROOT  # noqa: E402
from slam_case import SlamCase  # noqa: E402
from waiting import wait_until  # noqa: E402

sys.path.insert(0, os.path.join(ROOT, "scripts"))

from slam_tools.live import LiveRun  # noqa: E402
from slam_tools.provenance import read_provenance  # noqa: E402
from slam_tools.runs import read_estimate  # noqa: E402


class RecordRun(SlamCase):
    def record(self, overrides=None, drive=None, warning=None):
        """The folder that a run of some seconds was recorded to, until it was warned of something."""
        run = self.start(overrides)
        live = LiveRun(run.process.name, run.namespace + "/odom")
        self.addCleanup(live.close)
        wait_until(live.is_connected, "the recorder hears everything")
        (drive or (lambda _: None))(run)
        run.drive(3.0)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)

        def is_complete():
            live.write(folder.name)
            estimate = read_estimate(folder.name)
            return (estimate.path.stamps[-1] >= run.pose_stamp() * 1e-9 - 1e-6 and len(estimate.landmarks) == 4
                    and (warning is None or warning in read_provenance(folder.name).summary["warnings"]))

        wait_until(is_complete, "the recorder has heard it all")
        return folder.name

    def test_reads_as_a_run(self):
        folder = self.record()
        estimate = read_estimate(folder)
        self.assertGreater(len(estimate.path), 25)
        self.assertEqual(len(estimate.covariances), len(estimate.path))
        self.assertEqual(sorted(estimate.landmarks.labels), ["blue", "green", "red", "yellow"])
        self.assertTrue(estimate.associations.accepted.any())

    def test_says_what_it_was_run_with(self):
        def change(run):
            Client(run.process.name + "/live", timeout=30).update_configuration(
                {"sensor_max_depth": 3.5, "motion_gyro_noise": 0.125})

        folder = self.record({"association/type": "known", "motion/noise": "proportional"}, change)
        provenance = read_provenance(folder)
        self.assertEqual(provenance.parameters["association/type"], "known")
        self.assertEqual(provenance.parameters["sensor/max_depth"], "3.5")      # listed, then changed
        self.assertEqual(provenance.parameters["motion/gyro_noise"], "0.125")   # not listed, then changed
        self.assertNotIn("motion/linear_noise", provenance.parameters)          # neither
        self.assertEqual([name for name in provenance.parameters if name.startswith("live")], [])
        self.assertRegex(provenance.summary["versions"]["kinect_ekf_slam"], r"^\d+\.\d+\.\d+$")
        self.assertRegex(provenance.summary["finished"], r"^20\d\d-\d\d-\d\dT")

    def test_says_what_the_node_warned_of(self):
        warning = "the position is uncertain"
        folder = self.record({"output/pose_sigma_warning": 1e-6}, warning=warning)
        self.assertIn(warning, read_provenance(folder).summary["warnings"])


if __name__ == "__main__":
    rospy.init_node("test_record_run")
    rostest.rosrun("kinect_ekf_slam", "record_run", RecordRun)
