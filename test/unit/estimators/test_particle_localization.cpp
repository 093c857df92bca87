#include "kinect_ekf_slam/estimators/particle_localization.h"

#include <gtest/gtest.h>

#include "kinect_ekf_slam/core/angles.h"
#include "kinect_ekf_slam/estimators/particles.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::AngleNear;
using testing::MatrixNear;
using testing::motion;
using Points = std::vector<Eigen::Vector2d>;

std::vector<LandmarkEstimate<Planar>> map_of(const Points& points,
                                             const std::vector<std::string>& labels = {}) {
  std::vector<LandmarkEstimate<Planar>> map;
  for (std::size_t i = 0; i < points.size(); ++i) {
    LandmarkEstimate<Planar> landmark;
    landmark.position_in_map = points[i];
    landmark.covariance = 0.02 * 0.02 * Eigen::Matrix2d::Identity();
    if (!labels.empty()) landmark.info.label_votes[labels[i]] = 5;
    map.push_back(landmark);
  }
  return map;
}

/// A robot that drives a circle and sees what is ahead of it, up to 4 m; stops when the search has an answer.
struct Drive {
  Points points;                    ///< that are really there
  std::vector<std::string> labels;  ///< of those, if any
  Se2 truth;

  std::optional<PoseEstimate<Planar>> run(ParticleLocalization<Planar>* search, int steps,
                                          std::uint64_t seed) {
    testing::Scenario<Planar> noise(seed, 0);
    for (int i = 0; i < steps; ++i) {
      const MotionStep<Planar> step = motion<Planar>(Se2::exp({0.1, 0.0, 0.08}), 0.005);
      truth = truth * step.delta * Se2::exp(noise.draw(step.covariance));
      std::vector<Observation<Planar>> observations;
      for (std::size_t k = 0; k < points.size(); ++k) {
        const Eigen::Vector2d in_base = truth.inverse() * points[k];
        if (in_base.x() < 0.3 || in_base.norm() > 4.0) continue;
        auto observation = testing::seen<Planar>(in_base, kNoId, 0.04);
        observation.position_in_base += noise.draw(observation.covariance);
        if (!labels.empty()) observation.signature.label = labels[k];
        observations.push_back(observation);
      }
      search->predict(step);
      if (const auto found = search->observe(observations)) return found;
    }
    return std::nullopt;
  }
};

const Points kScattered = {{1.0, 0.3},   {3.2, -0.8}, {2.1, 2.4}, {-1.5, 1.7},
                           {-2.2, -1.1}, {0.4, -2.6}, {4.0, 1.9}};

TEST(ParticleLocalization, FindsARobotAnywhere) {
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    LocalizationOptions options;
    options.seed = static_cast<int>(seed);
    ParticleLocalization<Planar> search(options, map_of(kScattered));
    testing::Scenario<Planar> random(seed, 1, 3.0);
    Drive drive{kScattered, {}, Se2(random.landmarks()[0], 0.2 * static_cast<double>(seed))};
    const auto found = drive.run(&search, 300, seed);
    if (!found) continue;
    ++count;
    EXPECT_TRUE(MatrixNear(found->map_from_base.translation(), drive.truth.translation(), 0.1)) << seed;
    EXPECT_TRUE(AngleNear(found->map_from_base.angle(), drive.truth.angle(), radians(5.0))) << seed;
    const auto error = local_difference<Planar>(found->map_from_base, drive.truth);
    EXPECT_LT(error.dot(found->covariance.ldlt().solve(error)), 30.0) << seed;
  }
  EXPECT_GE(count, 27) << "some circles do not come past four landmarks";
}

/// Half a turn brings this room onto itself: nobody can tell, and so the search must not say that it can.
TEST(ParticleLocalization, NeverAnswersWhereTheMapIsSymmetric) {
  Points room = {{1.0, 0.3}, {3.2, -0.8}, {2.1, 2.4}};
  for (std::size_t i = 0; i < 3; ++i) room.emplace_back(-room[i]);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    LocalizationOptions options;
    options.seed = static_cast<int>(seed);
    ParticleLocalization<Planar> search(options, map_of(room));
    EXPECT_FALSE((Drive{room, {}, Se2(0.5, -0.5, 1.0)}).run(&search, 200, seed)) << seed;
  }
}

TEST(ParticleLocalization, ColoursTellWhatPlacesCannot) {
  Points room = {{1.0, 0.3}, {3.2, -0.8}, {2.1, 2.4}};
  for (std::size_t i = 0; i < 3; ++i) room.emplace_back(-room[i]);
  const std::vector<std::string> labels = {"red", "green", "blue", "yellow", "red", "green"};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    ParticleLocalization<Planar> search({}, map_of(room, labels));
    Drive drive{room, labels, Se2(0.5, -0.5, 1.0)};
    const auto found = drive.run(&search, 400, seed);
    ASSERT_TRUE(found) << seed;
    EXPECT_TRUE(MatrixNear(found->map_from_base.translation(), drive.truth.translation(), 0.1)) << seed;
  }
}

/// The robot is in another room than the map's.
TEST(ParticleLocalization, NeverAnswersInAnotherRoom) {
  const Points other = {{1.8, 1.2}, {-0.9, 2.9}, {2.6, -2.2}, {-2.8, 0.4}, {-1.1, -2.7}, {0.9, -0.9}};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    ParticleLocalization<Planar> search({}, map_of(kScattered));
    EXPECT_FALSE((Drive{other, {}, Se2(0.5, -0.5, 1.0)}).run(&search, 400, seed)) << seed;
  }
}

/// A sensor that repeats itself is no evidence.
TEST(ParticleLocalization, StandingStillProvesNothing) {
  ParticleLocalization<Planar> search({}, map_of(kScattered));
  for (int i = 0; i < 500; ++i) {
    std::vector<Observation<Planar>> observations;
    for (const Eigen::Vector2d& point : kScattered)
      observations.push_back(testing::seen<Planar>(point, kNoId));
    EXPECT_FALSE(search.observe(observations));
  }
}

TEST(ParticleLocalization, WithoutAMapThereIsNothingToFind) {
  ParticleLocalization<Planar> search({}, {});
  EXPECT_FALSE((Drive{kScattered, {}, Se2()}).run(&search, 50, 1));
}

}  // namespace
}  // namespace kinect_ekf_slam
