#include "kinect_ekf_slam/ros/markers.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>
#include <stdexcept>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/ros/conversions.h"
#include "kinect_ekf_slam/ros/trail.h"
#include "test/support/matchers.h"

namespace kinect_ekf_slam {
namespace {

using testing::AngleNear;
using testing::MatrixNear;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

/// Variances along and across an axis that is turned by `heading`.
Eigen::Matrix2d turned(double along, double across, double heading) {
  const Eigen::Matrix2d rotation = Se2(0.0, 0.0, heading).rotation();
  return rotation * Eigen::Vector2d(along, across).asDiagonal() * rotation.transpose();
}

/// An axis has two ends: headings that differ by half a turn are the same.
::testing::AssertionResult SameAxis(double left, double right) {
  return AngleNear(2.0 * left, 2.0 * right, 1e-9);
}

TEST(Ellipse, HasTheAxesAndHeadingOfTheCovariance) {
  for (int degrees = -180; degrees <= 180; degrees += 15) {
    const Ellipse shape = ellipse(turned(0.09, 0.04, radians(degrees)), 3.0);
    EXPECT_NEAR(shape.major, 0.9, 1e-12);
    EXPECT_NEAR(shape.minor, 0.6, 1e-12);
    EXPECT_TRUE(SameAxis(shape.heading, radians(degrees))) << degrees;
  }
}

TEST(Ellipse, MayBeALine) { EXPECT_NEAR(ellipse(turned(0.04, 0.0, 0.3), 1.0).minor, 0.0, 1e-9); }

TEST(Ellipse, IsRefusedWhereTheCovarianceIsNone) {
  EXPECT_THROW(ellipse(Eigen::Matrix2d::Zero(), 3.0), std::invalid_argument);
  EXPECT_THROW(ellipse(turned(0.04, -0.01, 0.3), 3.0), std::invalid_argument);
  EXPECT_THROW(ellipse(Eigen::Matrix2d::Constant(std::nan("")), 3.0), std::invalid_argument);
}

/// Covariance with these standard deviations along axes that are turned by `rotation`.
Eigen::Matrix3d turned(const Eigen::Vector3d& sigmas, const Eigen::Quaterniond& rotation) {
  return rotation * sigmas.cwiseAbs2().asDiagonal() * rotation.conjugate();
}

TEST(Ellipsoid, HasTheAxesOfTheCovarianceAndIsNeverMirrored) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> any;
  const Eigen::Vector3d sigmas(0.1, 0.3, 0.2);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond rotation =
        rotation_exp(Eigen::Vector3d::NullaryExpr([&] { return any(random); }));
    const Eigen::Matrix3d covariance = turned(sigmas, rotation);
    const Ellipsoid shape = ellipsoid(covariance, 3.0);
    EXPECT_TRUE(MatrixNear(shape.half_axes, Eigen::Vector3d(0.3, 0.6, 0.9), 1e-12));
    EXPECT_NEAR(shape.axes.determinant(), 1.0, 1e-12) << "RViz takes a rotation";
    const Eigen::Matrix3d again =
        shape.axes * (shape.half_axes / 3.0).cwiseAbs2().asDiagonal() * shape.axes.transpose();
    EXPECT_TRUE(MatrixNear(again, covariance, 1e-12));
  }
}

TEST(Ellipsoid, IsRefusedWhereTheCovarianceIsNone) {
  EXPECT_THROW(ellipsoid(Eigen::Matrix3d::Zero(), 3.0), std::invalid_argument);
  EXPECT_THROW(ellipsoid(Eigen::Vector3d(1.0, -0.1, 1.0).asDiagonal(), 3.0), std::invalid_argument);
  EXPECT_THROW(ellipsoid(Eigen::Matrix3d::Constant(std::nan("")), 3.0), std::invalid_argument);
}

Landmark3d landmark(int id, const std::string& label = "") {
  Landmark3d landmark;
  landmark.id = id;
  landmark.label = label;
  landmark.position_in_map = {1.0 * id, 0.0, 0.0};
  landmark.covariance.topLeftCorner<2, 2>() = turned(0.09, 0.04, 0.5);
  return landmark;
}

const Marker* find(const MarkerArray& array, const std::string& space, int id = 0) {
  for (const Marker& marker : array.markers) {
    if (marker.ns == space && marker.id == id) return &marker;
  }
  return nullptr;
}

