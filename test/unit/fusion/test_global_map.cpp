#include "kinect_ekf_slam/fusion/global_map.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <set>
#include <stdexcept>

#include "kinect_ekf_slam/core/random_stream.h"
#include "kinect_ekf_slam/mapping/slam_factory.h"
#include "test/support/slam_scenario.h"
#include "test/support/spaces.h"

namespace kinect_ekf_slam {
namespace {

using testing::Scenario;

/// A robot among landmarks that makes a new local map each fifteen seconds, and something that knows the
/// global frame.
template <class Space>
class GlobalMapIn : public ::testing::Test {
 protected:
  static constexpr int kDim = Space::kPointDim;
  using Pose = typename Space::Pose;
  using Point = typename Space::Point;

  double sigma_ = 0.1;  ///< m, of the global places
  double turn_ = 0.15;  ///< rad a step: 0 is straight on
  Point antenna_in_base_ = Point::Zero();
  bool measures_attitude_ = false;
  std::vector<Pose> truth_;  ///< in the global frame, a second each
  std::vector<LocalMap<Space>> maps_;
  std::vector<Stamped<GlobalPlace<Space>>> places_;

  static Pose global_from_start() {
    typename Space::PoseVector twist;
    for (int i = 0; i < Space::kPoseDim; ++i) twist(i) = i < kDim ? 20.0 - 15.0 * i : 0.9 - 0.5 * i;
    return Pose::exp(twist);
  }

  void run(int seconds, int landmarks = 30) {
    Scenario<Space> scenario(1, landmarks);
    RandomStream random(7, 0);
    LocalMapOptions options;
    options.max_path_points = 15;
    options.max_position_sigma = options.max_turn_sigma_deg = options.gap_time = 1e3;
    const auto slam = make_local_maps<Space>(testing::textbook(), testing::known_identities(), {}, options,
                                             testing::pose_at<Space>(Pose(), 1e-4));
    typename Space::PoseVector twist = Space::PoseVector::Zero();
    twist(0) = 0.3;
    twist.template tail<1>()(0) = turn_;
    for (int second = 0; second <= seconds; ++second) {
      if (second > 0) slam->predict(scenario.drive(twist));
      const TimeNs stamp = to_nanoseconds(second);
      slam->observe(stamp, scenario.look());
      truth_.push_back(global_from_start() * scenario.true_pose());
      GlobalPlace<Space> place;
      place.antenna.mean = truth_.back() * antenna_in_base_ +
                           sigma_ * Point(Point::NullaryExpr([&] { return random.normal(); }));
      place.antenna.covariance = sigma_ * sigma_ * Space::PointMatrix::Identity();
      place.antenna_in_base = antenna_in_base_;
      if (measures_attitude_) {
        place.attitude = HeadingPrior<Space>{truth_.back(), 1e-4 * TurnMatrix<Space>::Identity()};
      }
      places_.push_back({stamp, place});
    }
    maps_ = slam->maps();
  }

  GlobalMap<Space> integrate(GlobalMapOptions options = {}) const {
    options.association = testing::known_identities();
    return integrate_maps<Space>(maps_, places_, options);
  }

