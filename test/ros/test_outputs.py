#!/usr/bin/python3
"""What slam_node publishes: topics, tf, markers and diagnostics of a run without trouble."""
import math
import os
import sys

import numpy as np
import rospy
import rostest
from kinect_ekf_slam.msg import Landmark
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), os.pardir, "support"))

import scenario  # noqa: E402
from slam_case import SlamCase, matrix  # noqa: E402
from node_process import Recorder  # noqa: E402
from waiting import wait_until  # noqa: E402

TRUE_POSITIONS = {identity: (x, y) for identity, (_, x, y) in scenario.LANDMARKS.items()}


def positions(landmarks):
    """{source identity: (x, y)} of a LandmarkMap's landmarks."""
    return {landmark.source_id: (landmark.position.x, landmark.position.y) for landmark in landmarks}


class Positions(SlamCase):
    def test_global_ones_place_the_map_in_their_frame(self):
        run = self.start({"fusion/align_heading_sigma_deg": 20.0})
        static = Recorder(run.namespace + "/tf_static", TFMessage)
        for _ in range(40):
            step = run.scenario.step()
            step.detections = None
            x, y = 100.0 - step.pose[1], 50.0 + step.pose[0]  # the map's x is their y
            run.publish("global_position", scenario.position_message(step.stamp, x, y, "earth"))
            run.send(step)
        earth_to_map = wait_until(
            lambda: next((transform for message in static.messages for transform in message.transforms
                          if (transform.header.frame_id, transform.child_frame_id) == ("earth", "map")), None),
            lambda: "tf earth -> map; diagnostics: %s" % run.diagnostics("estimate"))
        translation = earth_to_map.transform.translation
        self.assertAlmostEqual(translation.x, 100.0, delta=0.05)
        self.assertAlmostEqual(translation.y, 50.0, delta=0.05)
        self.assertAlmostEqual(scenario.heading_of(earth_to_map.transform.rotation), 0.5 * math.pi, delta=0.1)
        run.wait_for_count("estimate", "positions and ranges, used")
        self.assertEqual(run.diagnostics("estimate")["map placed in the frame of global positions"], "yes")
        static.close()


class Pose(SlamCase):
    def test_pose_is_in_the_map_frame_and_follows_the_robot(self):
        run = self.start()
        run.drive(3.0)
        self.assertEqual(run.pose.last.header.frame_id, "map")
        step = run.scenario.step()
        run.send(step)
        self.assert_pose_near(run.pose_in_map(), step.pose, 1e-6)

    def test_covariance_is_symmetric_and_positive_and_never_claims_a_certain_height(self):
        run = self.start()
        run.drive(2.0)
        for message in run.pose.messages:
            self.assert_is_covariance(message.pose.covariance)
            self.assertGreater(min(np.diag(matrix(message.pose.covariance))[2:5]), 1e-6)  # z, roll, pitch

    def test_pose_moves_with_odometry_before_the_first_landmark(self):
        run = self.start()
        run.drive(2.0, look=False)
        step = run.scenario.step()
        run.send(step)
        self.assertGreater(step.pose[0], 0.35)
        self.assert_pose_near(run.pose_in_map(), step.pose, 1e-6)

    def test_sightings_correct_the_pose(self):
        run = self.start(odometry_scale=0.85)
        run.drive(4.0)
        step = run.scenario.step()
        run.send(step)
        dead_reckoned = math.hypot(run.scenario.pose_in_odom[0] - step.pose[0], run.scenario.pose_in_odom[1] - step.pose[1])
        self.assertGreater(dead_reckoned, 0.1)
        self.assert_pose_near(run.pose_in_map(), step.pose, 0.3 * dead_reckoned)

    def test_dead_reckoning_is_not_corrected_by_sightings(self):
        run = self.start({"estimator/type": "dead_reckoning"}, odometry_scale=0.85)
        run.drive(3.0)
        expected = run.scenario.pose_in_odom
        run.send(run.scenario.step())
        self.assert_pose_near(run.pose_in_map(), expected, 1e-6)
        wait_until(lambda: len(run.map.last.landmarks) == 4, "the landmarks were plotted")

    def test_odometry_repeats_the_pose_with_the_velocity_in_the_base_frame(self):
        run = self.start()
        run.drive(1.0)
        stamp = run.pose_stamp()
        wait_until(lambda: scenario.to_ns(run.odometry.last.header.stamp) == stamp, "~odometry came")
        self.assertEqual((run.odometry.last.header.frame_id, run.odometry.last.child_frame_id), ("map", scenario.BASE))
        self.assertEqual(run.odometry.last.pose, run.pose.last.pose)
        self.assertAlmostEqual(run.odometry.last.twist.twist.linear.x, 0.2)

    def test_path_grows_in_the_map_frame(self):
        run = self.start({"output/path_step": 0.05})
        run.drive(3.0)
        wait_until(lambda: run.path.last and len(run.path.last.poses) >= 10, "the path has a pose each 0.05 m or more of 0.6 m")
        self.assertEqual(run.path.last.header.frame_id, "map")
        x = [pose.pose.position.x for pose in run.path.last.poses]
        self.assertGreaterEqual(min(np.diff(x)), 0.045)