double yaw(const geometry_msgs::Quaternion& q) { return 2.0 * std::atan2(q.z, q.w); }

TEST(MarkerPainter, DrawsEllipsesAtTheSigmasAskedFor) {
  MarkerPainter painter("map", 2.0);
  const MarkerArray array = painter.paint({{landmark(1)}, {}, {}, {}, {}});
  const Marker* spread = find(array, "covariance", 1);
  ASSERT_NE(spread, nullptr);
  EXPECT_EQ(spread->action, Marker::ADD);
  EXPECT_NEAR(spread->scale.x, 2.0 * 2.0 * 0.3, 1e-9) << "a scale is a diameter";
  EXPECT_NEAR(spread->scale.y, 2.0 * 2.0 * 0.2, 1e-9);
  EXPECT_TRUE(SameAxis(yaw(spread->pose.orientation), 0.5));
  EXPECT_EQ(spread->header.frame_id, "map");
}

TEST(MarkerPainter, DrawsEllipsoidsInSpace) {
  const Eigen::Quaterniond rotation = rotation_exp({0.4, -0.3, 0.8});
  MarkerScene scene{{landmark(1, "red")}, {}, {}, {}, {}};
  scene.map[0].position_in_map = {1.0, 2.0, 3.0};
  scene.map[0].radius = 0.1;
  scene.map[0].covariance = scene.pose.covariance.topLeftCorner<3, 3>() = turned({0.1, 0.2, 0.3}, rotation);
  MarkerPainter painter("map", 2.0, SpaceType::kSpatial);
  const MarkerArray array = painter.paint(scene);
  for (const auto& [space, id] : {std::pair("covariance", 1), {"robot_position", 0}}) {
    const Marker* spread = find(array, space, id);
    ASSERT_NE(spread, nullptr);
    EXPECT_EQ(spread->type, Marker::SPHERE);
    EXPECT_TRUE(MatrixNear(to_eigen(spread->scale), 2.0 * 2.0 * Eigen::Vector3d(0.1, 0.2, 0.3), 1e-9));
    const Eigen::Matrix3d axes = to_eigen(spread->pose).linear();
    EXPECT_TRUE(MatrixNear((axes.transpose() * rotation.toRotationMatrix()).cwiseAbs(),
                           Eigen::Matrix3d::Identity(), 1e-9))
        << "the same axes, whichever way they point";
  }
  const Marker* body = find(array, "landmarks", 1);
  EXPECT_EQ(body->type, Marker::SPHERE);
  EXPECT_EQ(body->pose.position.z, 3.0);
  EXPECT_EQ(body->scale.z, 0.2);
}

TEST(MarkerPainter, NeverDrawsAnUnknownCovarianceAsZero) {
  for (const Eigen::Matrix3d& unknown :
       {Eigen::Matrix3d(Eigen::Matrix3d::Zero()), Eigen::Matrix3d(Eigen::Matrix3d::Constant(std::nan(""))),
        Eigen::Matrix3d(-Eigen::Matrix3d::Identity())}) {
    for (const SpaceType space : {SpaceType::kPlanar, SpaceType::kSpatial}) {
      MarkerPainter painter("map", 3.0, space);
      MarkerScene scene{{landmark(1)}, {}, {}, {}, {}};
      scene.map[0].covariance = unknown;
      scene.pose.covariance.topLeftCorner<3, 3>() = unknown;
      scene.pose.covariance(5, 5) = std::nan("");
      const MarkerArray array = painter.paint(scene);
      EXPECT_EQ(find(array, "covariance", 1)->action, Marker::DELETE);
      EXPECT_EQ(find(array, "landmarks", 1)->action, Marker::ADD);
      EXPECT_EQ(find(array, "robot_position")->action, Marker::DELETE);
      EXPECT_EQ(find(array, "robot_heading")->action, Marker::DELETE);
    }
  }
}

