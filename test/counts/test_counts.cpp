// What the filters' work grows with, by counts and not by times: a busy machine changes nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "kinect_ekf_slam/estimators/compressed_ekf.h"
#include "kinect_ekf_slam/estimators/invariant_ekf.h"
#include "test/support/matchers.h"
#include "test/support/slam_scenario.h"

namespace {
std::size_t allocations = 0;
std::size_t allocated_bytes = 0;
}  // namespace

// The C library's own functions, behind which Eigen and operator new allocate.
extern "C" {
void* __libc_malloc(std::size_t size);                 // NOLINT
void* __libc_realloc(void* memory, std::size_t size);  // NOLINT
void* malloc(std::size_t size) {
  ++allocations;
  allocated_bytes += size;
  return __libc_malloc(size);
}
void* realloc(void* memory, std::size_t size) {
  ++allocations;
  allocated_bytes += size;
  return __libc_realloc(memory, size);
}
}

namespace kinect_ekf_slam {
namespace {

using testing::motion;
using testing::seen;

template <class FilterType>
struct Filter : public FilterType {
  static auto options() {
    EstimatorOptions options;
    options.active_radius = 6.0;
    return options;
  }
  explicit Filter(const PoseEstimate<Planar>& initial)
      : FilterType(options(), make_associator<Planar>(testing::known_identities()), initial) {}
};

PoseEstimate<Planar> start() { return testing::pose_at<Planar>({}, 0.01); }

/// Landmarks on a lane, two beside each metre of it; the robot drives up and down.
class Lane {
 public:
  explicit Lane(int landmarks) : landmarks_(landmarks) {}

  Eigen::Vector2d landmark(int i) const { return {0.5 * i, i % 2 == 0 ? 1.0 : -1.0}; }

  MotionStep<Planar> drive() {
    const double step = forth_ ? 0.1 : -0.1;
    x_ += step;
    if (x_ < 0.0 || x_ > 0.5 * landmarks_) forth_ = !forth_;
    return motion<Planar>(Se2(step, 0.0, 0.0), 1e-3);
  }

  /// The first `count` landmarks from the one beside the robot on, as what they are.
  void look(int count, std::vector<Observation<Planar>>* observations,
            std::vector<Assignment>* assignments) const {
    observations->clear();
    assignments->clear();
    const int first = std::clamp(static_cast<int>(2.0 * x_), 0, landmarks_ - count);
    for (int i = first; i < first + count; ++i) {
      observations->push_back(seen<Planar>(landmark(i) - Eigen::Vector2d(x_, 0.0), i));
      assignments->push_back({Verdict::kMatched, i, 1.0});
    }
  }

  /// All landmarks at once, as new ones.
  void show(KalmanSlam<Planar>* filter) const {
    std::vector<Observation<Planar>> observations;
    for (int i = 0; i < landmarks_; ++i) observations.push_back(seen<Planar>(landmark(i), i));
    filter->observe(1, observations);
  }