class Imu(SlamCase):
    def test_an_imu_on_its_side_turns_the_robot_through_tf(self):
        run = self.start(turn=0.3, odometry_turn_scale=0.0, with_imu=True)
        run.drive(3.0, look=False)
        step = run.scenario.step()
        run.send(step)
        self.assert_pose_near(run.pose_in_map(), step.pose, 1e-3)

    def test_without_an_imu_the_odometry_turns_the_robot(self):
        run = self.start(turn=0.3)
        run.drive(3.0, look=False)
        step = run.scenario.step()
        run.send(step)
        self.assert_pose_near(run.pose_in_map(), step.pose, 1e-6)

    def test_an_imu_that_falls_silent_is_done_without(self):
        run = self.start(with_imu=True)
        run.drive(1.0, look=False)
        run.drive(1.0)
        run.scenario.with_imu = False
        run.drive(1.4, look=False)
        run.drive(1.0)
        run.wait_for_count("inputs", "refused, imu: silent")


def statuses(run):
    """All that occur in the last ~map; none before it came."""
    return {landmark.status for landmark in run.map.last.landmarks} if run.map.last else set()


class Map(SlamCase):
    def test_map_has_the_landmarks_where_they_are(self):
        run = self.start()
        run.drive(2.0)
        wait_until(lambda: len(run.map.last.landmarks) == 4, "four landmarks are in the map")
        self.assertEqual(run.map.last.header.frame_id, "map")
        for landmark in run.map.last.landmarks:
            np.testing.assert_allclose(positions([landmark])[landmark.source_id], TRUE_POSITIONS[landmark.source_id],
                                       atol=1e-6)
            self.assertEqual(landmark.label, scenario.LANDMARKS[landmark.source_id][0])
            self.assertGreater(landmark.observations, 0)
            self.assert_is_covariance(landmark.covariance)

    def test_a_landmark_is_provisional_until_enough_sightings_agree(self):
        run = self.start({"map/confirm_sightings": 5})
        run.drive(0.2)
        wait_until(lambda: statuses(run) == {Landmark.PROVISIONAL}, "all landmarks are provisional")
        self.assertEqual(run.saved_map()["landmarks"], [])
        run.drive(2.5)
        wait_until(lambda: statuses(run) == {Landmark.CONFIRMED}, "all landmarks are confirmed")
        self.assertEqual(len(run.saved_map()["landmarks"]), 4)

    def test_who_comes_late_gets_the_map_and_the_markers(self):
        run = self.start()
        run.drive(1.0)
        wait_until(lambda: len(run.map.last.landmarks) == 4, "four landmarks are in the map")
        for topic, kind in (("map", type(run.map.last)), ("markers", MarkerArray)):
            late = Recorder(run.process.name + "/" + topic, kind)
            self.addCleanup(late.close)
            wait_until(lambda: late.last, "the latched ~%s came" % topic)  # pylint: disable=cell-var-from-loop

    def test_markers_that_nobody_looked_at_are_drawn_at_once_for_who_comes(self):
        run = self.start({"output/marker_rate": 0.1})  # once in ten seconds
        run.markers.close()
        run.drive(1.0)
        late = Recorder(run.process.name + "/markers", MarkerArray)
        self.addCleanup(late.close)
        wait_until(lambda: {marker.id for message in late.messages for marker in message.markers if marker.ns == "landmarks"} ==
                   {landmark["id"] for landmark in run.saved_map()["landmarks"]}, "all landmarks are drawn", 5.0)

    def test_nobody_who_comes_late_gets_an_old_pose(self):
        run = self.start()
        run.drive(1.0)
        late = Recorder(run.process.name + "/pose", type(run.pose.last))
        self.addCleanup(late.close)
        wait_until(late.is_connected, "the subscription stands")
        stamp = run.scenario.stamp
        run.send(run.scenario.step())
        wait_until(lambda: late.last, "the next pose came")
        self.assertEqual(scenario.to_ns(late.messages[0].header.stamp), stamp)