TEST(MarkerPainter, DrawsFaintlyWhatIsNotConfirmedYet) {
  for (const SpaceType space : {SpaceType::kPlanar, SpaceType::kSpatial}) {
    MarkerPainter painter("map", 3.0, space);
    MarkerScene scene{{landmark(1, "red"), landmark(2, "red"), landmark(3)}, {}, {}, {}, {}};
    scene.map[1].confirmed = scene.map[2].confirmed = false;
    const MarkerArray array = painter.paint(scene);
    for (const char* part : {"landmarks", "labels", "covariance"}) {
      const float sure = find(array, part, 1)->color.a;
      const float unsure = find(array, part, 2)->color.a;
      EXPECT_LT(unsure, 0.5F * sure) << part;
      EXPECT_GT(unsure, 0.1F) << part << ": still seen";
      EXPECT_EQ(find(array, part, 2)->color.r, find(array, part, 1)->color.r) << part;
    }
    EXPECT_EQ(find(array, "landmarks", 1)->color.a, 1.0F);
    EXPECT_EQ(find(array, "labels", 1)->text, "1 red\n\n");
    EXPECT_EQ(find(array, "labels", 2)->text, "2 red?\n\n");
    EXPECT_EQ(find(array, "labels", 3)->text, "3?\n\n");

    scene.map[1].confirmed = true;
    const MarkerArray later = painter.paint(scene);
    EXPECT_EQ(find(later, "landmarks", 2)->color.a, 1.0F) << "from its confirmation on like the others";
    EXPECT_EQ(find(later, "labels", 2)->text, "2 red\n\n");
  }
}

TEST(MarkerPainter, RemovesTheLandmarksThatHaveGone) {
  MarkerPainter painter("map", 3.0);
  painter.paint({{landmark(1), landmark(2)}, {}, {}, {}, {}});
  const MarkerArray array = painter.paint({{landmark(2)}, {}, {}, {}, {}});
  for (const char* space : {"landmarks", "labels", "covariance"}) {
    ASSERT_NE(find(array, space, 1), nullptr) << space;
    EXPECT_EQ(find(array, space, 1)->action, Marker::DELETE) << space;
    EXPECT_EQ(find(array, space, 2)->action, Marker::ADD) << space;
  }
  EXPECT_EQ(find(painter.paint({{landmark(2)}, {}, {}, {}, {}}), "landmarks", 1), nullptr) << "told once";
}

TEST(MarkerPainter, ClearsAll) {
  MarkerPainter painter("map", 3.0);
  painter.paint({{landmark(1)}, {}, {}, {}, {}});
  const MarkerArray array = painter.clear();
  ASSERT_EQ(array.markers.size(), 1U);
  EXPECT_EQ(array.markers[0].action, Marker::DELETEALL);
  EXPECT_EQ(find(painter.paint({}), "landmarks", 1), nullptr);
}

TEST(MarkerPainter, HeadingWedgeIsAsWideAsTheHeadingIsUnsure) {
  MarkerPainter painter("map", 3.0);
  MarkerScene scene;
  scene.pose.covariance(5, 5) = 0.1 * 0.1;
  const MarkerArray array = painter.paint(scene);
  const Marker* wedge = find(array, "robot_heading");
  ASSERT_GE(wedge->points.size(), 3U);
  EXPECT_NEAR(std::atan2(wedge->points[1].y, wedge->points[1].x), -0.3, 1e-9);
  EXPECT_NEAR(std::atan2(wedge->points.back().y, wedge->points.back().x), 0.3, 1e-9);
}

TEST(MarkerPainter, DrawsALineToWhatWasJustAssociated) {
  MarkerPainter painter("map", 3.0);
  MarkerScene scene{{landmark(1)}, {}, {DetectionOutcome(), DetectionOutcome(), DetectionOutcome()}, {}, {}};
  scene.outcomes[0].verdict = Verdict::kMatched;
  scene.outcomes[0].landmark_id = 1;
  scene.outcomes[1].verdict = Verdict::kOutsideGate;
  scene.outcomes[1].position_in_map = {4.0, 5.0, 0.0};
  scene.outcomes[2].position_in_map.setConstant(std::nan(""));
  const MarkerArray array = painter.paint(scene);
  const Marker* lines = find(array, "associations");
  ASSERT_EQ(lines->points.size(), 4U) << "none to a place that is no number";
  EXPECT_EQ(lines->points[1].x, 1.0);
  EXPECT_EQ(lines->points[3].y, 5.0);
  EXPECT_EQ(find(painter.paint({}), "associations")->action, Marker::DELETE);
}

