#include "kinect_ekf_slam/ros/configuration.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "kinect_ekf_slam/perception/palette.h"
#include "kinect_ekf_slam/ros/detector_options.h"
#include "kinect_ekf_slam/ros/parameters.h"
#include "test/support/temporary_folder.h"

namespace kinect_ekf_slam {
namespace {

using testing::message_of;

TEST(SetParameter, TakesYamlAndRefusesTheRest) {
  YAML::Node yaml;
  set_parameter("a/b=[1, 2]", &yaml);
  set_parameter("a/c=x=y", &yaml);
  set_parameter("mode=slam", &yaml);
  EXPECT_EQ(yaml["a"]["b"][1].as<int>(), 2);
  EXPECT_EQ(yaml["a"]["c"].as<std::string>(), "x=y");
  EXPECT_EQ(yaml["mode"].as<std::string>(), "slam");
  EXPECT_EQ(message_of<ParameterError>([&] { set_parameter("a/b", &yaml); }),
            "'a/b' given, allowed: group/key=value");
  EXPECT_EQ(message_of<ParameterError>([&] { set_parameter("=1", &yaml); }),
            "'=1' given, allowed: group/key=value");
  EXPECT_EQ(message_of<ParameterError>([&] { set_parameter("a/b=[1", &yaml); }), "a/b: '[1' is not YAML");
}

TEST(MergeParameters, LaysOneFileOverTheOther) {
  const YAML::Node base = YAML::Load("{a: {x: 1, y: [1, 2]}, b: 3}");
  const YAML::Node merged = merge_parameters(base, YAML::Load("{a: {y: [9], z: 4}, c: 5}"));
  EXPECT_EQ(merged["a"]["x"].as<int>(), 1);
  EXPECT_EQ(merged["a"]["y"].size(), 1U) << "lists replace";
  EXPECT_EQ(merged["a"]["z"].as<int>(), 4);
  EXPECT_EQ(merged["b"].as<int>(), 3);
  EXPECT_EQ(merged["c"].as<int>(), 5);
  EXPECT_EQ(base["a"]["y"].size(), 2U) << "the original is left alone";
  EXPECT_EQ(merge_parameters(base, YAML::Load("a:\n"))["a"]["x"].as<int>(), 1)
      << "an empty group changes nothing";
  EXPECT_EQ(merge_parameters(base, YAML::Node())["b"].as<int>(), 3);
}

/// Reads a configuration in the way that its users do.
void load(const std::filesystem::path& file, const std::function<void(const std::string&)>& warn) {
  if (file.filename() == "palette.yaml") {
    read_palette(file);
  } else if (file.filename() == "detector.yaml") {
    std::vector<std::string> unread;
    read_detector_options(YAML::LoadFile(file), &unread);
    for (const std::string& key : unread) warn(key);
  } else {
    read_run_options({file}, {}, warn);
  }
}

/// Each shipped configuration, over the defaults, is complete and has no misspelt key.
TEST(Configurations, AllLoad) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(CONFIG_FOLDER)) {
    if (entry.path().extension() != ".yaml") continue;
    ++files;
    const auto warn = [&](const std::string& line) { ADD_FAILURE() << entry.path() << ": " << line; };
    EXPECT_EQ(message_of<ParameterError>([&] { load(entry.path(), warn); }), "") << entry.path();
  }
  EXPECT_GE(files, 4);
}

TEST(Configurations, TheDefaultsAreThoseOfTheCode) {
  const RunOptions from_file =
      read_run_options({}, {}, [](const std::string& line) { ADD_FAILURE() << line; });
  EXPECT_EQ(from_file.pipeline.input.max_linear_speed, 0.22);
  EXPECT_EQ(from_file.pipeline.input.max_angular_speed, 1.1);
  EXPECT_EQ(from_file.pipeline.sensor.min_depth, 0.6);
  EXPECT_EQ(from_file.sync.max_interval, 0.07);
}

TEST(Configurations, SayWhatIsWrongWithAFile) {
  const testing::TemporaryFolder folder;
  const auto refusal_of = [&](const std::string& text) {
    testing::write_text(folder / "a.yaml", text);
    return message_of<ParameterError>([&] { read_run_options({folder / "a.yaml"}, {}, nullptr); });
  };
  EXPECT_EQ(message_of<ParameterError>([&] { read_run_options({"absent.yaml"}, {}, nullptr); }),
            "absent.yaml: cannot be read");
  EXPECT_EQ(refusal_of("[1, 2]"), folder / "a.yaml" + ": not a YAML map of parameter groups");
  EXPECT_EQ(refusal_of("map:\n  directory: a\n  file_name: b.yaml\n  directory: c\n"),
            folder / "a.yaml" + ": line 4: key 'directory' is given twice");
  EXPECT_EQ(refusal_of("fusion:\n  beacons:\n  - {id: 1, xyz: [0, 0, 0], id: 2}\n"),
            folder / "a.yaml" + ": line 3: key 'id' is given twice");
  EXPECT_EQ(refusal_of("map: &itself {map: *itself}"), folder / "a.yaml" + ": line 1: nested too deeply");
  std::string doubled = "a: &a [0, 0, 0, 0, 0, 0, 0, 0, 0, 0]\n";
  for (char name = 'b'; name < 'g'; ++name) {  // each stands for ten of the one before
    doubled += std::string(1, name) + ": &" + name + " [";
    for (int i = 0; i < 10; ++i) doubled += std::string(i > 0 ? ", *" : "*") + static_cast<char>(name - 1);
    doubled += "]\n";
  }
  EXPECT_NE(refusal_of(doubled).find("more than 100000 entries"), std::string::npos) << refusal_of(doubled);
  EXPECT_EQ(refusal_of("# " + std::string(1 << 20, '.')),
            folder / "a.yaml" + ": allowed: no more than 1048576 bytes");
  EXPECT_EQ(refusal_of("a: [1").rfind(folder / "a.yaml" + ": not YAML: ", 0), 0U);
  EXPECT_EQ(refusal_of(""), "");
  EXPECT_EQ(message_of<ParameterError>([&] { read_run_options({folder / ""}, {}, nullptr); }),
            folder / "" + ": is a folder");
}

TEST(Configurations, NameTheFileOfABadValue) {
  const testing::TemporaryFolder folder;
  const std::string good = folder / "good.yaml";
  const std::string bad = folder / "bad.yaml";
  testing::write_text(good, "sensor: {min_depth: 0.5}\n");
  testing::write_text(bad, "sensor: {max_depth: far, max_dept: 1}\n");
  const auto refusal_of = [](const std::vector<std::string>& files,
                             const std::vector<std::string>& settings) {
    return message_of<ParameterError>([&] { read_run_options(files, settings, nullptr); });
  };
  EXPECT_EQ(refusal_of({bad, good}, {}), bad + ": sensor/max_depth: 'far' given, allowed: a number >= 0");
  EXPECT_EQ(refusal_of({good, bad}, {"sensor/max_depth=near"}),
            "sensor/max_depth: 'near' given, allowed: a number >= 0");
  std::vector<std::string> warnings;
  read_run_options({bad, good}, {"sensor/max_depth=3", "sensor/dept=1"},
                   [&](const std::string& line) { warnings.push_back(line); });
  EXPECT_EQ(warnings,
            std::vector<std::string>({bad + ": parameter sensor/max_dept is not known and was not read; "
                                            "did you mean sensor/max_depth?",
                                      "parameter sensor/dept is not known and was not read"}));
}

}  // namespace
}  // namespace kinect_ekf_slam