class Associations(SlamCase):
    def test_first_sightings_create_and_later_ones_match_the_same_landmark(self):
        run = self.start()
        run.drive(1.0)
        first, last = run.associations.messages[0], run.associations.last
        self.assertEqual(first.header.frame_id, "map")
        self.assertEqual([item.verdict for item in first.associations], ["created"] * 4)
        self.assertEqual([item.verdict for item in last.associations], ["matched"] * 4)
        for before, after in zip(first.associations, last.associations):
            self.assertEqual((before.source_id, before.landmark), (after.source_id, after.landmark))
            self.assertTrue(math.isnan(before.nis))
            self.assertGreaterEqual(after.nis, 0.0)
            np.testing.assert_allclose((after.position.x, after.position.y), TRUE_POSITIONS[after.source_id], atol=1e-6)

    def test_a_landmark_out_of_the_sensors_range_is_told_so(self):
        run = self.start({"sensor/max_depth": 1.9})
        run.drive(0.2)
        verdicts = {item.source_id: item.verdict for item in run.associations.last.associations}
        self.assertEqual(verdicts, {7: "created", 3: "created", 12: "out_of_range", 5: "created"})

    def test_known_identities_are_used_when_asked_for_and_only_then(self):
        for association, expected in (("known", ["matched"] * 4), ("nearest_neighbor", ["matched"] * 4)):
            run = self.start({"association/type": association})
            run.drive(0.4)
            self.assertEqual([item.verdict for item in run.associations.last.associations], expected)
        # Without identities: no_identity where they are needed, no difference where they are not.
        for association, expected in (("known", "no_identity"), ("nearest_neighbor", "matched")):
            run = self.start({"association/type": association})
            run.drive(0.4)
            step = run.scenario.step()
            for detection in step.detections.detections:
                detection.id = -1
            run.send(step)
            run.send(run.scenario.step())
            verdicts = [item.verdict for item in run.wait_for_associations(step.stamp).associations]
            self.assertEqual(verdicts, [expected] * 4)


class Transform(SlamCase):
    def test_map_to_odom_is_the_only_transform(self):
        run = self.start()
        run.drive(2.0)
        sent = [transform for message in run.tf.messages for transform in message.transforms]
        self.assertGreater(len(sent), 10)
        self.assertEqual({(item.header.frame_id, item.child_frame_id) for item in sent}, {("map", "odom")})

    def test_map_to_odom_takes_the_odometry_to_the_pose(self):
        run = self.start(odometry_scale=0.85)
        run.drive(3.0)
        run.send(run.scenario.step())
        step = run.scenario.step()
        run.send(step)
        ahead = rospy.Duration(0.1)  # output/transform_tolerance
        transform = wait_until(lambda: next((item.transform for message in run.tf.messages for item in message.transforms
                                             if item.header.stamp == scenario.to_ros(step.stamp) + ahead), None),
                               "the transform of the last odometry came")
        in_odom, heading = step.odometry.pose.pose.position, scenario.heading_of(transform.rotation)
        x = transform.translation.x + math.cos(heading) * in_odom.x - math.sin(heading) * in_odom.y
        y = transform.translation.y + math.sin(heading) * in_odom.x + math.cos(heading) * in_odom.y
        turned = heading + scenario.heading_of(step.odometry.pose.pose.orientation)
        self.assert_pose_near((x, y, turned), run.pose_in_map(), 1e-9)

    def test_it_keeps_coming_while_no_landmark_is_seen(self):
        run = self.start()
        run.drive(1.0)
        count = len(run.tf.messages)
        run.drive(1.0, look=False)
        wait_until(lambda: len(run.tf.messages) >= count + 10, "each odometry message brought a transform")

    def test_there_is_none_before_the_first_odometry(self):
        run = self.start()
        run.publish("landmarks", run.scenario.step().detections)
        wait_until(lambda: run.diagnostics("inputs").get("landmarks age of the last (s)", "never came") != "never came",
                   "the detections arrived")
        self.assertEqual(run.tf.messages, [])
        self.assertEqual(run.pose.messages, [])

    def test_stamps_never_repeat(self):
        run = self.start()
        run.drive(1.0)
        run.publish("odom", run.scenario.step().odometry)
        repeated = scenario.odometry_message(run.scenario.stamp - scenario.PERIOD, (0.0, 0.0, 0.0), 0.2, 0.0)
        run.publish("odom", repeated)
        run.drive(1.0)
        self.assert_stamps_grow(run)

    def test_stamps_do_not_repeat_after_a_reset(self):
        run = self.start()
        run.drive(1.0, look=False)
        step = run.scenario.step()
        run.send(step)
        run.reset()
        run.publish("odom", step.odometry)  # the driver's message comes again
        run.drive(0.4, look=False)
        self.assert_stamps_grow(run)

    def test_there_is_none_when_it_is_switched_off(self):
        run = self.start({"output/publish_tf": False})
        run.drive(1.0)
        run.drive(1.0, look=False)
        self.assertEqual(run.tf.messages, [])

    def assert_stamps_grow(self, run):
        last = scenario.to_ros(run.pose_stamp()) + rospy.Duration(0.1)
        wait_until(lambda: run.tf.last.transforms[0].header.stamp >= last, "the last transform came")
        stamps = [scenario.to_ns(item.header.stamp) for message in run.tf.messages for item in message.transforms]
        self.assertEqual(stamps, sorted(set(stamps)))


