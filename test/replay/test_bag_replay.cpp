#include "kinect_ekf_slam/ros/bag_replay.h"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <kinect_ekf_slam/LandmarkDetectionArray.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>
#include <sstream>

#include "kinect_ekf_slam/ros/configuration.h"
#include "test/support/temporary_folder.h"

namespace kinect_ekf_slam {
namespace {

using testing::message_of;
using testing::read_text;
using testing::TemporaryFolder;
using testing::write_text;

constexpr double kStart = 100.0;  // s
constexpr double kSpeed = 0.1;    // m/s
constexpr int kSteps = 100;       // at 20 Hz

nav_msgs::Odometry odometry(double time) {
  nav_msgs::Odometry message;
  message.header.stamp = ros::Time(time);
  message.header.frame_id = "odom";
  message.child_frame_id = "base_footprint";
  message.pose.pose.orientation.w = 1.0;
  message.twist.twist.linear.x = kSpeed;
  return message;
}

/// Two cylinders, seen by a camera that looks ahead from 0.2 m before the robot's centre.
LandmarkDetectionArray landmarks(double time) {
  LandmarkDetectionArray message;
  message.header.stamp = ros::Time(time);
  message.header.frame_id = "camera_optical_frame";
  for (const double aside : {-0.4, 0.4}) {
    LandmarkDetection detection;
    detection.id = aside < 0.0 ? 4 : 7;
    detection.label = aside < 0.0 ? "left, \"red\"" : "right";
    detection.position.x = aside;
    detection.position.z = 2.0 - kSpeed * (time - kStart) - 0.2;
    message.detections.push_back(detection);
  }
  return message;
}

tf2_msgs::TFMessage camera_mounting() {
  tf2_msgs::TFMessage message;
  message.transforms.resize(1);
  geometry_msgs::TransformStamped& transform = message.transforms[0];
  transform.header.frame_id = "base_footprint";
  transform.child_frame_id = "camera_optical_frame";
  transform.transform.translation.x = 0.2;
  transform.transform.rotation.x = -0.5;
  transform.transform.rotation.y = 0.5;
  transform.transform.rotation.z = -0.5;
  transform.transform.rotation.w = 0.5;
  return message;
}

class BagReplay : public ::testing::Test {
 protected:
  void SetUp() override {
    request_.bag = folder_ / "run.bag";
    request_.output_directory = folder_ / "out";
    set({});
  }

  void set(std::vector<std::string> settings) {
    settings.insert(settings.begin(), "association/type=known");
    request_.options = read_run_options({}, settings, [](const std::string& line) { ADD_FAILURE() << line; });
  }

  void write_run(const std::string& prefix = "/") const {
    rosbag::Bag bag(request_.bag, rosbag::bagmode::Write);
    bag.write("/tf_static", ros::Time(kStart), camera_mounting());
    for (int i = 0; i < kSteps; ++i) {
      const double time = kStart + 0.05 * i;
      bag.write(prefix + "odom", ros::Time(time), odometry(time));
      if (i % 4 == 0)
        bag.write(prefix + "landmarks", ros::Time(time + 0.03), landmarks(time));  // pictures are late
    }
  }
  /// Where the robot is in a frame whose x is the map's -y, each told 0.3 s later.
  void add_positions() const {
    rosbag::Bag bag(request_.bag, rosbag::bagmode::Append);
    for (int i = 1; i < kSteps; i += 2) {
      const double time = kStart + 0.05 * i + 0.01;
      geometry_msgs::PoseWithCovarianceStamped message;
      message.header.stamp = ros::Time(time);
      message.header.frame_id = "earth";
      message.pose.pose.position.x = 100.0 + (i % 4 == 1 ? 0.002 : -0.002);
      message.pose.pose.position.y = 50.0 + kSpeed * (time - kStart);
      message.pose.pose.orientation.w = 1.0;
      for (const std::size_t axis : {0U, 7U, 14U}) message.pose.covariance[axis] = 1e-4;
      bag.write("/global_position", ros::Time(time + 0.3), message);
    }
  }
  /// The same with the heading; the robot drives along y.
  void add_poses() const {
    rosbag::Bag bag(request_.bag, rosbag::bagmode::Append);
    for (int i = 0; i < kSteps; i += 2) {
      const double time = kStart + 0.05 * i;
      geometry_msgs::PoseWithCovarianceStamped message;
      message.header.stamp = ros::Time(time);
      message.header.frame_id = "earth";
      message.pose.pose.position.x = 100.0;
      message.pose.pose.position.y = 50.0 + kSpeed * (time - kStart);
      message.pose.pose.orientation.z = message.pose.pose.orientation.w = std::sqrt(0.5);
      for (const std::size_t axis : {0U, 7U, 14U, 21U, 28U, 35U}) message.pose.covariance[axis] = 1e-4;
      bag.write("/global_position", ros::Time(time + 0.01), message);
    }
  }
  std::string refusal() {
    return message_of<std::runtime_error>([&] { replay_bag(request_); });
  }
  std::string out(const std::string& name) const { return read_text(request_.output_directory + "/" + name); }
  static long lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

