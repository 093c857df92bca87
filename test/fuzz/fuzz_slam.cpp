/// Damaged messages and files through everything that reads them: what cannot be used is refused with a
/// reason, what can be used leaves a finite estimate. FUZZ_ROUNDS says how often; scripts/faults.py runs it
/// long and with sanitizers.
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <yaml-cpp/yaml.h>

#include <boost/make_shared.hpp>
#include <cstdlib>
#include <limits>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/mapping/map_file.h"
#include "kinect_ekf_slam/ros/bag_replay.h"
#include "kinect_ekf_slam/ros/configuration.h"
#include "kinect_ekf_slam/ros/parameters.h"
#include "kinect_ekf_slam/ros/slam_session.h"
#include "test/support/map_samples.h"
#include "test/support/temporary_folder.h"

namespace kinect_ekf_slam {
namespace {

using testing::read_text;
using testing::write_text;

int rounds() {
  const char* given = std::getenv("FUZZ_ROUNDS");
  return given != nullptr ? std::atoi(given) : 300;
}

double any_number(RandomStream* random) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const double numbers[] = {0.0,   -0.0,  1.0,    -1.0, 1e-300, 1e9,
                            -1e18, 1e300, -1e300, kInf, -kInf,  std::numeric_limits<double>::quiet_NaN()};
  return numbers[random->index(std::size(numbers))];
}

std::string any_frame(RandomStream* random) {
  const std::string frames[] = {
      "", "/", "odom", "/odom", "base_footprint", "nowhere", "map", std::string(100000, 'x'), "a\nb"};
  return frames[random->index(std::size(frames))];
}

/// One number or another of a message, and sometimes its header.
template <std::size_t kCount>
void spoil(double* const (&numbers)[kCount], std_msgs::Header* header, RandomStream* random) {
  for (std::size_t damage = random->index(3); damage > 0; --damage)
    *numbers[random->index(kCount)] = any_number(random);
  if (random->index(10) == 0) header->frame_id = any_frame(random);
  const ros::Duration shift(static_cast<double>(random->index(200)) - 100.0);
  switch (random->index(30)) {
    case 0:
      header->stamp += shift;
      break;
    case 1:
      header->stamp.sec = 3;
      break;
    case 2:
      header->stamp.sec = 4294967295U;
      break;
    case 3:
      header->stamp = ros::Time();
      break;
    default:
      break;
  }
}

nav_msgs::Odometry odometry(const ros::Time& stamp) {
  nav_msgs::Odometry message;
  message.header.stamp = stamp;
  message.header.frame_id = "odom";
  message.child_frame_id = "base_footprint";
  message.pose.pose.orientation.w = 1.0;
  message.twist.twist.linear.x = 0.2;
  message.twist.twist.angular.z = 0.1;
  return message;
}

sensor_msgs::Imu imu(const ros::Time& stamp) {
  sensor_msgs::Imu message;
  message.header.stamp = stamp;
  message.header.frame_id = "base_footprint";
  message.angular_velocity.z = 0.1;
  return message;
}

/// `initialpose`, of RViz.
geometry_msgs::PoseWithCovarianceStamped person(const ros::Time& stamp) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = "map";
  message.pose.pose.orientation.w = 1.0;
  for (const std::size_t i : {0U, 7U, 35U}) message.pose.covariance[i] = 0.25;
  return message;
}

LandmarkDetectionArray detections(const ros::Time& stamp, RandomStream* random) {
  LandmarkDetectionArray message;
  message.header.stamp = stamp;
  message.header.frame_id = "base_footprint";
  message.detections.resize(random->index(50) == 0 ? 3000 : random->index(5));
  for (LandmarkDetection& detection : message.detections) {
    detection.position.x = 1.0 + static_cast<double>(random->index(10)) / 5.0;
    detection.position.y = static_cast<double>(random->index(10)) / 5.0 - 1.0;
    double* const numbers[] = {&detection.position.x,    &detection.position.y,    &detection.position.z,
                               &detection.covariance[0], &detection.covariance[1], &detection.covariance[4]};
    std_msgs::Header unused = message.header;
    if (random->index(4) == 0) spoil(numbers, &unused, random);
    if (random->index(20) == 0) detection.radius = static_cast<float>(any_number(random));
    if (random->index(20) == 0) detection.label = std::string(random->index(2000), 'L');
    if (random->index(20) == 0)
      detection.descriptor.assign(random->index(300), static_cast<float>(any_number(random)));
    detection.id = static_cast<int>(random->index(7)) - 1;
  }
  return message;
}