class Markers(SlamCase):
    NAMESPACES = {"landmarks", "labels", "covariance", "robot_position", "robot_heading", "associations", "path",
                  "dead_reckoning"}

    @staticmethod
    def shown(messages):
        """What RViz shows after these messages: {(namespace, id): marker}."""
        result = {}
        for message in messages:
            for marker in message.markers:
                if marker.action == Marker.DELETEALL:
                    result.clear()
                elif marker.action == Marker.DELETE:
                    result.pop((marker.ns, marker.id), None)
                else:
                    result[(marker.ns, marker.id)] = marker
        return result

    def landmarks_shown(self, run, space="landmarks"):
        return {number for name, number in self.shown(list(run.markers.messages)) if name == space}

    def test_every_kind_is_shown_in_the_map_frame(self):
        run = self.start()
        run.drive(2.0)
        wait_until(lambda: self.NAMESPACES <= {name for name, _ in self.shown(list(run.markers.messages))},
                   "all kinds of markers came")
        for marker in self.shown(list(run.markers.messages)).values():
            self.assertEqual(marker.header.frame_id, "map")
            rotation = marker.pose.orientation
            self.assertAlmostEqual(rotation.x**2 + rotation.y**2 + rotation.z**2 + rotation.w**2, 1.0)

    def test_a_landmark_keeps_its_marker_and_shows_its_number_and_colour(self):
        run = self.start()
        run.drive(2.0)
        wait_until(lambda: len(run.map.last.landmarks) == 4 and len(self.landmarks_shown(run)) == 4, "four are shown")
        entries = {landmark.id: landmark for landmark in run.map.last.landmarks}
        for message in list(run.markers.messages):
            for marker in message.markers:
                if marker.ns in ("landmarks", "labels", "covariance"):
                    position = entries[marker.id].position
                    np.testing.assert_allclose((marker.pose.position.x, marker.pose.position.y), (position.x, position.y),
                                               atol=1e-6)
                if marker.ns == "labels":
                    self.assertIn(str(marker.id), marker.text)
                if marker.ns == "landmarks":
                    strongest = {"red": "r", "green": "g", "blue": "b", "yellow": "r"}[entries[marker.id].label]
                    self.assertEqual(getattr(marker.color, strongest), max(marker.color.r, marker.color.g, marker.color.b))

    def test_the_robots_ellipse_is_purple_and_its_wedge_yellow(self):
        run = self.start()
        run.drive(1.0)
        shown = wait_until(lambda: self.shown(list(run.markers.messages)), "markers came")
        purple, yellow = shown[("robot_position", 0)].color, shown[("robot_heading", 0)].color
        self.assertGreater(min(purple.r, purple.b), purple.g)
        self.assertGreater(min(yellow.r, yellow.g), yellow.b)

    def test_ellipses_have_the_size_that_the_parameter_says(self):
        for sigmas in (3.0, 2.0):
            run = self.start({"output/marker_sigmas": sigmas})
            run.drive(1.0)
            wait_until(lambda: len(self.landmarks_shown(run)) == 4 and len(run.map.last.landmarks) == 4,  # pylint: disable=cell-var-from-loop
                       "four are shown")
            stamps = {scenario.to_ns(message.header.stamp): message for message in list(run.map.messages)}
            compared = 0
            for message in list(run.markers.messages):
                stamp = scenario.to_ns(message.markers[0].header.stamp)
                ellipses = {marker.id: marker for marker in message.markers if marker.ns == "covariance"}
                for landmark in stamps[stamp].landmarks if stamp in stamps else []:
                    expected = sigmas * 2.0 * np.sqrt(np.linalg.eigvalsh(matrix(landmark.covariance)[:2, :2]))
                    scale = ellipses[landmark.id].scale
                    np.testing.assert_allclose(sorted((scale.x, scale.y)), expected, rtol=1e-9)
                    compared += 1
            self.assertGreater(compared, 0)

    def test_lines_go_from_the_robot_to_what_was_seen(self):
        run = self.start()
        run.drive(1.0)
        wait_until(lambda: len(self.landmarks_shown(run)) == 4, "four are shown")
        lines = self.shown(list(run.markers.messages))[("associations", 0)]
        ends = sorted((round(point.x, 6), round(point.y, 6)) for point in lines.points[1::2])
        self.assertEqual(ends, sorted(TRUE_POSITIONS.values()))

    def test_markers_follow_a_landmark_that_is_placed_anew(self):
        # A landmark that is seen elsewhere again and again is placed anew, under its identity.
        run = self.start({"association/type": "known", "estimator/replace_after": 3})
        run.drive(0.4)
        identities = set(run.scenario.landmarks)
        wait_until(lambda: self.landmarks_shown(run) == identities, "all are shown under their identities")

        def place():
            """Where the last marker of landmark 12 stands."""
            return [(marker.pose.position.x, marker.pose.position.y) for message in list(run.markers.messages)
                    for marker in message.markers if marker.ns == "landmarks" and marker.id == 12][-1]

        before = place()
        label, x, y = run.scenario.landmarks[12]
        run.scenario.landmarks[12] = (label, x - 0.4, y - 0.4)
        run.drive(1.2)
        wait_until(lambda: before[0] - place()[0] > 0.3 and before[1] - place()[1] > 0.3, "the marker has moved")
        self.assertEqual(self.landmarks_shown(run), identities)

    def test_a_reset_removes_all_markers(self):
        run = self.start()
        run.drive(1.0)
        wait_until(lambda: len(self.landmarks_shown(run)) == 4, "four are shown")
        run.reset()
        wait_until(lambda: any(marker.action == Marker.DELETEALL for message in list(run.markers.messages)
                               for marker in message.markers), "DELETEALL came")
        wait_until(lambda: not self.landmarks_shown(run), "no landmark is shown any more")