  TemporaryFolder folder_;
  ReplayRequest request_;
};

TEST_F(BagReplay, MapsWhatTheBagShows) {
  write_run();
  const ReplayReport report = replay_bag(request_);
  EXPECT_EQ(report.landmarks, 2U);
  EXPECT_EQ(report.detection_frames, 25U);
  EXPECT_NEAR(report.data_seconds, 0.05 * (kSteps - 1), 0.05);
}

TEST_F(BagReplay, WritesItsFiles) {
  write_run();
  replay_bag(request_);
  for (const char* name : {"trajectory.tum", "trajectory_covariance.csv", "dead_reckoning.tum",
                           "landmarks.csv", "associations.csv", "summary.json"}) {
    EXPECT_NE(out(name), "") << name;
  }
  EXPECT_EQ(out("landmarks.csv").rfind("id,label,x,y,z,cxx,cxy,cxz,cyy,cyz,czz,observations\n", 0), 0U);
  EXPECT_EQ(lines(out("landmarks.csv")), 3);
  EXPECT_NE(out("landmarks.csv").find("\"left, \"\"red\"\"\""), std::string::npos) << "labels are quoted";
  EXPECT_EQ(out("associations.csv")
                .rfind("t,detection,source_id,verdict,landmark,nis\n100.000000000,0,4,created,4,", 0),
            0U);
  EXPECT_EQ(lines(out("associations.csv")), 1 + 50);
  const std::string summary = out("summary.json");
  for (const char* part : {"\"landmarks\": 2", "\"detection_frames\": 25", "\"created\": 2",
                           "\"matched\": 48", "\"odometry\": 100", "\"messages_refused\": {}"}) {
    EXPECT_NE(summary.find(part), std::string::npos) << part << " is not in\n" << summary;
  }
}

TEST_F(BagReplay, RefinesARunIntoTheSameFiles) {
  write_run();
  request_.refine = true;
  ReplayReport report;
  try {
    report = replay_bag(request_);
  } catch (const std::runtime_error& error) {
    if (std::string(error.what()).find("without Ceres") != std::string::npos) GTEST_SKIP() << error.what();
    throw;
  }
  ASSERT_TRUE(report.refinement.has_value());
  EXPECT_EQ(report.refinement->sightings, 50U);
  EXPECT_EQ(report.refinement->doubted, 0U);
  EXPECT_LT(report.refinement->path_difference, 0.05);
  EXPECT_EQ(report.refinement->calibration.size(), 8U);
  for (const char* name :
       {"trajectory.tum", "trajectory_covariance.csv", "dead_reckoning.tum", "landmarks.csv",
        "associations.csv", "summary.json", "refinement.json", "calibration.yaml"}) {
    EXPECT_NE(out(std::string("refined/") + name), "") << name;
  }
  for (const char* name : {"trajectory.tum", "landmarks.csv", "associations.csv"}) {
    EXPECT_EQ(lines(out(std::string("refined/") + name)), lines(out(name))) << name;
  }
  // What it found is a configuration.
  const std::string calibration = request_.output_directory + "/refined/calibration.yaml";
  request_.options = read_run_options({calibration}, {"association/type=known"},
                                      [](const std::string& line) { ADD_FAILURE() << line; });
  EXPECT_NEAR(request_.options.pipeline.input.linear_scale, 1.0, 0.05);
}

TEST_F(BagReplay, RefinesOnlyRunsThatMakeTheirMap) {
  write_run();
  request_.refine = true;
  set({"mode=localization"});
  EXPECT_EQ(refusal().rfind("--refine: ", 0), 0U) << refusal();
}

TEST_F(BagReplay, SaysThatPositionsDoNotEnterARefinement) {
  write_run();
  add_positions();
  request_.refine = true;
  try {
    const ReplayReport report = replay_bag(request_);
    ASSERT_TRUE(report.refinement.has_value());
    const std::vector<std::string> expected = {"positions and ranges to beacons do not enter the refinement"};
    EXPECT_EQ(report.refinement->warnings, expected);
  } catch (const std::runtime_error& error) {
    if (std::string(error.what()).find("without Ceres") != std::string::npos) GTEST_SKIP() << error.what();
    throw;
  }
}

TEST_F(BagReplay, SaysWhatARefinementLacks) {
  rosbag::Bag bag(request_.bag, rosbag::bagmode::Write);
  for (int i = 0; i < kSteps; ++i)
    bag.write("/odom", ros::Time(kStart + 0.05 * i), odometry(kStart + 0.05 * i));
  bag.close();
  request_.refine = true;
  const std::string line = refusal();
  EXPECT_TRUE(line == "--refine: the run has no sighting of a landmark" ||
              line.find("without Ceres") != std::string::npos)
      << line;
}

TEST_F(BagReplay, WritesOneMapInTheFrameOfThePositions) {
  write_run();
  add_poses();
  request_.global = true;
  const ReplayReport report = replay_bag(request_);
  ASSERT_TRUE(report.global.has_value());
  EXPECT_EQ(report.global->frame, "earth");
  EXPECT_EQ(report.global->placed, report.global->segments);
  EXPECT_EQ(report.global->landmarks, 2U);
  EXPECT_EQ(report.global->positions, 5U) << "one a second: global_map/path_interval";
  EXPECT_EQ(report.global->warnings, std::vector<std::string>{});
  for (const char* name : {"trajectory.tum", "trajectory_covariance.csv", "dead_reckoning.tum",
                           "landmarks.csv", "positions.csv", "summary.json", "parameters.yaml"}) {
    EXPECT_NE(out(std::string("global/") + name), "") << name;
  }
  EXPECT_EQ(lines(out("global/positions.csv")), 1 + 5);
  EXPECT_EQ(out("global/segments.csv").substr(0, 40), "segment,first_map,last_map,start,end,pos");

  std::istringstream rows(out("global/landmarks.csv"));
  std::string row;
  std::getline(rows, row);
  std::set<double> aside;
  while (std::getline(rows, row)) {
    double x = 0.0;
    double y = 0.0;
    const std::size_t place =
        row.rfind("\",") == std::string::npos ? row.find("right,") + 5 : row.rfind("\",") + 1;
    ASSERT_EQ(std::sscanf(row.c_str() + place, ",%lf,%lf", &x, &y), 2) << row;
    aside.insert(std::round(10.0 * (x - 100.0)));
    EXPECT_NEAR(y, 52.0, 0.05) << row;
  }
  EXPECT_EQ(aside, (std::set<double>{-4.0, 4.0}));
}

TEST_F(BagReplay, SaysWhyThereIsNoGlobalMap) {
  write_run();
  request_.global = true;
  EXPECT_EQ(refusal(),
            "--global: the run has no global positions; a map in their frame needs some on 'global_position' "
            "(fusion/positions_topic) or fusion/fix_topic");
  add_positions();
  set({"global_map/max_alignment_sigma_deg=0.1"});  // so well a way of half a metre tells no heading
  const std::string line = refusal();
  EXPECT_EQ(line.rfind("--global: local map", 0), 0U) << line;
  EXPECT_NE(line.find("near to one place that the heading is known to "), std::string::npos) << line;
  set({"estimator/type=fastslam1"});
  EXPECT_EQ(refusal().rfind("--global: estimator/type: ", 0), 0U) << refusal();
}

TEST_F(BagReplay, TellsPositionsThatCannotBeUsedFromNone) {
  write_run();
  request_.global = true;
  rosbag::Bag bag(request_.bag, rosbag::bagmode::Append);
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = "earth";
  message.pose.pose.orientation.w = 1.0;
  for (const double time : {1.0, 1.5, 2.0}) {  // the covariance is zero
    message.header.stamp = ros::Time(kStart + time);
    bag.write("/global_position", ros::Time(kStart + 2.1), message);
  }
  bag.close();
  EXPECT_EQ(refusal(),
            "--global: none of the run's 3 global positions can be used: 3 global_position: no covariance");
}

TEST_F(BagReplay, TakesAwayWhatAnEarlierRunWasRefinedTo) {
  write_run();
  const std::string refined = request_.output_directory + "/refined";
  std::filesystem::create_directories(refined);
  write_text(refined + "/notes.txt", "no run: somebody else's");
  replay_bag(request_);
  EXPECT_TRUE(std::filesystem::exists(refined + "/notes.txt"));
  write_text(refined + "/trajectory.tum", "");
  replay_bag(request_);
  EXPECT_FALSE(std::filesystem::exists(refined));
}

TEST_F(BagReplay, FollowsTheRobot) {
  write_run();
  replay_bag(request_);
  const std::string trajectory = out("trajectory.tum");
  const auto last = trajectory.find_last_of('\n', trajectory.size() - 2);
  std::istringstream line(trajectory.substr(last + 1));
  double time = 0.0;
  double x = 0.0;
  double y = 0.0;
  line >> time >> x >> y;
  EXPECT_NEAR(time, kStart + 0.05 * (kSteps - 1), 0.05);
  EXPECT_NEAR(x, kSpeed * (time - kStart), 0.01);
  EXPECT_NEAR(y, 0.0, 0.01);
}

TEST_F(BagReplay, UsesPositionsThatComeLateAtTheirOwnTime) {
  write_run();
  add_positions();
  replay_bag(request_);
  const std::string summary = out("summary.json");
  // Nobody waited for the first two: that there are positions was not known yet.
  EXPECT_NE(summary.find("\"late\": 2, \"used\": 35"), std::string::npos) << summary;
  const std::string positions = out("positions.csv");
  std::istringstream last(positions.substr(positions.find_last_of('\n', positions.size() - 2) + 1));
  std::vector<std::string> fields;
  for (std::string field; std::getline(last, field, ',');) fields.push_back(field);
  ASSERT_EQ(fields.size(), 8U);
  const double time = std::stod(fields[0]);
  EXPECT_NEAR(std::stod(fields[5]), kSpeed * (time - kStart), 0.02);  // x in the map
  EXPECT_NEAR(std::stod(fields[6]), 0.0, 0.03);
}

TEST_F(BagReplay, RefusesAndCountsPositionsThatComeTooLate) {
  write_run();
  add_positions();
  set({"sync/position_delay=0.05", "sync/detection_delay=0.05"});
  const ReplayReport report = replay_bag(request_);
  EXPECT_NE(out("summary.json").find("\"late\": 49"), std::string::npos) << out("summary.json");
  const bool is_told = std::any_of(report.warnings.begin(), report.warnings.end(), [](const auto& line) {
    return line == "49 positions or ranges not used: late";
  });
  EXPECT_TRUE(is_told);
}

TEST_F(BagReplay, GivesTheSameFilesAgain) {
  write_run();
  replay_bag(request_);
  const std::string first = out("trajectory.tum") + out("landmarks.csv") + out("associations.csv");
  replay_bag(request_);
  EXPECT_EQ(out("trajectory.tum") + out("landmarks.csv") + out("associations.csv"), first);
}

TEST_F(BagReplay, FindsTopicsRecordedWithoutASlash) {
  write_run("");
  EXPECT_EQ(replay_bag(request_).landmarks, 2U);
}

TEST_F(BagReplay, WritesNothingWhenNotAsked) {
  write_run();
  request_.output_directory.clear();
  EXPECT_EQ(replay_bag(request_).landmarks, 2U);
  EXPECT_EQ(folder_.entries(), 1U);
}

TEST_F(BagReplay, CountsAndTellsWhatItRefuses) {
  write_run();
  {
    rosbag::Bag bag(request_.bag, rosbag::bagmode::Append);
    for (int i = 0; i < 7; ++i) {
      const double time = kStart + 0.05 * (kSteps + i);
      nav_msgs::Odometry message = odometry(time);
      message.child_frame_id = "base_link";
      bag.write("/odom", ros::Time(time), message);
    }
  }
  const ReplayReport report = replay_bag(request_);
  EXPECT_EQ(report.landmarks, 2U);
  EXPECT_NE(out("summary.json").find("\"odometry: frame\": 7"), std::string::npos);
  const auto has = [&](const std::string& start) {
    return std::count_if(report.warnings.begin(), report.warnings.end(),
                         [&](const std::string& line) { return line.rfind(start, 0) == 0; });
  };
  EXPECT_EQ(has("7 messages refused, odometry: frame"), 1);
  EXPECT_LE(report.warnings.size(), 4U) << "the first of each kind alone";
}

/// A setting that is wrong for the bag: what would come of it is no run.
TEST_F(BagReplay, RefusesABagOfWhichNoOdometryCanBeUsed) {
  write_run();
  set({"frames/base=base_link"});
  const std::string line = refusal();
  EXPECT_EQ(line.rfind(request_.bag + ": no odometry message could be used, the first: ", 0), 0U) << line;
  EXPECT_NE(line.find("frames/base"), std::string::npos) << line;
}

/// The first picture is right, and the camera is then said to have turned round.
TEST_F(BagReplay, SaysHowLongItWasLost) {
  rosbag::Bag bag(request_.bag, rosbag::bagmode::Write);
  bag.write("/tf_static", ros::Time(kStart), camera_mounting());
  for (int i = 0; i < kSteps; ++i) {
    const double time = kStart + 0.05 * i;
    bag.write("/odom", ros::Time(time), odometry(time));
    LandmarkDetectionArray message = landmarks(time);
    for (LandmarkDetection& detection : message.detections) {
      if (i >= 4) detection.position.x *= -1.0;
    }
    bag.write("/landmarks", ros::Time(time + 0.03), message);
  }
  bag.close();
  set({"estimator/replace_after=0"});
  const ReplayReport report = replay_bag(request_);
  const auto told = std::find_if(report.warnings.begin(), report.warnings.end(),
                                 [](const std::string& line) { return line.rfind("lost for ", 0) == 0; });
  ASSERT_NE(told, report.warnings.end());
  EXPECT_NE(told->find(" of 100 detection messages"), std::string::npos) << *told;
}

TEST_F(BagReplay, SaysThatTheMapIsFull) {
  write_run();
  set({"estimator/max_landmarks=1"});
  const ReplayReport report = replay_bag(request_);
  const std::string end = "new landmarks refused, the map is full: estimator/max_landmarks is 1";
  EXPECT_EQ(std::count_if(report.warnings.begin(), report.warnings.end(),
                          [&](const std::string& line) { return line.find(end) != std::string::npos; }),
            1);
}

TEST_F(BagReplay, KeepsWhatItRanWithAndWhatItWarnedOf) {
  write_run();
  set({"estimator/type=ukf"});
  request_.warnings = {"a \"warning\" of the options"};
  replay_bag(request_);
  const std::string trajectory = out("trajectory.tum");
  const std::string summary = out("summary.json");
  for (const char* part : {"\"warnings\": [\"a \\\"warning\\\" of the options\"]",
                           "\"kinect_ekf_slam\": \"0.", "\"Eigen\": \"3.", "\"finished\": \"20"}) {
    EXPECT_NE(summary.find(part), std::string::npos) << part << " is not in\n" << summary;
  }
  request_.options = read_run_options({request_.output_directory + "/parameters.yaml"}, {},
                                      [](const std::string& line) { ADD_FAILURE() << line; });
  EXPECT_EQ(request_.options.pipeline.estimator.type, EstimatorOptions::Type::kUkf);
  replay_bag(request_);
  EXPECT_EQ(out("trajectory.tum"), trajectory) << "the same run again";
}

TEST_F(BagReplay, SaysThatThereIsNoSuchFile) {
  const std::string line = refusal();
  EXPECT_EQ(line.rfind(request_.bag + ": ", 0), 0U) << line;
  EXPECT_EQ(line.find('\n'), std::string::npos);
}

TEST_F(BagReplay, SaysThatAFileIsNoBag) {
  for (const std::string& text : {std::string(), std::string("hello"), std::string(10000, 'x')}) {
    write_text(request_.bag, text);
    const std::string line = refusal();
    EXPECT_EQ(line.rfind(request_.bag + ": not a readable bag: ", 0), 0U) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

TEST_F(BagReplay, SaysInWhichBagAMessageIsDamaged) {
  write_run();
  std::string bytes = read_text(request_.bag);
  const std::size_t name =
      bytes.find("base_footprint");  // in the first message that has one; its length comes before
  ASSERT_NE(name, std::string::npos);
  bytes.replace(name - 4, 4, "\xFF\xFF\xFF\x0F");
  write_text(request_.bag, bytes);
  const std::string line = refusal();
  EXPECT_EQ(line.rfind(request_.bag + ": not a readable bag: ", 0), 0U) << line;
}

TEST_F(BagReplay, MakesNoRoomForListsThatAreLongerThanTheirMessage) {
  LandmarkDetectionArray message = landmarks(kStart);
  message.detections[0].radius = 0.25F;
  message.detections[0].descriptor = {0.5F};
  rosbag::Bag bag(request_.bag, rosbag::bagmode::Write);
  bag.write("/odom", ros::Time(kStart), odometry(kStart));
  bag.write("/landmarks", ros::Time(kStart), message);
  bag.close();
  const std::string sound = read_text(request_.bag);
  const std::string frame = message.header.frame_id;
  const std::string radius("\x00\x00\x80\x3E", 4);
  const std::size_t after_frame = sound.find(frame) + frame.size();
  // 16 million detections; as many numbers as are four bytes long when 32 bits are all that counts them
  for (const auto& [at, length] :
       {std::pair(after_frame, std::string("\xFF\xFF\xFF\x00", 4)),
        std::pair(sound.find(radius, after_frame) + 4, std::string("\x01\x00\x00\x40", 4))}) {
    std::string bytes = sound;
    bytes.replace(at, 4, length);
    write_text(request_.bag, bytes);
    EXPECT_EQ(refusal(), request_.bag + ": not a readable bag: a list is longer than its message");
  }
}

TEST_F(BagReplay, SaysThatABagIsCutOff) {
  write_run();
  const std::string whole = read_text(request_.bag);
  for (const std::size_t size : {whole.size() / 4, whole.size() / 2, whole.size() - 100}) {
    write_text(request_.bag, whole.substr(0, size));
    const std::string line = refusal();
    EXPECT_EQ(line.rfind(request_.bag + ": ", 0), 0U) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

TEST_F(BagReplay, SaysThatThereIsNoOdometry) {
  {
    rosbag::Bag bag(request_.bag, rosbag::bagmode::Write);
    bag.write("/landmarks", ros::Time(kStart), landmarks(kStart));
    bag.write("/wheel_odom", ros::Time(kStart), odometry(kStart));
  }
  EXPECT_EQ(
      refusal(),
      request_.bag + ": no odometry on '/odom' (sync/odometry_topic); the bag has /landmarks, /wheel_odom");
}

TEST_F(BagReplay, SaysThatABagIsEmpty) {
  { const rosbag::Bag bag(request_.bag, rosbag::bagmode::Write); }
  EXPECT_EQ(refusal(), request_.bag + ": no odometry on '/odom' (sync/odometry_topic); the bag has nothing");
}

TEST_F(BagReplay, SaysThatATopicIsOfAnotherType) {
  {
    rosbag::Bag bag(request_.bag, rosbag::bagmode::Write);
    bag.write("/odom", ros::Time(kStart), odometry(kStart));
    bag.write("/landmarks", ros::Time(kStart), std_msgs::String());
  }
  EXPECT_EQ(refusal(), request_.bag +
                           ": '/landmarks' (sync/landmarks_topic) is std_msgs/String, expected "
                           "kinect_ekf_slam/LandmarkDetectionArray");
}

TEST_F(BagReplay, SaysWhereItCannotWrite) {
  write_run();
  write_text(folder_ / "file", "");
  request_.output_directory = folder_ / "file/out";
  EXPECT_EQ(refusal(), request_.output_directory + ": cannot be created: Not a directory");
}

TEST_F(BagReplay, LocalisesInAMapThatIsLoaded) {
  set({"map/directory=" + folder_.path(), "map/file_name=absent.yaml", "map/load_at_start=true",
       "mode=localization"});
  write_run();
  EXPECT_EQ(refusal(), folder_ / "absent.yaml" + ": cannot be read: No such file or directory");
}

}  // namespace
}  // namespace kinect_ekf_slam
