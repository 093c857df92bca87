#!/usr/bin/python3
"""What one can ask slam_node for while it runs: services, initialpose and dynamic_reconfigure."""
import math
import os
import re
import sys

import numpy as np
import rospy
import rostest
import yaml
from diagnostic_msgs.msg import DiagnosticStatus
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import PoseWithCovarianceStamped

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

import scenario  # noqa: E402
from slam_case import SlamCase, matrix  # noqa: E402
from waiting import wait_until  # noqa: E402


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


class MapFiles(SlamCase):
    def test_a_saved_map_comes_back(self):
        run = self.start()
        run.drive(2.0)
        saved = run.saved_map()
        self.assertTrue(run.save_map("room.yaml").success)
        run.reset()
        self.assertEqual(run.saved_map()["landmarks"], [])
        reply = run.load_map("room.yaml")
        self.assertTrue(reply.success, reply.message)
        self.assert_same_landmarks(run.saved_map(), saved)

    def test_a_second_node_gets_the_same_map(self):
        run = self.start()
        run.drive(2.0)
        self.assertTrue(run.save_map("room.yaml").success)
        wait_until(lambda: run.map.last.landmarks and run.map.last.landmarks[0].observations == 10, "the map is the newest")
        other = self.start(map_directory=run.map_directory)
        reply = other.load_map("room.yaml")
        self.assertTrue(reply.success, reply.message)
        self.assertNotIn("\n", reply.message)
        self.assert_same_landmarks(other.saved_map(), run.saved_map())
        wait_until(lambda: other.map.last.landmarks == run.map.last.landmarks, "~map shows the loaded landmarks")

    def test_the_present_pose_is_kept_unless_the_saved_one_is_asked_for(self):
        run = self.start()
        run.drive(3.0)
        saved = run.saved_map()
        self.assertTrue(run.save_map("room.yaml").success)
        for keep_saved_pose, expected in ((False, [0.0, 0.0, 0.0]), (True, saved["pose"])):
            other = self.start(map_directory=run.map_directory)
            self.assertTrue(other.load_map("room.yaml", keep_saved_pose).success)
            self.assertEqual(other.saved_map()["pose"], expected)

    def test_sightings_go_on_matching_a_loaded_map(self):
        run = self.start()
        run.drive(2.0)
        self.assertTrue(run.save_map("room.yaml").success)
        other = self.start(map_directory=run.map_directory)
        self.assertTrue(other.load_map("room.yaml").success)
        other.drive(1.0)
        self.assertEqual({item.verdict for item in other.associations.last.associations}, {"matched"})
        self.assertEqual(len(other.saved_map()["landmarks"]), 4)

    def test_without_a_name_the_parameters_file_is_meant(self):
        run = self.start({"map/file_name": "standard.yaml"})
        run.drive(1.0)
        self.assertEqual(run.save_map().message, os.path.join(run.map_directory, "standard.yaml"))
        saved = run.saved_map()
        run.reset()
        self.assertTrue(run.load_map().success)
        self.assert_same_landmarks(run.saved_map(), saved)

    def test_the_file_says_what_it_is(self):
        run = self.start()
        run.drive(1.0)
        saved = run.saved_map()
        self.assertEqual((saved["format"], saved["version"], saved["frame"]), ("kinect_ekf_slam map", 1, "map"))
        self.assertEqual(saved["stamp_ns"], scenario.to_ns(run.associations.last.header.stamp))
        self.assertEqual(yaml.safe_load(saved["parameters"])["sensor"]["max_depth"], 2.6)
        self.assertEqual(len(saved["covariance_lower_triangle"]), 3 + 2 * 4)

    def test_names_that_lead_out_of_the_folder_are_refused(self):
        run = self.start()
        run.drive(1.0)
        outside = os.path.join(run.map_directory, os.pardir, "outside_%d.yaml" % os.getpid())
        os.mkdir(os.path.join(run.map_directory, "folder"))
        os.mkdir(os.path.join(run.map_directory, "folder.yaml"))
        for name in ("../%s" % os.path.basename(outside), "..", os.path.abspath(outside), "folder/map.yaml", "folder.yaml",
                     "map.txt", ".yaml", ".hidden.yaml", "a\\b.yaml"):
            self.assert_refused(run, run.save_map, name)
            self.assert_refused(run, run.load_map, name)
        self.assertFalse(os.path.exists(outside))

    def test_a_link_that_leads_out_of_the_folder_is_refused(self):
        run = self.start()
        run.drive(1.0)
        self.assertTrue(run.save_map("good.yaml").success)
        outside = os.path.join(self.start().map_directory, "outside.yaml")
        write(outside, read(os.path.join(run.map_directory, "good.yaml")))
        text = read(outside)
        os.symlink(outside, os.path.join(run.map_directory, "link.yaml"))
        os.symlink(outside + ".none", os.path.join(run.map_directory, "dangling.yaml"))
        for name in ("link.yaml", "dangling.yaml"):
            self.assert_refused(run, run.save_map, name)
            self.assert_refused(run, run.load_map, name)
        self.assertEqual(read(outside), text)
        self.assertFalse(os.path.exists(outside + ".none"))

    def test_a_file_that_is_no_sound_map_is_refused_and_changes_nothing(self):
        run = self.start()
        run.drive(1.0)
        self.assertTrue(run.save_map("good.yaml").success)
        good = read(os.path.join(run.map_directory, "good.yaml"))
        bad = {
            "empty": "",
            "foreign": "image: room.pgm\nresolution: 0.05\n",
            "no YAML": "landmarks: [}\n",
            "binary": "\x00\x01\x02",
            "cut off": good[:good.index("covariance_lower_triangle") + 40],
            "newer": good.replace("version: 1", "version: 2"),
            "version zero": good.replace("version: 1", "version: 0"),
            "other frame": good.replace('frame: "map"', 'frame: "world"'),
            "other space": good.replace("space: planar", "space: curved"),
            "a position of NaN": re.sub(r"position: \[[^,]*", "position: [.nan", good, count=1),
            "same id twice": good.replace("id: 1,", "id: 0,", 1),
            "covariance not positive": good.replace("covariance_lower_triangle:\n- [", "covariance_lower_triangle:\n- [-"),
            "covariance of NaN": good.replace("covariance_lower_triangle:\n- [", "covariance_lower_triangle:\n- [.nan] #"),
        }
        for kind, text in bad.items():
            self.assertNotEqual(text, good, kind)
            write(os.path.join(run.map_directory, "bad.yaml"), text)
            self.assert_refused(run, run.load_map, "bad.yaml", kind)
        self.assertIn("newer", self.message_of(run, bad["newer"]))
        self.assert_refused(run, run.load_map, "missing.yaml")

    def test_a_map_is_saved_at_the_end_and_loaded_at_the_start_when_asked_for(self):
        run = self.start({"map/save_at_exit": True, "map/file_name": "kept.yaml"})
        run.drive(2.0)
        saved = run.saved_map()
        run.process.stop()
        other = self.start({"map/load_at_start": True, "map/file_name": "kept.yaml"}, map_directory=run.map_directory)
        wait_until(lambda: len(other.map.last.landmarks) == 4, "the loaded map is shown")
        self.assert_same_landmarks(other.saved_map(), saved)

    def test_a_run_that_mapped_nothing_does_not_replace_a_map_at_its_end(self):
        run = self.start()
        run.drive(1.0)
        saved = run.saved_map()
        idle = self.start({"map/save_at_exit": True, "map/file_name": "snapshot_of_the_test.yaml"},
                          map_directory=run.map_directory)
        idle.process.stop()
        with open(os.path.join(run.map_directory, "snapshot_of_the_test.yaml"), encoding="utf-8") as file:
            self.assertEqual(yaml.safe_load(file), saved)

    def test_a_map_is_saved_as_often_as_asked_for(self):
        run = self.start({"map/autosave_period": 0.05, "map/file_name": "kept.yaml"})
        run.drive(2.0)
        saved = run.saved_map()
        kept = os.path.join(run.map_directory, "kept.yaml")
        wait_until(lambda: os.path.exists(kept) and yaml.safe_load(read(kept)) == saved, "the newest map is in the file")
        wait_until(lambda: run.diagnostics("estimate").get("autosave") == "saved", "diagnostics say so")

    def test_no_map_is_saved_unasked(self):
        run = self.start({"map/file_name": "kept.yaml"})
        run.drive(2.0)
        run.process.stop()
        self.assertEqual(os.listdir(run.map_directory), [])

    def test_an_autosave_without_a_landmark_does_not_replace_a_map(self):
        run = self.start()
        run.drive(1.0)
        saved = run.saved_map()
        idle = self.start({"map/autosave_period": 0.05, "map/file_name": "snapshot_of_the_test.yaml"},
                          map_directory=run.map_directory)
        wait_until(lambda: "nothing yet" in idle.diagnostics("estimate").get("autosave", ""), "an autosave came")
        self.assertEqual(yaml.safe_load(read(os.path.join(run.map_directory, "snapshot_of_the_test.yaml"))), saved)

    def test_an_autosave_that_fails_is_told_and_the_node_goes_on(self):
        run = self.start({"map/autosave_period": 0.05, "map/directory": "/proc/kinect_ekf_slam"})
        run.drive(1.0)
        wait_until(lambda: "cannot be created" in run.diagnostics("estimate").get("autosave", ""), "diagnostics say why")
        status = run.diagnostics("estimate")
        self.assertEqual(status["level"], DiagnosticStatus.WARN)
        self.assertIn("the map is not saved: /proc/kinect_ekf_slam/map.yaml", status["message"])
        run.drive(1.0)
        self.assertIn("map/autosave_period: the map is not saved", run.process.said())
        self.assertLess(run.process.said().count("the map is not saved"), 5, "throttled")

    def test_a_folder_that_cannot_be_written_is_told(self):
        run = self.start({"map/directory": "/proc/kinect_ekf_slam"})
        reply = run.save_map("room.yaml")
        self.assertFalse(reply.success)
        self.assert_one_line(reply.message)

    def message_of(self, run, text):
        write(os.path.join(run.map_directory, "bad.yaml"), text)
        return run.load_map("bad.yaml").message

    def assert_refused(self, run, service, name, kind=""):
        """One clear line, and the map is what it was."""
        before = run.saved_map()
        reply = service(name)
        self.assertFalse(reply.success, (kind, name))
        self.assert_one_line(reply.message, kind)
        self.assertIn(os.path.basename(name), reply.message)
        self.assert_same_state(run.saved_map(), before)

    def assert_one_line(self, message, kind=""):
        self.assertTrue(message and message.isprintable() and "\n" not in message, (kind, message))