void expect_sound(const SlamSession& session, int round) {
  const Pose3d pose = session.pose_at(session.newest());
  ASSERT_TRUE(pose.map_from_base.matrix().allFinite()) << "in round " << round;
  ASSERT_TRUE(pose.covariance.allFinite()) << "in round " << round;
  ASSERT_GE(pose.covariance.diagonal().minCoeff(), 0.0) << "in round " << round;
}

TEST(FuzzSlam, DamagedMessagesLeaveAFiniteEstimate) {
  ros::Time::init();  // message_filters asks for a clock
  for (const std::string association : {"nearest_neighbor", "known", "jcbb", "multi_hypothesis"}) {
    const RunOptions options =
        read_run_options({}, {"association/type=" + association}, [](const std::string&) {});
    SlamSession session(options,
                        [](const std::string&, const std::string&, const ros::Time&) {
                          return std::optional<Eigen::Isometry3d>();
                        },
                        {[](const SensorFrame&, const SlamResult&) {}, [] {}, [](const std::string&) {}});
    RandomStream random(7, 0);
    ros::Time stamp(1000.0);
    for (int round = 0; round < rounds(); ++round) {
      stamp += ros::Duration(0.1);
      auto of_odometry = odometry(stamp);
      auto of_imu = imu(stamp);
      auto of_landmarks = detections(stamp, &random);
      double* const velocities[] = {&of_odometry.twist.twist.linear.x, &of_odometry.twist.twist.angular.z,
                                    &of_odometry.pose.pose.orientation.w, &of_odometry.pose.pose.position.x};
      double* const rates[] = {&of_imu.angular_velocity.x, &of_imu.angular_velocity.z,
                               &of_imu.angular_velocity_covariance[0]};
      if (round % 2 == 0) spoil(velocities, &of_odometry.header, &random);
      if (round % 2 == 1) spoil(rates, &of_imu.header, &random);
      session.input().add_landmarks(boost::make_shared<LandmarkDetectionArray>(of_landmarks), stamp);
      auto of_person = person(stamp);
      double* const places[] = {&of_person.pose.pose.position.x, &of_person.pose.pose.orientation.w,
                                &of_person.pose.covariance[0], &of_person.pose.covariance[1],
                                &of_person.pose.covariance[35]};
      spoil(places, &of_person.header, &random);
      if (const auto pose = session.input().initial_pose(of_person)) session.set_pose(*pose);
      if (round % 500 > 250) session.input().add_imu(boost::make_shared<sensor_msgs::Imu>(of_imu), stamp);
      session.input().add_odometry(boost::make_shared<nav_msgs::Odometry>(of_odometry), stamp);
      ASSERT_NO_FATAL_FAILURE(expect_sound(session, round)) << association;
    }
    EXPECT_GT(session.input().accepted().at("odometry"), static_cast<std::uint64_t>(rounds() / 4));
    EXPECT_FALSE(session.input().refusals().empty());
  }
}

/// Some bytes lost, doubled, changed, or replaced by what a parser stumbles over.
std::string damaged(std::string text, RandomStream* random) {
  const std::string snags[] = {"1e999",
                               ".nan",
                               "-",
                               "[",
                               "{",
                               "}",
                               "*a",
                               "&a ",
                               "!!binary ",
                               "\xff\xfe",
                               "\n\n",
                               ": ",
                               "0x",
                               "99999999999999999999",
                               "null",
                               std::string(5000, '['),
                               std::string(1, '\0')};
  for (std::size_t damage = 1 + random->index(3); damage > 0 && !text.empty(); --damage) {
    const std::size_t at = random->index(text.size());
    const std::size_t count = std::min(text.size() - at, random->index(40));
    switch (random->index(5)) {
      case 0:
        text[at] = static_cast<char>(random->index(256));
        break;
      case 1:
        text.erase(at, count);
        break;
      case 2:
        text.insert(at, text.substr(at, count));
        break;
      case 3:
        text.replace(at, std::min<std::size_t>(count, 4), snags[random->index(std::size(snags))]);
        break;
      default:
        if (random->index(10) == 0) text.resize(at);
    }
  }
  return text;
}