TEST(MarkerPainter, PaintsEachStretchOfAGlobalMapAndWhatWasLeftOut) {
  MarkerPainter painter("earth", 3.0);
  GlobalMap3d map;
  map.landmarks = {landmark(1)};
  map.segments.resize(3);
  map.segments[0].path.resize(2);
  map.segments[1].refusal = "too few positions";  // without a path
  map.segments[2].path.resize(2);
  map.segments[2].left_out.push_back({0, {1.0, 0.0, 0.0}, {5.0, 0.0, 0.0}, 40.0});
  const MarkerArray array = painter.paint_global(map);
  EXPECT_EQ(array.markers.front().action, Marker::DELETEALL) << "of the map before";
  EXPECT_NE(find(array, "landmarks", 1), nullptr);
  ASSERT_NE(find(array, "segments", 0), nullptr);
  EXPECT_EQ(find(array, "segments", 1), nullptr);
  ASSERT_NE(find(array, "segments", 2), nullptr);
  EXPECT_NE(find(array, "segments", 0)->color.r, find(array, "segments", 2)->color.r);
  ASSERT_NE(find(array, "left_out", 2), nullptr);
  EXPECT_EQ(find(array, "left_out", 2)->points[1].x, 5.0);
}

TEST(LabelColor, IsTheOneThatTheLabelNames) {
  EXPECT_GT(label_color("red").r, label_color("red").g + 0.5F);
  EXPECT_GT(label_color("green").g, label_color("green").r + 0.4F);
  EXPECT_GT(label_color("blue").b, label_color("blue").r + 0.5F);
  EXPECT_EQ(label_color("").r, label_color("").g);
}

TEST(LabelColor, OfAnyOtherLabelStaysTheSame) {
  const auto color = label_color("cylinder 12");
  EXPECT_EQ(color.r, label_color("cylinder 12").r);
  EXPECT_EQ(color.a, 1.0F);
  EXPECT_LE(std::max({color.r, color.g, color.b}), 1.0F);
  EXPECT_GE(std::min({color.r, color.g, color.b}), 0.0F);
}

geometry_msgs::Point point(double x) {
  geometry_msgs::Point point;
  point.x = x;
  return point;
}

TEST(Trail, KeepsAPointEachStep) {
  Trail trail(0.1, 100);
  EXPECT_TRUE(trail.add(point(0.0)));
  EXPECT_FALSE(trail.add(point(0.09)));
  EXPECT_TRUE(trail.add(point(0.11)));
  EXPECT_EQ(trail.points().size(), 2U);
  trail.clear();
  EXPECT_TRUE(trail.points().empty());
}

TEST(Trail, DropsTheOldestOfTooMany) {
  for (const std::size_t length : {1U, 2U, 7U, 50U}) {
    Trail trail(0.1, length);
    for (int i = 0; i < 200; ++i) {
      trail.add(point(i));
      EXPECT_LE(trail.points().size(), length);
      EXPECT_EQ(trail.points().back().x, i);
    }
    EXPECT_GE(2 * trail.points().size() + 1, length);
  }
}

TEST(MarkerPainter, ShowsBeaconsAsCubesWithWhereTheyMayBe) {
  MarkerScene scene;
  scene.beacons.resize(1);
  scene.beacons[0].id = 7;
  scene.beacons[0].position_in_map = {1.0, 2.0, 3.0};
  scene.beacons[0].covariance = 0.04 * Eigen::Matrix3d::Identity();
  MarkerPainter painter("map", 3.0, SpaceType::kSpatial);
  std::vector<Marker> cubes;
  std::vector<Marker> spreads;
  for (const Marker& marker : painter.paint(scene).markers) {
    if (marker.ns == "beacons") cubes.push_back(marker);
    if (marker.ns == "beacon_covariance") spreads.push_back(marker);
  }
  ASSERT_EQ(cubes.size(), 1U);
  EXPECT_EQ(cubes[0].id, 7);
  EXPECT_EQ(cubes[0].type, Marker::CUBE);
  EXPECT_EQ(cubes[0].pose.position.z, 3.0);
  ASSERT_EQ(spreads.size(), 1U);
  EXPECT_NEAR(spreads[0].scale.x, 2.0 * 3.0 * 0.2, 1e-9);
}

}  // namespace
}  // namespace kinect_ekf_slam
