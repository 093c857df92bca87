#include "kinect_ekf_slam/mapping/multi_hypothesis.h"

#include <gtest/gtest.h>

#include "kinect_ekf_slam/mapping/slam_factory.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace kinect_ekf_slam {
namespace {

using testing::MatrixNear;
using testing::motion;
using testing::pose_at;
using testing::PoseNear;
using testing::seen;

AssociationOptions several(int most = 30) {
  AssociationOptions options;
  options.type = AssociationOptions::Type::kMultiHypothesis;
  options.max_hypotheses = most;
  return options;
}

/// Maps two like landmarks 0.6 m apart and a third one; then slips by 0.35 m, of which the wheels know
/// nothing but that it may be. The first thing that it sees again is nearer to where the wrong one should be.
class Slipped {
 public:
  explicit Slipped(int most_hypotheses = 30)
      : slam_(make_slam<Planar>(testing::textbook(), several(most_hypotheses), LifeCycleOptions(),
                                pose_at<Planar>(Se2(), 1e-3))) {}
  UpdateReport look(const std::vector<Eigen::Vector2d>& landmarks) {
    std::vector<Observation<Planar>> observations;
    for (const Eigen::Vector2d& landmark : landmarks) {
      observations.push_back(seen<Planar>(truth_.inverse() * landmark, kNoId, 0.03));
    }
    return slam_->observe(to_nanoseconds(++seconds_), observations);
  }
  void make_a_map() {
    for (int i = 0; i < 5; ++i) look({kLeft, kRight, kFar});
  }
  void slip() {
    truth_ = Se2({0.0, 0.35}, 0.0);
    MotionStep<Planar> step = motion<Planar>(Se2(), 1e-3);
    step.covariance(1, 1) = 0.09;
    slam_->predict(step);
  }
  const Se2& truth() const { return truth_; }
  SlamEstimator<Planar>& slam() { return *slam_; }
  MultiHypothesis<Planar>& hypotheses() { return dynamic_cast<MultiHypothesis<Planar>&>(*slam_); }

  static const Eigen::Vector2d kLeft;
  static const Eigen::Vector2d kRight;
  static const Eigen::Vector2d kFar;

 private:
  std::unique_ptr<SlamEstimator<Planar>> slam_;
  Se2 truth_;
  double seconds_ = 0.0;
};
const Eigen::Vector2d Slipped::kLeft(1.5, 0.3);
const Eigen::Vector2d Slipped::kRight(1.5, -0.3);
const Eigen::Vector2d Slipped::kFar(3.0, 1.5);

TEST(MultiHypothesis, ALaterSightingRevisesAnAmbiguousOne) {
  Slipped run;
  run.make_a_map();
  const int left = run.slam().landmarks()[0].info.id;
  const int right = run.slam().landmarks()[1].info.id;
  run.slip();
  const UpdateReport first = run.look({Slipped::kLeft});
  ASSERT_EQ(first.assignments[0].landmark, right) << "nearer to what the wheels say";
  EXPECT_GT(run.hypotheses().hypotheses(), 1);
  const UpdateReport decisive = run.look({Slipped::kLeft, Slipped::kFar});
  ASSERT_EQ(decisive.revisions.size(), 1U);
  EXPECT_EQ(decisive.revisions[0].stamp, to_nanoseconds(6.0));
  EXPECT_EQ(decisive.revisions[0].assignment.verdict, Verdict::kMatched);
  EXPECT_EQ(decisive.revisions[0].assignment.landmark, left);
  EXPECT_TRUE(PoseNear(run.slam().pose().map_from_base, run.truth(), 0.03));
  EXPECT_EQ(run.slam().landmarks().size(), 3U);
  EXPECT_TRUE(MatrixNear(run.slam().landmarks()[0].position_in_map, Slipped::kLeft, 0.03));
}

TEST(MultiHypothesis, APositionDecidesBetweenThem) {
  Slipped run;
  run.make_a_map();
  run.slip();
  run.look({Slipped::kLeft});
  ASSERT_GT(run.hypotheses().hypotheses(), 1);
  EXPECT_FALSE(PoseNear(run.slam().pose().map_from_base, run.truth(), 0.3));
  GlobalPosition measured;
  measured.position_in_map = Planar::to_3d(run.truth().translation());
  measured.covariance.diagonal().setConstant(0.0025);
  constexpr double kWideGate = 1e6;
  EXPECT_EQ(run.slam().locate(PositionMeasurement<Planar>(measured), kNoId, kWideGate).verdict,
            PositionVerdict::kUsed);
  run.look({});
  EXPECT_TRUE(PoseNear(run.slam().pose().map_from_base, run.truth(), 0.03));
}

TEST(MultiHypothesis, OneHypothesisDecidesAtOnceAndStillWorks) {
  Slipped run(1);
  run.make_a_map();
  for (int i = 0; i < 5; ++i) {
    const UpdateReport report = run.look({Slipped::kLeft, Slipped::kRight, Slipped::kFar});
    EXPECT_TRUE(report.revisions.empty());
    for (const Assignment& assignment : report.assignments) EXPECT_EQ(assignment.verdict, Verdict::kMatched);
    EXPECT_EQ(run.hypotheses().hypotheses(), 1);
  }
  EXPECT_EQ(run.slam().landmarks().size(), 3U);
}

TEST(MultiHypothesis, ACopyGoesOnAlikeAndByItself) {
  Slipped run;
  run.make_a_map();
  run.slip();
  run.look({Slipped::kLeft});
  const auto copy = run.slam().clone();
  const Se2 before = copy->pose().map_from_base;
  const auto seen_now = [&](const Eigen::Vector2d& landmark) {
    return seen<Planar>(run.truth().inverse() * landmark, kNoId, 0.03);
  };
  const UpdateReport decisive = run.look({Slipped::kLeft, Slipped::kFar});
  EXPECT_TRUE(PoseNear(copy->pose().map_from_base, before, 0.0));
  const UpdateReport report =
      copy->observe(to_nanoseconds(7.0), {seen_now(Slipped::kLeft), seen_now(Slipped::kFar)});
  EXPECT_EQ(report.revisions.size(), decisive.revisions.size());
  EXPECT_TRUE(MatrixNear(copy->snapshot().covariance, run.slam().snapshot().covariance, 0.0));
  EXPECT_TRUE(PoseNear(copy->pose().map_from_base, run.slam().pose().map_from_base, 0.0));
}

TEST(MultiHypothesis, ARestoredMapIsTheOnlyHypothesis) {
  Slipped run;
  run.make_a_map();
  const SlamState<Planar> state = run.slam().snapshot();
  run.slip();
  run.look({Slipped::kLeft});
  run.slam().restore(state);
  EXPECT_EQ(run.hypotheses().hypotheses(), 1);
  EXPECT_TRUE(MatrixNear(run.slam().snapshot().covariance, state.covariance, 0.0));
  const UpdateReport report = run.look({{1.0, -3.0}});
  EXPECT_TRUE(report.revisions.empty()) << "what was told before is history";
  for (const LandmarkInfo& info : state.infos) EXPECT_NE(report.assignments[0].landmark, info.id);
}

TEST(MultiHypothesis, NeverAddsToAFixedMap) {
  Slipped run;
  run.make_a_map();
  run.slam().set_map_fixed(true);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(run.look({{1.0, -3.0}, Slipped::kFar}).assignments[0].verdict, Verdict::kClutter);
  }
  EXPECT_EQ(run.slam().landmarks().size(), 3U);
}

}  // namespace
}  // namespace kinect_ekf_slam