TEST(FuzzSlam, DamagedMapsAreRefusedOrFinite) {
  const testing::TemporaryFolder folder;
  const std::string path = folder / "map.yaml";
  write_map(path, "map", testing::sample_map(), "");
  const std::string sound = read_text(path);
  RandomStream random(8, 0);
  int refused = 0;
  for (int round = 0; round < rounds(); ++round) {
    write_text(path, damaged(sound, &random));
    try {
      const SavedState state = read_map(path, "map");
      ASSERT_TRUE(state.pose.allFinite() && state.landmarks_in_map.allFinite() &&
                  state.covariance.allFinite());
    } catch (const MapFileError& error) {
      ++refused;
      ASSERT_EQ(std::string(error.what()).rfind(path, 0), 0U) << error.what();
    }
  }
  EXPECT_GT(refused, rounds() / 4);
}

TEST(FuzzSlam, DamagedParametersAreRefusedOrInsideTheirBounds) {
  const testing::TemporaryFolder folder;
  const std::string path = folder / "slam.yaml";
  const std::string sound = read_text(CONFIG_FOLDER "/slam.yaml");
  RandomStream random(9, 0);
  int refused = 0;
  for (int round = 0; round < rounds(); ++round) {
    write_text(path, damaged(sound, &random));
    try {
      const RunOptions options = read_run_options({path}, {}, [](const std::string&) {});
      ASSERT_GT(options.output.marker_rate, 0.0);
    } catch (const ParameterError& error) {
      ++refused;
    }
  }
  EXPECT_GT(refused, rounds() / 20);
}

/// A bag's bytes, and where in them its messages lie.
class ShortBag {
 public:
  explicit ShortBag(const std::string& path) {
    RandomStream random(1, 0);
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    for (int i = 0; i < 10; ++i) {
      const ros::Time stamp(1000.0 + 0.1 * i);
      add("odom", odometry(stamp), &bag);
      add("imu", imu(stamp), &bag);
      add("landmarks", detections(stamp, &random), &bag);
    }
    bag.close();
    bytes_ = read_text(path);
  }
  /// A few bytes of one message are others. The bag's own structure stays: what rosbag makes of a broken one
  /// is its own.
  std::string damaged(RandomStream* random) const {
    std::string bytes = bytes_;
    const std::string& message = messages_[random->index(messages_.size())];
    const std::size_t at = bytes.find(message);
    for (std::size_t damage = 1 + random->index(4); damage > 0; --damage)
      bytes[at + random->index(message.size())] = static_cast<char>(random->index(256));
    return bytes;
  }

 private:
  template <class Message>
  void add(const std::string& topic, const Message& message, rosbag::Bag* bag) {
    bag->write(topic, message.header.stamp, message);
    const std::uint32_t length = ros::serialization::serializationLength(message);
    messages_.emplace_back(length, '\0');
    ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(messages_.back().data()), length);
    ros::serialization::serialize(stream, message);
  }

  std::string bytes_;
  std::vector<std::string> messages_;
};

TEST(FuzzSlam, DamagedMessagesInBagsAreRefusedOrReplayed) {
  const testing::TemporaryFolder folder;
  ReplayRequest request;
  request.bag = folder / "run.bag";
  request.options = read_run_options({}, {}, [](const std::string&) {});
  const ShortBag sound(request.bag);
  RandomStream random(10, 0);
  std::uint64_t refused = 0;
  for (int round = 0; round < rounds(); ++round) {
    write_text(request.bag, sound.damaged(&random));
    try {
      for (const auto& [reason, count] : replay_bag(request).refusals) refused += count;
    } catch (const std::runtime_error& error) {
      ++refused;
      const std::string line = error.what();
      ASSERT_EQ(line.rfind(request.bag, 0), 0U) << line;
      ASSERT_EQ(line.find('\n'), std::string::npos) << line;
    } catch (const std::exception& error) {
      FAIL() << "round " << round << ": " << typeid(error).name() << ": " << error.what();
    }
  }
  EXPECT_GT(refused, static_cast<std::uint64_t>(rounds() / 20));
}

}  // namespace
}  // namespace kinect_ekf_slam