 private:
  int landmarks_;
  double x_ = 0.0;  ///< m
  bool forth_ = true;
};

/// Allocations of `steps` predictions and updates with six to nine landmarks in view.
std::size_t allocations_of(KalmanSlam<Planar>* filter, Lane* lane, int steps) {
  std::size_t count = 0;
  std::vector<Observation<Planar>> observations;
  std::vector<Assignment> assignments;
  for (int i = 0; i < steps; ++i) {
    const MotionStep<Planar> step = lane->drive();
    lane->look(6 + i % 4, &observations, &assignments);
    const std::size_t before = allocations;
    filter->predict(step);
    const UpdateReport report = filter->apply(2 + i, observations, std::move(assignments));
    count += allocations - before;
    EXPECT_EQ(report.dof, 2 * static_cast<int>(observations.size()));
  }
  return count;
}

TEST(Counts, SeeWhatEigenAndTheStandardLibraryAllocate) {
  const std::size_t before = allocations;
  const std::vector<double> vector(1000);
  const Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(100, 100);
  EXPECT_EQ(allocations - before, 2U) << vector.size() << matrix.size();
}

template <class Type>
class AllocationsOf : public ::testing::Test {};
using Filters = ::testing::Types<Ekf<Planar>, InvariantEkf<Planar>>;
TYPED_TEST_SUITE(AllocationsOf, Filters);

TYPED_TEST(AllocationsOf, AnUpdateAreNone) {
  for (const int landmarks : {20, 400}) {
    Filter<TypeParam> filter(start());
    Lane lane(landmarks);
    lane.show(&filter);
    allocations_of(&filter, &lane, 4);  // each number of landmarks in view once
    EXPECT_EQ(allocations_of(&filter, &lane, 40), 0U) << landmarks << " landmarks";
  }
}

/// What is stored is half of the matrix, and it is never moved: all that was ever allocated is little more.
TYPED_TEST(AllocationsOf, AGrowingMapAreHalfOfItsCovariance) {
  constexpr int kLandmarks = 1000;
  const Lane lane(kLandmarks);
  Filter<TypeParam> filter(start());
  const std::size_t before = allocated_bytes;
  for (int i = 0; i < kLandmarks; ++i) {
    filter.apply(1 + i, {seen<Planar>(lane.landmark(i), i)}, {{Verdict::kCreated, -1, 0.0}});
  }
  const double size = 3 + 2 * kLandmarks;
  EXPECT_LT(static_cast<double>(allocated_bytes - before), 1.1 * 0.5 * size * size * sizeof(double));
}

TEST(Counts, ACompressedEkfFiltersNoMoreInALargerMap) {
  int active = 0;
  for (const int landmarks : {100, 400}) {
    Filter<CompressedEkf<Planar>> filter(start());
    Lane lane(landmarks);
    lane.show(&filter);
    int most = 0;
    std::vector<Observation<Planar>> observations;
    std::vector<Assignment> assignments;
    for (int i = 0; i < 400; ++i) {
      filter.predict(lane.drive());
      lane.look(8, &observations, &assignments);
      filter.observe(2 + i, observations);
      if (filter.region_changes() > 0) most = std::max(most, filter.active_landmarks());
    }
    EXPECT_GT(filter.region_changes(), 10);
    EXPECT_LE(most, 40) << landmarks;
    if (active == 0) active = most;
    EXPECT_LE(most, active + 2) << landmarks << " landmarks";
  }
}

/// What a region tells the rest of the map is told in slices of equal size: the panels that one step touches.
TEST(Counts, NoStepOfPendingUpdatesTouchesMoreThanItsShare) {
  constexpr int kSize = 3 + 2 * 5000;  // not all panels at the first step
  SymmetricMatrix P(3);
  P.resize(kSize);
  PendingUpdates<Planar> pending;
  pending.add(Eigen::MatrixXd::Ones(kSize, 1), Eigen::MatrixXd::Ones(1, 1));
  const auto touched = [&P] {
    int panels = 0;
    for (int i = 0; i < P.panel_count(); ++i) panels += P.panel(i)(0, 0) != 0.0;
    return panels;
  };
  const int share = P.panel_count() / PendingUpdates<Planar>::kSteps + 1;
  for (int before = 0; before < P.panel_count();) {
    pending.advance(&P);
    const int now = touched();
    ASSERT_GT(now, before);
    ASSERT_LE(now - before, share);
    before = now;
  }
  for (int i = 1; i < P.panel_count(); ++i) {
    EXPECT_TRUE(P.panel(i).leftCols(P.first_row(i)).isConstant(-1.0, 0.0)) << "panel " << i;
  }
}

/// What rounding might do to a robot that never rests.
TYPED_TEST(AllocationsOf, AMillionUpdatesLeaveACovariance) {
  Filter<TypeParam> filter(start());
  Lane lane(4);
  lane.show(&filter);
  std::vector<Observation<Planar>> observations;
  std::vector<Assignment> assignments;
  for (int i = 0; i < 1000000; ++i) {
    filter.predict(lane.drive());
    lane.look(3, &observations, &assignments);
    filter.apply(2 + i, observations, std::move(assignments));
    if (i % 50000 == 0) {
      ASSERT_TRUE(testing::IsCovariance(filter.snapshot().covariance)) << i;
    }
  }
  ASSERT_TRUE(testing::IsCovariance(filter.snapshot().covariance));
}

}  // namespace
}  // namespace kinect_ekf_slam