class Reset(SlamCase):
    def test_reset_forgets_pose_and_map(self):
        run = self.start()
        run.drive(2.0)
        self.assertTrue(run.reset().success)
        self.assertEqual(run.saved_map()["landmarks"], [])
        self.assertEqual(run.saved_map()["pose"], [0.0, 0.0, 0.0])
        wait_until(lambda: not run.map.last.landmarks, "~map is empty")

    def test_a_new_run_after_a_reset_is_like_the_first(self):
        start = scenario.SECOND * 1700000000
        run = self.start(start=start)
        run.drive(2.0)
        first = run.saved_map()
        run.reset()
        run.scenario = scenario.Scenario(start + 10 * scenario.SECOND)
        run.drive(2.0)
        second = run.saved_map()
        self.assertEqual(second["pose"], first["pose"])
        self.assert_same_landmarks(second, first)


class Pause(SlamCase):
    def test_while_paused_detections_are_not_used_and_odometry_moves_the_pose(self):
        run = self.start()
        run.drive(1.0)
        before, pose = run.saved_map(), run.pose_in_map()
        self.assertTrue(run.pause(True).success)
        run.drive(2.0, expect_use=False)
        self.assertGreater(run.pose_in_map()[0], pose[0] + 0.3)
        self.assert_same_landmarks(run.saved_map(), before)
        wait_until(lambda: run.diagnostics("estimate").get("paused") == "yes", "diagnostics say so")
        self.assertTrue(run.pause(False).success)
        run.drive(1.0)
        self.assertGreater(run.saved_map()["landmarks"][0]["observations"], before["landmarks"][0]["observations"])


