#include "kinect_ekf_slam/simulation/world.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "kinect_ekf_slam/core/angles.h"
#include "test/support/matchers.h"
#include "test/unit/simulation/small_world.h"

namespace kinect_ekf_slam::testing {
namespace {

const std::string kSmallest = R"(
room: {size: [4.0, 3.0]}
landmarks: [{id: 1, label: red, x: 1.0, y: 2.0, z: 0.2, radius: 0.05}]
drive: {start: {x: 2.0, y: 1.0, yaw_deg: 90.0}}
gyro: {base_from_imu: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}}
sensor: {base_from_optical: {xyz: [0.1, 0, 0.25], rpy_deg: [-90, 0, -90]}}
)";

std::string error_of(const std::string& yaml) {
  try {
    parse_world(yaml, "w.yaml");
  } catch (const WorldFileError& error) {
    return error.what();
  }
  return "no error";
}

/// The smallest world with one piece of its text exchanged.
std::string error_with(const std::string& piece, const std::string& other) {
  std::string yaml = kSmallest;
  const auto place = yaml.find(piece);
  EXPECT_NE(place, std::string::npos) << piece;
  return error_of(yaml.replace(place, piece.size(), other));
}

std::string shipped(const std::string& name) {
  return (std::filesystem::path(__FILE__).parent_path() / "../../../config/worlds" / name).string();
}

TEST(World, ReadsTheSmallest) {
  const World world = parse_world(kSmallest, "w.yaml");
  EXPECT_EQ(world.landmarks.size(), 1U);
  EXPECT_FALSE(world.is_spatial());
  EXPECT_TRUE(PoseNear(Planar::pose_from_3d(world.drive.world_from_start.to_3d()),
                       Se2(2.0, 1.0, radians(90.0)), 1e-12));
  EXPECT_TRUE(MatrixNear(world.sensor.base_from_optical * Eigen::Vector3d(0.0, 0.0, 1.0),
                         Eigen::Vector3d(1.1, 0.0, 0.25), 1e-12))
      << "depth is forward";
  EXPECT_TRUE(MatrixNear(world.sensor.base_from_optical.linear() * Eigen::Vector3d::UnitX(),
                         Eigen::Vector3d(0.0, -1.0, 0.0), 1e-12))
      << "X is right";
}

TEST(World, ErrorsAreOneExactLine) {
  const std::map<std::pair<std::string, std::string>, std::string> cases = {
      {{"size: [4.0, 3.0]", "size: [4.0]"}, "room/size: '[4.0]' given, allowed: [x, y] in m"},
      {{"size: [4.0, 3.0]", "sise: [4.0, 3.0]"}, "room/size: is missing, allowed: [x, y] in m"},
      {{"x: 1.0", "x: 4.5"}, "landmarks[0]/x: '4.5' given, allowed: a number from 0 to 4"},
      {{"x: 1.0", "x: .nan"}, "landmarks[0]/x: '.nan' given, allowed: a number from 0 to 4"},
      {{"id: 1", "id: one"}, "landmarks[0]/id: 'one' given, allowed: a whole number from 0 to 1000000"},
      {{"radius: 0.05", "radios: 0.05"},
       "landmarks[0]/radius: is missing, allowed: a number from 0.001 to 10"},
      {{"radius: 0.05", "radius: 0.05, colour: red"},
       "landmarks[0]/colour: is not known, allowed: id, label, radius, x, y, z"},
      {{"x: 2.0", "x: 0.1"}, "drive/start/x: '0.1' given, allowed: a number from 0.18 to 3.82"},
      {{"drive: {", "drive: {loops: 0, "},
       "drive/loops: '0' given, allowed: a whole number from 1 to 1000000"},
      {{"drive: {", "drive: {waypoints: [[1, 9]], "},
       "drive/waypoints[0][1]: '9' given, allowed: a number from 0.18 to 2.82"},
      {{"sensor: {", "sensor: {miss_rate: 1.5, "},
       "sensor/miss_rate: '1.5' given, allowed: a number from 0 to 1"},
      {{"sensor: {", "sensor: {reports_identity: perhaps, "},
       "sensor/reports_identity: 'perhaps' given, allowed: true or false"},
      {{"rpy_deg: [0, 0, 0]", "rpy: [0, 0, 0]"},
       "gyro/base_from_imu/rpy_deg: is missing, allowed: three numbers"},
      {{"drive: {start", "robots: 2\ndrive: {start"},
       "robots: is not known, allowed: beacons, camera, drive, gps, gyro, landmarks, panels, room, sensor, "
       "space, wheels"},
  };
  for (const auto& [change, line] : cases) {
    EXPECT_EQ(error_with(change.first, change.second), "w.yaml: " + line);
  }
}

