#include "kinect_ekf_slam/ros/parameters.h"

#include <gtest/gtest.h>

#include <set>

#include "kinect_ekf_slam/ros/configuration.h"
#include "kinect_ekf_slam/ros/detector_options.h"
#include "test/support/temporary_folder.h"

namespace kinect_ekf_slam {
namespace {

using testing::message_of;

/// The least that a run needs.
YAML::Node least() {
  return YAML::Load(
      "{frames: {map: map, odom: odom, base: base_link}, estimator: {type: ekf}, association: {type: "
      "known}}");
}

/// What reading says when one assignment is made.
std::string refusal(const std::string& assignment) {
  YAML::Node yaml = least();
  set_parameter(assignment, &yaml);
  return message_of<ParameterError>([&] { read_parameters(yaml, nullptr); });
}

TEST(Parameters, ReadWhatIsGivenAndKeepTheDefaultsOfTheRest) {
  YAML::Node yaml = least();
  set_parameter("input/max_linear_speed=0.7", &yaml);
  set_parameter("input/heading_source=imu", &yaml);
  set_parameter("mode=localization", &yaml);
  set_parameter("sync/imu_topic=''", &yaml);
  std::vector<std::string> unread;
  const RunOptions options = read_parameters(yaml, &unread);
  EXPECT_EQ(options.frames.base, "base_link");
  EXPECT_EQ(options.pipeline.association.type, AssociationOptions::Type::kKnown);
  EXPECT_EQ(options.pipeline.input.max_linear_speed, 0.7);
  EXPECT_EQ(options.pipeline.input.heading_source, HeadingSource::kImu);
  EXPECT_EQ(options.pipeline.mode, Mode::kLocalization);
  EXPECT_EQ(options.sync.imu_topic, "");
  EXPECT_EQ(options.sync.max_interval, 0.07);
  EXPECT_EQ(options.pipeline.input.max_angular_speed, 1.1);
  EXPECT_TRUE(unread.empty());
}

TEST(Parameters, ReadBeacons) {
  YAML::Node yaml = least();
  set_parameter("fusion/beacons=[{id: 3, xyz: [1, 2, 0.5], sigma: 0.1}]", &yaml);
  set_parameter("fusion/datum=[42.0, -71.0, 5.0]", &yaml);
  const RunOptions options = read_parameters(yaml, nullptr);
  ASSERT_EQ(options.pipeline.positions.beacons.size(), 1U);
  EXPECT_EQ(options.pipeline.positions.beacons[0].id, 3);
  EXPECT_EQ(options.pipeline.positions.beacons[0].position_in_map, Eigen::Vector3d(1.0, 2.0, 0.5));
  EXPECT_EQ(options.fusion.datum, (std::vector<double>{42.0, -71.0, 5.0}));
}

TEST(Parameters, SayWhichBeaconOrDatumCannotBe) {
  EXPECT_EQ(
      refusal("fusion/beacons=[{id: 3, xyz: [1, 2, 0], sigma: 0.1}, {id: 3, xyz: [4, 2, 0], sigma: 0.1}]"),
      "fusion/beacons: '{id: 3, xyz: [4, 2, 0], sigma: 0.1}' given, allowed: a list of {id, xyz: [m], "
      "sigma: m}, no id twice, sigma more than 0");
  EXPECT_NE(refusal("fusion/beacons=[{id: 3, xyz: [1, 2, 0], sigma: 0}]"), "");
  EXPECT_NE(refusal("fusion/beacons=[{id: 3, xyz: [1, 2, 0], sigma: 1, colour: red}]"), "");
  EXPECT_EQ(
      refusal("fusion/datum=somewhere"),
      "fusion/datum: 'somewhere' given, allowed: first_fix, or [latitude deg, longitude deg, altitude m]");
  EXPECT_NE(refusal("fusion/datum=[95.0, 0.0, 0.0]"), "");
  EXPECT_NE(refusal("fusion/frame=map"), "");
}

TEST(Parameters, SayWhichRequiredKeyIsMissing) {
  for (const char* key : {"frames/map", "frames/odom", "frames/base", "estimator/type", "association/type"}) {
    YAML::Node yaml = least();
    const std::string name = key;
    const auto slash = name.find('/');
    yaml[name.substr(0, slash)].remove(name.substr(slash + 1));
    EXPECT_EQ(message_of<ParameterError>([&] { read_parameters(yaml, nullptr); }),
              name + ": is missing; start from config/slam.yaml (slam.launch loads it)");
  }
  EXPECT_NE(message_of<ParameterError>([&] { read_parameters(YAML::Node(), nullptr); }), "");
}

TEST(Parameters, SayWhichNamesAreKnown) {
  EXPECT_EQ(refusal("estimator/type=kalman"),
            "estimator/type: 'kalman' given, allowed: one of ekf, invariant_ekf, compressed_ekf, ukf, "
            "fastslam1, fastslam2, dead_reckoning");
  EXPECT_EQ(refusal("association/type=best"),
            "association/type: 'best' given, allowed: one of known, nearest_neighbor, jcbb, "
            "multi_hypothesis");
  EXPECT_EQ(refusal("mode=mapping"), "mode: 'mapping' given, allowed: one of slam, localization");
  EXPECT_EQ(refusal("estimator/space=hyperbolic"),
            "estimator/space: 'hyperbolic' given, allowed: one of planar, spatial");
  EXPECT_EQ(refusal("mode=[slam]"), "mode: '[slam]' given, allowed: one of slam, localization");
}

TEST(Parameters, SayWhichValuesAreAllowed) {
  EXPECT_EQ(refusal("frames/tf_timeout=-1"), "frames/tf_timeout: '-1' given, allowed: a number from 0 to 10");
  EXPECT_EQ(refusal("frames/tf_timeout=.nan"),
            "frames/tf_timeout: '.nan' given, allowed: a number from 0 to 10");
  EXPECT_EQ(refusal("input/max_linear_speed=0"),
            "input/max_linear_speed: '0' given, allowed: a number >= 1e-06");
  EXPECT_EQ(refusal("sync/queue_size=0"),
            "sync/queue_size: '0' given, allowed: a whole number from 1 to 100000");
  EXPECT_EQ(refusal("association/gate_probability=1.5"),
            "association/gate_probability: '1.5' given, allowed: a number from 1e-06 to 1");
  EXPECT_EQ(refusal("association/joint_work=1e+07"),
            "association/joint_work: '1e+07' given, allowed: a whole number from 1 to 10000000");
  EXPECT_EQ(refusal("sensor/min_depth=5"),
            "sensor/min_depth: 5 given, allowed: at most sensor/max_depth, 2.6");
  EXPECT_EQ(refusal("association/new_landmark_probability=0.5"),
            "association/new_landmark_probability: 0.5 given, allowed: at least "
            "association/gate_probability, 0.975");
}

TEST(Parameters, SayWhatIsEmpty) {
  EXPECT_EQ(refusal("map/file_name=''"), "map/file_name: is empty, allowed: text, not empty");
  EXPECT_EQ(refusal("map/file_name="), "map/file_name: is empty, allowed: text, not empty");
  EXPECT_EQ(refusal("frames/tf_timeout="), "frames/tf_timeout: is empty, allowed: a number from 0 to 10");
  EXPECT_EQ(refusal("sync/queue_size=~"),
            "sync/queue_size: is empty, allowed: a whole number from 1 to 100000");
  EXPECT_EQ(refusal("output/publish_tf="), "output/publish_tf: is empty, allowed: true or false");
  EXPECT_EQ(refusal("mode="), "mode: is empty, allowed: one of slam, localization");
  EXPECT_EQ(
      refusal("frames/static_transforms="),
      "frames/static_transforms: is empty, allowed: a list of {parent, child, xyz: [m], rpy_deg: [deg]}");
}

TEST(Parameters, ATextThatMayBeEmptyNeedsNoQuotes) {
  YAML::Node yaml = least();
  set_parameter("sync/imu_topic=", &yaml);
  EXPECT_EQ(read_parameters(yaml, nullptr).sync.imu_topic, "");
}

TEST(Parameters, SayWhichTypeIsExpected) {
  EXPECT_EQ(refusal("input/max_linear_speed=fast"),
            "input/max_linear_speed: 'fast' given, allowed: a number >= 1e-06");
  EXPECT_EQ(refusal("input/max_linear_speed={a: 1}"),
            "input/max_linear_speed: '{a: 1}' given, allowed: a number >= 1e-06");
  EXPECT_EQ(refusal("sync/queue_size=1.5"),
            "sync/queue_size: '1.5' given, allowed: a whole number from 1 to 100000");
  EXPECT_EQ(refusal("output/publish_tf=perhaps"),
            "output/publish_tf: 'perhaps' given, allowed: true or false");
  EXPECT_EQ(refusal("frames/map=[map]"), "frames/map: '[map]' given, allowed: text, not empty");
  const std::string transforms = "allowed: a list of {parent, child, xyz: [m], rpy_deg: [deg]}";
  EXPECT_EQ(refusal("frames/static_transforms=none"),
            "frames/static_transforms: 'none' given, " + transforms);
  EXPECT_EQ(refusal("frames/static_transforms=[{parent: a, child: b, xyz: [0, 0], rpy_deg: [0, 0, 0]}]"),
            "frames/static_transforms: '{parent: a, child: b, xyz: [0, 0], rpy_deg: [0, 0, 0]}' given, " +
                transforms);
  for (const char* useless : {"{parent: a, child: a, xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}",
                              "{parent: \"\", child: b, xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}",
                              "{parent: a, child: /b, xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}",
                              "{parent: a, child: b, xyz: [.nan, 0, 0], rpy_deg: [0, 0, 0]}",
                              "{parent: a, child: b, xyz: [0, 0, 0], rpy_deg: [0, .inf, 0]}"}) {
    EXPECT_EQ(refusal("frames/static_transforms=[" + std::string(useless) + "]"),
              "frames/static_transforms: '" + std::string(useless) + "' given, " + transforms);
  }
}

TEST(Parameters, RefuseAStartThatIsNowhere) {
  EXPECT_NE(refusal("estimator/initial_x=.inf"), "");
  EXPECT_NE(refusal("estimator/initial_y=-.inf"), "");
  EXPECT_NE(refusal("estimator/initial_position_sigma=.inf"), "");
}

TEST(Parameters, RefuseFramesWithALeadingSlash) {
  EXPECT_EQ(refusal("frames/odom=/odom"), "frames/odom: '/odom': a frame has no leading slash");
}

TEST(Parameters, RefuseEqualFrames) {
  EXPECT_EQ(
      refusal("frames/base=odom"),
      "frames/map, frames/odom, frames/base: 'map', 'odom', 'odom' given, allowed: three different frames");
}

TEST(Parameters, NameTheKeysThatNothingReads) {
  YAML::Node yaml = least();
  set_parameter("input/max_speed=1", &yaml);
  set_parameter("speeling=1", &yaml);
  set_parameter("sensors/min_depth=1", &yaml);
  std::vector<std::string> unread;
  read_parameters(yaml, &unread);
  EXPECT_EQ(std::set<std::string>(unread.begin(), unread.end()),
            std::set<std::string>(
                {"input/max_speed is not known and was not read", "speeling is not known and was not read",
                 "sensors/min_depth is not known and was not read; did you mean sensor/min_depth?"}));
}

TEST(Parameters, AGroupThatIsAValueIsNotRead) {
  YAML::Node yaml = least();
  yaml["sensor"] = 5;
  std::vector<std::string> unread;
  read_parameters(yaml, &unread);
  EXPECT_EQ(unread, std::vector<std::string>{"sensor is not known and was not read"});
}

TEST(Parameters, EachIsListedOnceWithItsMeaning) {
  std::set<std::string> keys;
  for (const ParameterInfo& info : list_parameters()) {
    EXPECT_TRUE(keys.insert(info.key).second) << info.key << " is listed twice";
    EXPECT_FALSE(info.meaning.empty()) << info.key;
    EXPECT_FALSE(info.allowed.empty()) << info.key;
  }
  EXPECT_GT(keys.size(), 50U);
}

/// The list is what the documentation is made of: each default in it must be what reading it gives.
TEST(Parameters, TheListedDefaultsAreAllowedAndKnown) {
  YAML::Node yaml = least();
  for (const ParameterInfo& info : list_parameters()) {
    if (!info.required)
      set_parameter(info.key + "=" + (info.default_value.empty() ? "''" : info.default_value), &yaml);
  }
  std::vector<std::string> unread;
  EXPECT_EQ(message_of<ParameterError>([&] { read_parameters(yaml, &unread); }), "");
  EXPECT_TRUE(unread.empty());
}

TEST(DetectorParameters, BoundsThatLeaveNothingAreRefused) {
  const auto refusal_of = [](const std::string& assignment) {
    YAML::Node yaml = YAML::LoadFile(std::string(CONFIG_FOLDER) + "/detector.yaml");
    set_parameter(assignment, &yaml);
    return testing::message_of<ParameterError>([&] { read_detector_options(yaml, nullptr); });
  };
  EXPECT_EQ(refusal_of("kinect_cylinder/min_height=2"),
            "kinect_cylinder/min_height: 2 given, allowed: less than kinect_cylinder/max_height, 0.6");
  EXPECT_NE(refusal_of("kinect_cylinder/min_depth=10"), "");
  EXPECT_NE(refusal_of("kinect_cylinder/min_radius=0.9"), "");
  EXPECT_NE(refusal_of("laser_cylinder/min_radius=4"), "");
  EXPECT_NE(refusal_of("features/min_depth=50"), "");
}

}  // namespace
}  // namespace kinect_ekf_slam