class Modes(SlamCase):
    def test_a_mode_that_does_not_exist_is_refused_with_what_is_allowed(self):
        run = self.start()
        for mode in ("mapping", "", "SLAM"):
            reply = run.set_mode(mode)
            self.assertFalse(reply.success)
            self.assertIn("'%s'" % mode, reply.message)
            self.assertIn("slam, localization", reply.message)
        wait_until(lambda: run.diagnostics("estimate").get("mode") == "slam", "the mode is what it was")

    def test_localization_in_an_empty_map_is_refused(self):
        run = self.start()
        reply = run.set_mode("localization")
        self.assertFalse(reply.success)
        self.assertIn("map", reply.message)
        run.drive(1.0)
        self.assertEqual(len(run.saved_map()["landmarks"]), 4)

    def test_localization_corrects_the_pose_and_leaves_the_map_to_the_last_bit(self):
        run = self.start()
        run.drive(2.0)
        self.assertTrue(run.set_mode("localization").success)
        before = run.saved_map()
        run.scenario.odometry_scale = 0.7
        run.drive(4.0)
        step = run.scenario.step()
        run.send(step)
        self.assert_same_landmarks(run.saved_map(), before)
        self.assertGreater(abs(run.scenario.pose_in_odom[0] - step.pose[0]), 0.2)
        self.assert_pose_near(run.pose_in_map(), step.pose, 0.06)

    def test_localization_takes_in_no_new_landmark(self):
        run = self.start(landmarks={7: scenario.LANDMARKS[7], 3: scenario.LANDMARKS[3]})
        run.drive(1.0)
        self.assertTrue(run.set_mode("localization").success)
        before = run.saved_map()
        run.scenario.landmarks = dict(scenario.LANDMARKS)
        run.drive(1.0)
        verdicts = {item.source_id: item.verdict for item in run.associations.last.associations}
        self.assertEqual(verdicts, {7: "matched", 3: "matched", 12: "not_in_map", 5: "not_in_map"})
        self.assert_same_landmarks(run.saved_map(), before)

    def test_reset_keeps_the_map_of_localization(self):
        run = self.start()
        run.drive(1.0)
        self.assertTrue(run.set_mode("localization").success)
        before = run.saved_map()
        run.reset()
        self.assert_same_landmarks(run.saved_map(), before)
        wait_until(lambda: len(run.map.last.landmarks) == 4, "~map shows it")

    def test_back_in_slam_the_map_goes_on(self):
        run = self.start()
        run.drive(1.0)
        self.assertTrue(run.set_mode("localization").success)
        before = run.saved_map()
        self.assertTrue(run.set_mode("slam").success)
        run.drive(1.0)
        self.assertGreater(run.saved_map()["landmarks"][0]["observations"], before["landmarks"][0]["observations"])

    def test_a_node_may_start_in_localization_with_a_saved_map(self):
        run = self.start()
        run.drive(2.0)
        self.assertTrue(run.save_map("map.yaml").success)
        other = self.start({"mode": "localization", "map/load_at_start": True}, map_directory=run.map_directory,
                           odometry_scale=0.8)
        before = other.saved_map()
        self.assertEqual(before["landmarks"], run.saved_map()["landmarks"])
        other.drive(3.0)
        step = other.scenario.step()
        other.send(step)
        self.assert_same_landmarks(other.saved_map(), before)
        self.assert_pose_near(other.pose_in_map(), step.pose, 0.06)


