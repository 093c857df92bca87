#include <Eigen/Core>

#include "benchmark/benchmarks.h"
#include "benchmark/drive.h"
#include "benchmark/step_times.h"

#ifdef HAVE_BLAS
extern "C" void dsyrk_(const char* triangle, const char* transposed, const int* rows, const int* rank,
                       const double* alpha, const double* factor, const int* factor_stride,
                       const double* beta, double* matrix, const int* matrix_stride);
#endif

namespace kinect_ekf_slam::benchmarks {
namespace {

constexpr int kRank = 2 * kInView;

/// P -= U U^T, the lower half of it: by Eigen, by the system's BLAS, and one pass over that half alone.
class Half {
 public:
  explicit Half(int landmarks)
      : P_(Eigen::MatrixXd::Identity(3 + 2 * landmarks, 3 + 2 * landmarks)),
        U_(Eigen::MatrixXd::Constant(P_.rows(), kRank, 1e-9)) {}

  void eigen() { P_.selfadjointView<Eigen::Lower>().rankUpdate(U_, -1.0); }
#ifdef HAVE_BLAS
  void blas() {
    const int rows = static_cast<int>(P_.rows());
    const int rank = kRank;
    const double minus_one = -1.0;
    const double one = 1.0;
    dsyrk_("L", "N", &rows, &rank, &minus_one, U_.data(), &rows, &one, P_.data(), &rows);
  }
#endif
  void pass() {
    for (Eigen::Index col = 0; col < P_.cols(); ++col) P_.col(col).tail(P_.rows() - col).array() += 1e-9;
  }

 private:
  Eigen::MatrixXd P_, U_;
};

void run(benchmark::State& state, void (Half::*work)()) {
  Half half(static_cast<int>(state.range(0)));
  StepTimes times;
  for (auto _ : state) {
    times.measure(state, [&] { (half.*work)(); });
    benchmark::ClobberMemory();
  }
  times.report(state);
}

}  // namespace

void register_limits() {
  const auto add = [](const char* name, void (Half::*work)()) {
    benchmark::RegisterBenchmark(name, run, work)
        ->Arg(50)
        ->Arg(100)
        ->Arg(200)
        ->Arg(500)
        ->Arg(1000)
        ->Arg(2000)
        ->Iterations(60)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  };
  add("limit/rank16_eigen", &Half::eigen);
#ifdef HAVE_BLAS
  add("limit/rank16_blas", &Half::blas);
#endif
  add("limit/one_pass", &Half::pass);
}

}  // namespace kinect_ekf_slam::benchmarks