TEST(World, InSpaceHasHeights) {
  const std::string yaml = R"(
space: spatial
room: {size: [4.0, 3.0, 2.5]}
landmarks: [{id: 1, label: red, x: 1.0, y: 2.0, z: 2.2, radius: 0.05}]
drive: {start: {x: 2.0, y: 1.0, z: 1.5, pitch_deg: -90.0, yaw_deg: 90.0}, waypoints: [[1.0, 1.0, 2.0]]}
gyro: {base_from_imu: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}}
sensor: {base_from_optical: {xyz: [0.1, 0, 0.25], rpy_deg: [-90, 0, -90]}}
)";
  const World world = parse_world(yaml, "w.yaml");
  ASSERT_TRUE(world.is_spatial());
  const Eigen::Isometry3d start = world.drive.world_from_start.to_3d();
  EXPECT_TRUE(MatrixNear(start.translation(), Eigen::Vector3d(2.0, 1.0, 1.5), 1e-12));
  EXPECT_TRUE(MatrixNear(start.linear().col(0), Eigen::Vector3d::UnitZ(), 1e-12)) << "it looks up";
  EXPECT_TRUE(MatrixNear(world.drive.waypoints_in_world[0], Eigen::Vector3d(1.0, 1.0, 2.0), 0.0));
  const auto error_with = [&](const std::string& piece, const std::string& other) {
    std::string changed = yaml;
    return error_of(changed.replace(changed.find(piece), piece.size(), other));
  };
  EXPECT_EQ(error_with("2.5]}", "]}"), "w.yaml: room/size: '[4.0, 3.0]' given, allowed: [x, y, z] in m");
  EXPECT_EQ(error_with("z: 2.2", "z: 2.6"),
            "w.yaml: landmarks[0]/z: '2.6' given, allowed: a number from 0 to 2.5");
  EXPECT_EQ(error_with("[1.0, 1.0, 2.0]", "[1.0, 1.0]"),
            "w.yaml: drive/waypoints[0]: '[1.0, 1.0]' given, allowed: [x, y, z] in m");
  EXPECT_EQ(error_with("space: spatial", "space: hyperbolic"),
            "w.yaml: space: 'hyperbolic' given, allowed: planar, spatial");
}

TEST(World, SaysWhatPicturesShow) {
  const std::string yaml = kSmallest + R"(
panels: [{x: 4.0, y: 1.0, z: 0.5, facing_deg: 180.0, size: 0.2, print: fiducial, id: 7}]
camera: {rate: 5.0, width: 320, height: 240, focal_length: 262.5, errors: false}
)";
  const World plain = parse_world(kSmallest, "w.yaml");
  EXPECT_EQ(plain.pictures.rate, 0.0);
  EXPECT_TRUE(plain.panels.empty());
  const World world = parse_world(yaml, "w.yaml");
  EXPECT_EQ(world.pictures.rate, 5.0);
  EXPECT_EQ(world.pictures.camera.width, 320);
  EXPECT_FALSE(world.pictures.has_errors);
  ASSERT_EQ(world.panels.size(), 1U);
  EXPECT_EQ(world.panels[0].print, WorldPanel::Print::kFiducial);
  EXPECT_EQ(world.panels[0].id, 7);
  const auto error_with = [&](const std::string& piece, const std::string& other) {
    std::string changed = yaml;
    return error_of(changed.replace(changed.find(piece), piece.size(), other));
  };
  EXPECT_EQ(error_with("print: fiducial", "print: photo"),
            "w.yaml: panels[0]/print: 'photo' given, allowed: blotches, fiducial");
  EXPECT_EQ(error_with("id: 7", "id: 50"),
            "w.yaml: panels[0]/id: '50' given, allowed: a whole number from 0 to 49");
  EXPECT_EQ(error_with("x: 4.0", "x: 4.1"),
            "w.yaml: panels[0]/x: '4.1' given, allowed: a number from 0 to 4");
  EXPECT_EQ(error_with("rate: 5.0", "rate: fast"),
            "w.yaml: camera/rate: 'fast' given, allowed: a number from 0 to 1000");
  EXPECT_EQ(error_with("size: [4.0, 3.0]", "size: [4.0, 3.0], surface: wood"),
            "w.yaml: room/surface: 'wood' given, allowed: plain, blotches");
}

TEST(World, RefusesOneIdTwice) {
  EXPECT_EQ(
      error_with("radius: 0.05}]", "radius: 0.05}, {id: 1, label: red, x: 3, y: 2, z: 0.2, radius: 0.05}]"),
      "w.yaml: landmarks[1]/id: '1' given, allowed: a number that no other landmark has");
}

TEST(World, RefusesWhatIsNoWorld) {
  EXPECT_EQ(error_of("[1, 2]"), "w.yaml: '[1, 2]' given, allowed: a map of keys and values");
  EXPECT_EQ(error_of("room: [").rfind("w.yaml: not YAML: ", 0), 0U);
  EXPECT_THROW(read_world("/nowhere/world.yaml"), WorldFileError);
}

/// The worlds that the documents and the recorded runs use.
class ShippedWorld : public ::testing::TestWithParam<const char*> {};

TEST_P(ShippedWorld, IsDrivenThroughAndShowsEveryLandmark) {
  const World world = read_world(shipped(GetParam()));
  Simulator simulator(world, 1);
  std::map<int, int> sightings;
  double seconds = 0.0;
  while (!simulator.finished() && seconds < 150.0) {
    const Sample sample = simulator.next();
    seconds = to_seconds(sample.stamp);
    if (!sample.sightings) continue;
    for (const Sighting& sighting : *sample.sightings) ++sightings[sighting.id];
  }
  EXPECT_TRUE(simulator.finished());
  for (const WorldLandmark& landmark : world.landmarks) {
    EXPECT_GT(sightings[landmark.id], 50) << landmark.id;
    for (const WorldLandmark& other : world.landmarks) {
      if (other.id == landmark.id) continue;
      EXPECT_GE((other.position_in_world - landmark.position_in_world).norm(), 0.6);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShippedWorld,
                         ::testing::Values("room.yaml", "room_hard.yaml", "room_3d.yaml",
                                           "room_textured.yaml"));

}  // namespace
}  // namespace kinect_ekf_slam::testing