class InitialPose(SlamCase):
    """`initialpose` as RViz sends it."""

    RVIZ_COVARIANCE = np.diag([0.25, 0.25, 0.0, 0.0, 0.0, 0.0685])

    def message(self, pose=(1.0, 2.0, 0.5), frame="map", covariance=RVIZ_COVARIANCE):
        message = PoseWithCovarianceStamped()
        message.header.frame_id = frame
        message.header.stamp = rospy.Time.now()
        scenario.set_pose(message.pose.pose, pose)
        message.pose.covariance = covariance.ravel().tolist()
        return message

    @staticmethod
    def refused(run):
        """How many diagnostics have counted."""
        return sum(int(count) for key, count in run.diagnostics("inputs").items() if key.startswith("refused, initialpose"))

    def pose_after(self, run, message):
        """Where the robot is when the node has taken the message or has said why not."""
        refused = self.refused(run)
        markers = len(run.markers.messages)

        def is_settled():
            moved = any(marker.ns == "robot_position" and marker.pose.position.x > 0.9
                        for array in run.markers.messages[markers:] for marker in array.markers)
            return moved or self.refused(run) > refused

        run.publish("initialpose", message)
        wait_until(is_settled, "the pose was taken or refused")
        run.drive(0.1, look=False)
        return run.pose_in_map()

    def test_it_moves_the_pose(self):
        run = self.start(speed=0.0, turn=0.0)
        run.drive(0.4, look=False)
        self.assert_pose_near(self.pose_after(run, self.message()), (1.0, 2.0, 0.5), 1e-6)
        covariance = matrix(run.pose.last.pose.covariance)
        np.testing.assert_allclose(np.diag(covariance)[[0, 1, 5]], [0.25, 0.25, 0.0685], rtol=1e-6)
        self.assert_is_covariance(run.pose.last.pose.covariance)

    def test_it_keeps_the_map(self):
        run = self.start(speed=0.0, turn=0.0)
        run.drive(1.0)
        before = run.saved_map()
        self.pose_after(run, self.message())
        self.assert_same_landmarks(run.saved_map(), before)

    def test_it_also_works_before_the_first_odometry(self):
        run = self.start(speed=0.0, turn=0.0)
        self.assert_pose_near(self.pose_after(run, self.message()), (1.0, 2.0, 0.5), 1e-6)

    def test_a_covariance_of_zero_is_not_taken_for_certainty(self):
        run = self.start(speed=0.0, turn=0.0)
        run.drive(0.4, look=False)
        self.assert_pose_near(self.pose_after(run, self.message(covariance=np.zeros((6, 6)))), (1.0, 2.0, 0.5), 1e-6)
        self.assertGreater(min(np.diag(matrix(run.pose.last.pose.covariance))[[0, 1, 5]]), 0.01)

    def test_a_slash_before_its_frame_changes_nothing(self):
        run = self.start(speed=0.0, turn=0.0)
        run.drive(0.4, look=False)
        self.assert_pose_near(self.pose_after(run, self.message(frame="/map")), (1.0, 2.0, 0.5), 1e-6)

    def test_a_pose_in_another_frame_is_ignored(self):
        for frame in ("odom", "", "world"):
            self.assert_ignored(self.message(frame=frame))

    def test_a_pose_that_is_not_finite_is_ignored(self):
        self.assert_ignored(self.message(pose=(math.nan, 2.0, 0.5)))
        turned_nowhere = self.message()
        turned_nowhere.pose.pose.orientation.z = math.nan
        self.assert_ignored(turned_nowhere)

    def test_a_pose_beyond_all_places_is_ignored(self):
        self.assert_ignored(self.message(pose=(1e200, 2.0, 0.5)))
        message = self.message()
        message.pose.pose.orientation.w = 1e200
        self.assert_ignored(message)

    def test_a_pose_without_an_orientation_is_ignored(self):
        message = self.message()
        message.pose.pose.orientation.z = message.pose.pose.orientation.w = 0.0
        self.assert_ignored(message)

    def test_a_covariance_that_is_none_is_ignored(self):
        correlated = self.RVIZ_COVARIANCE.copy()
        correlated[0, 1] = correlated[1, 0] = 1.0  # correlation 4
        for covariance in (self.RVIZ_COVARIANCE * math.nan, -self.RVIZ_COVARIANCE, np.diag([0.25, 0, 0, 0, 0, 0]), correlated):
            self.assert_ignored(self.message(covariance=covariance))

    def assert_ignored(self, message):
        run = self.start(speed=0.0, turn=0.0)
        run.drive(0.4, look=False)
        self.assert_pose_near(self.pose_after(run, message), (0.0, 0.0, 0.0), 1e-6)
        self.assertLess(matrix(run.pose.last.pose.covariance)[0, 0], 0.01)


