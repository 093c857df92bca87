#include "kinect_ekf_slam/ros/calibration_report.h"

#include <gtest/gtest.h>

#include <fstream>

#include "kinect_ekf_slam/ros/configuration.h"
#include "test/support/temporary_folder.h"

namespace kinect_ekf_slam {
namespace {

TEST(CalibrationReport, IsAConfigurationAlsoWhereNoParameterMayBe) {
  const std::vector<CalibratedValue> values = {{"input/linear_scale", "", 1.0, 0.97, 0.01, 0.03},
                                               {"sensor/depth_share", "", 0.0, -0.04, 0.05, 0.5},
                                               {"sensor yaw", "deg", 0.0, 1.5, 0.2, 3.0, false}};
  const std::string text = calibration_yaml(values, "run.bag");
  EXPECT_NE(text.find("found -0.04"), std::string::npos) << text;
  EXPECT_NE(text.find("#   sensor yaw"), std::string::npos) << text;
  const testing::TemporaryFolder folder;
  std::ofstream(folder / "calibration.yaml") << text;
  const RunOptions options = read_run_options({folder / "calibration.yaml"}, {}, [](const std::string& line) {
    ADD_FAILURE() << "a parameter not known: " << line;
  });
  EXPECT_EQ(options.pipeline.input.linear_scale, 0.97);
  EXPECT_EQ(options.pipeline.sensor.depth_share, 0.0);
}

}  // namespace
}  // namespace kinect_ekf_slam