class Diagnostics(SlamCase):
    def test_they_tell_rates_ages_nis_and_landmarks(self):
        run = self.start(odometry_scale=0.9)
        run.drive(2.0)
        run.wait_for_count("estimate", "detections, matched", 36)
        run.wait_for_count("estimate", "landmarks", 4)
        inputs, estimate = run.diagnostics("inputs"), run.diagnostics("estimate")
        self.assertEqual((inputs["level"], estimate["level"]), (0, 0))
        self.assertLess(float(inputs["odometry age of the last (s)"]), 10.0)
        self.assertEqual(inputs["imu age of the last (s)"], "never came")
        self.assertGreater(float(estimate["NIS per degree of freedom"]), 0.0)
        self.assertEqual(int(estimate["detections, created"]), 4)
        self.assertEqual(int(estimate["detections, matched"]), 36)
        self.assertGreater(float(estimate["position sigma (m)"]), 0.0)
        self.assertEqual(int(inputs["refused"]), 0)

    def test_the_rate_of_the_odometry_is_told(self):
        run = self.start()
        wait_until(lambda: (run.send(run.scenario.step()),
                            float(run.diagnostics("inputs").get("odometry rate (Hz)", 0.0)) > 0.0)[1],
                   "a rate above zero is told")

    def test_they_warn_while_there_is_no_odometry(self):
        run = self.start()
        wait_until(lambda: run.diagnostics("inputs").get("level") == 1, "a warning came")
        self.assertIn("no odometry", run.diagnostics("inputs")["message"])

    def test_they_warn_when_the_position_is_uncertain(self):
        run = self.start({"output/pose_sigma_warning": 0.001})
        run.drive(1.0)
        wait_until(lambda: run.diagnostics("estimate").get("level") == 1, "a warning came")


if __name__ == "__main__":
    rospy.init_node("test_outputs")
    rostest.rosrun("kinect_ekf_slam", "test_outputs", "test_outputs")