class LiveParameters(SlamCase):
    def client(self, run):
        client = Client(run.process.name + "/live", timeout=30)
        self.addCleanup(client.close)
        return client

    def test_sensor_max_depth_takes_effect_and_keeps_the_map(self):
        run = self.start(speed=0.0, turn=0.0)
        run.drive(1.0)
        before = run.saved_map()
        self.client(run).update_configuration({"sensor_max_depth": 1.9})
        self.assert_same_state(run.saved_map(), before)
        run.drive(0.2)
        verdicts = {item.source_id: item.verdict for item in run.associations.last.associations}
        self.assertEqual(verdicts, {7: "matched", 3: "matched", 12: "out_of_range", 5: "matched"})
        self.assertEqual(len(run.saved_map()["landmarks"]), 4)

    def test_they_start_with_what_the_parameters_say(self):
        run = self.start({"sensor/max_depth": 3.25, "output/marker_sigmas": 2.0})
        present = self.client(run).get_configuration(timeout=30)
        self.assertEqual((present["sensor_max_depth"], present["output_marker_sigmas"]), (3.25, 2.0))

    def test_a_change_survives_a_reset(self):
        run = self.start(speed=0.0, turn=0.0)
        self.client(run).update_configuration({"sensor_max_depth": 1.9})
        run.reset()
        run.drive(0.2)
        self.assertIn("out_of_range", {item.verdict for item in run.associations.last.associations})

    def test_a_value_that_is_no_number_does_not_stay_in_the_way(self):
        run = self.start()
        client = self.client(run)
        present = client.update_configuration({"sensor_max_depth": math.nan})
        self.assertEqual(present["sensor_max_depth"], 2.6)
        client.update_configuration({"output_marker_sigmas": 2.0})
        run.drive(0.2)
        self.assertEqual(run.process.said().count("not finite"), 1, run.process.said())

    def test_depths_that_leave_nothing_to_see_are_refused(self):
        run = self.start(speed=0.0, turn=0.0)
        present = self.client(run).update_configuration({"sensor_min_depth": 2.0, "sensor_max_depth": 1.0})
        self.assertEqual((present["sensor_min_depth"], present["sensor_max_depth"]), (0.6, 2.6))
        run.drive(0.2)
        self.assertEqual({item.verdict for item in run.associations.last.associations}, {"created"})

    def test_changing_one_leaves_the_others(self):
        # A camera that looks back: the parameter file allows a depth below zero.
        run = self.start({"sensor/min_depth": -3.0}, speed=0.0, turn=0.0, landmarks={1: ("red", -1.0, 0.5)})
        run.drive(0.4)
        self.client(run).update_configuration({"output_marker_sigmas": 2.0})
        run.drive(0.2)
        self.assertEqual([item.verdict for item in run.associations.last.associations], ["matched"])


if __name__ == "__main__":
    rospy.init_node("test_services")
    rostest.rosrun("kinect_ekf_slam", "test_services", "test_services")