  struct Errors {
    double rms = 0.0;   ///< m
    double nees = 0.0;  ///< of the position, its mean
  };
  Errors path_errors(const GlobalMap<Space>& map) const {
    Errors errors;
    double count = 0.0;
    for (const auto& segment : map.segments) {
      for (const auto& pose : segment.path) {
        const auto second = static_cast<std::size_t>(std::lround(to_seconds(pose.stamp)));
        const Point error = pose.value.map_from_base.translation() - truth_[second].translation();
        const typename Space::PointMatrix covariance =
            pose.value.covariance.template topLeftCorner<kDim, kDim>();
        errors.rms += error.squaredNorm();
        errors.nees += error.dot(covariance.llt().solve(error));
        count += 1.0;
      }
    }
    return {std::sqrt(errors.rms / count), errors.nees / count};
  }
};
TYPED_TEST_SUITE(GlobalMapIn, testing::Spaces, testing::SpaceNames);

TYPED_TEST(GlobalMapIn, IsTheWayAndTheLandmarksInTheGlobalFrame) {
  this->run(60);
  const auto map = this->integrate();
  ASSERT_GE(map.segments.size(), 4U);
  for (const auto& segment : map.segments) EXPECT_EQ(segment.refusal, "");
  const auto errors = this->path_errors(map);
  EXPECT_LT(errors.rms, 0.6 * this->sigma_) << "better than the positions";
  EXPECT_LT(errors.nees, 3.0 * TypeParam::kPointDim);
  EXPECT_GT(map.merged_landmarks, 5);
  std::set<int> identities;
  for (const auto& landmark : map.landmarks) {
    EXPECT_TRUE(identities.insert(landmark.info.source_id).second) << "twice in the map";
  }
}

TYPED_TEST(GlobalMapIn, IsNearlyTheSameWithFewerPlacesOfALongWay) {
  this->run(60);
  GlobalMapOptions options;
  options.max_places = 20;
  const auto few = this->integrate(options);
  const auto all = this->integrate();
  ASSERT_EQ(few.segments.size(), all.segments.size());
  for (std::size_t i = 0; i < all.segments.size(); ++i) {
    EXPECT_EQ(few.segments[i].path.size(), all.segments[i].path.size());
  }
  EXPECT_LT(this->path_errors(few).rms, 1.3 * this->path_errors(all).rms);
  EXPECT_LT(this->path_errors(few).nees, 3.0 * TypeParam::kPointDim);
}

/// The robot does not jump where one local map ends and the next one starts.
TYPED_TEST(GlobalMapIn, HangsTogether) {
  this->run(60, 0);  // no landmark that could hold the maps together
  const auto map = this->integrate();
  ASSERT_GE(map.segments.size(), 2U);
  for (std::size_t i = 1; i < map.segments.size(); ++i) {
    const auto& end = map.segments[i - 1].path.back();
    const auto& start = map.segments[i].path.front();
    ASSERT_EQ(end.stamp, start.stamp);
    EXPECT_LT((end.value.map_from_base.translation() - start.value.map_from_base.translation()).norm(), 0.01);
  }
}

TYPED_TEST(GlobalMapIn, KnowsWhereTheAntennaIs) {
  this->antenna_in_base_ = TypeParam::Point::Constant(0.5);
  this->run(30);
  EXPECT_LT(this->path_errors(this->integrate()).rms, this->sigma_);
  for (auto& place : this->places_) place.value.antenna_in_base.setZero();
  EXPECT_FALSE(this->path_errors(this->integrate()).rms < 0.3) << "taken for the base: wrong, or refused";
}

TYPED_TEST(GlobalMapIn, NeedsAHeadingWhereTheWayIsStraight) {
  this->turn_ = 0.0;
  this->sigma_ = 1.0;
  this->run(14, 0);
  const auto refused = this->integrate();
  ASSERT_EQ(refused.segments.size(), 1U);
  const char* what = TypeParam::kPointDim == 2 ? "near to one place that the heading" : "near to one line";
  EXPECT_NE(refused.segments[0].refusal.find(what), std::string::npos) << refused.segments[0].refusal;

  this->places_.clear();
  this->truth_.clear();
  this->measures_attitude_ = true;
  this->run(14, 0);
  const auto placed = this->integrate();
  EXPECT_EQ(placed.segments[0].refusal, "");
  EXPECT_LT(this->path_errors(placed).rms, 1.5);
}

/// Where the way tells the heading, nothing else is asked.
TYPED_TEST(GlobalMapIn, DoesNotNeedAnAttitudeWhereTheWayTellsTheHeading) {
  this->measures_attitude_ = true;
  this->run(28);  // two whole local maps
  for (auto& place : this->places_) {
    TurnVector<TypeParam> wrong = TurnVector<TypeParam>::Constant(1.0);
    place.value.attitude->global_from_local =
        turn_exp<TypeParam>(wrong) * turn_of<TypeParam>(place.value.attitude->global_from_local);
  }
  const auto map = this->integrate();
  for (const auto& segment : map.segments) EXPECT_EQ(segment.refusal, "");
  EXPECT_LT(this->path_errors(map).rms, this->sigma_);
}

TYPED_TEST(GlobalMapIn, LeavesOutWhatContradictsThePath) {
  this->run(30);
  this->places_[20].value.antenna.mean(0) += 30.0;
  const auto map = this->integrate();
  std::size_t left_out = 0;
  for (const auto& segment : map.segments) {
    for (const auto& disagreement : segment.disagreements) {
      ++left_out;
      EXPECT_EQ(disagreement.stamp, to_nanoseconds(20.0));
      EXPECT_NEAR((disagreement.value.by_global_position.mean - disagreement.value.by_path.mean).norm(), 30.0,
                  1.0);
    }
  }
  EXPECT_EQ(left_out, 1U);
}

TYPED_TEST(GlobalMapIn, RefusesPlacesThatAllContradictThePath) {
  this->run(30);
  RandomStream random(5, 0);
  for (auto& place : this->places_) {
    place.value.antenna.mean += 30.0 * TypeParam::Point::NullaryExpr([&] { return random.normal(); });
  }
  const auto map = this->integrate();
  ASSERT_EQ(map.segments.size(), 1U);
  EXPECT_NE(map.segments[0].refusal.find("global positions agree"), std::string::npos)
      << map.segments[0].refusal;
}

/// Without any position all would be one map, however long the run.
TYPED_TEST(GlobalMapIn, WaitsForPositionsInBoundedRoom) {
  this->run(100);
  this->places_.clear();
  GlobalMapOptions options;
  options.max_joined_points = 100;
  const auto map = this->integrate(options);
  EXPECT_GT(map.segments.size(), 1U);
  for (const auto& segment : map.segments) EXPECT_NE(segment.refusal, "");
  EXPECT_TRUE(map.landmarks.empty());
}

TYPED_TEST(GlobalMapIn, RefusesPlacesWhoseTimeGoesBack) {
  this->run(20);
  std::swap(this->places_[3].stamp, this->places_[4].stamp);
  try {
    this->integrate();
    FAIL() << "taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string(error.what()).rfind("global positions: time goes back by 1.0", 0), 0U)
        << error.what();
  }
}

}  // namespace
}  // namespace kinect_ekf_slam
