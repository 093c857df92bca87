#include "kinect_ekf_slam/mapping/map_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <functional>
#include <limits>

#include "test/support/map_samples.h"
#include "test/support/temporary_folder.h"

namespace kinect_ekf_slam {
namespace {

using testing::message_of;
using testing::read_text;
using testing::SameMap;
using testing::sample_map;
using testing::TemporaryFolder;
using testing::write_text;

class MapFile : public ::testing::Test {
 protected:
  void write(const SavedState& state, const std::string& parameters = "") {
    write_map(path_, "map", state, parameters);
  }
  SavedState read() { return read_map(path_, "map"); }

  /// Why the file is refused: one line that starts with its name.
  std::string refusal(const std::string& frame = "map") {
    const std::string line = message_of<MapFileError>([&] { read_map(path_, frame); });
    EXPECT_EQ(line.rfind(path_ + ": ", 0), 0U) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    return line.size() > path_.size() + 2 ? line.substr(path_.size() + 2) : line;
  }
  /// Why the sample map is refused when `from` reads `to`.
  std::string refusal_after(const std::string& from, const std::string& to) {
    write(sample_map());
    std::string text = read_text(path_);
    const auto place = text.find(from);
    EXPECT_NE(place, std::string::npos) << from;
    if (place != std::string::npos) write_text(path_, text.replace(place, from.size(), to));
    return refusal();
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "room.yaml";
};

TEST_F(MapFile, ComesBackToTheLastBit) {
  write(sample_map(), "estimator:\n  type: ekf\n");
  EXPECT_TRUE(SameMap(read(), sample_map()));
}

TEST_F(MapFile, OfSpaceComesBackToTheLastBit) {
  const SavedState state = sample_map<Spatial>();
  EXPECT_EQ(state.pose.size(), 7);
  EXPECT_EQ(state.landmarks_in_map.cols(), 3);
  write(state);
  EXPECT_TRUE(SameMap(read(), state));
}

TEST_F(MapFile, OfSpaceIsRefusedWithAQuaternionThatIsNone) {
  SavedState state = sample_map<Spatial>();
  state.pose.tail<4>() *= 1.1;
  write(state);
  EXPECT_EQ(refusal(), "the quaternion of its pose is not of length 1");
  state.pose.tail<4>().setZero();
  write(state);
  EXPECT_EQ(refusal(), "the quaternion of its pose is not of length 1");
}

/// A planar map that says it were spatial, and the other way round.
TEST_F(MapFile, IsRefusedWhenItsNumbersAreOfAnotherSpace) {
  EXPECT_EQ(refusal_after("space: planar", "space: spatial"), "pose should have 7 numbers");
  SavedState state = sample_map<Spatial>();
  state.space = Planar::kName;
  write(state);
  EXPECT_EQ(refusal(), "pose should have 3 numbers");
}

TEST_F(MapFile, WritesTheSameTextAgain) {
  write(sample_map());
  const std::string first = read_text(path_);
  write(read());
  EXPECT_EQ(read_text(path_), first);
}

TEST_F(MapFile, KeepsNumbersOfAnySize) {
  SavedState state = sample_map();
  state.landmarks_in_map(0, 0) = std::nextafter(1e9, 0.0);
  state.landmarks_in_map(0, 1) = std::numeric_limits<double>::denorm_min();
  state.landmarks_in_map(1, 0) = -0.0;
  state.landmarks_in_map(1, 1) = std::nextafter(0.1, 1.0);
  write(state);
  const SavedState loaded = read();
  EXPECT_TRUE(SameMap(loaded, state));
  EXPECT_TRUE(std::signbit(loaded.landmarks_in_map(1, 0)));
}

TEST_F(MapFile, KeepsAMapWithoutLandmarks) {
  SavedState state;
  state.space = "planar";
  state.pose = Eigen::Vector3d(1.0, 2.0, 0.5);
  state.landmarks_in_map.resize(0, 2);
  state.covariance = 0.01 * Eigen::Matrix3d::Identity();
  write(state);
  EXPECT_TRUE(SameMap(read(), state));
}

TEST_F(MapFile, KeepsALongLabel) {
  SavedState state = sample_map();
  state.infos[0].label_votes[std::string(3000, 'x')] = 1;
  write(state);
  EXPECT_TRUE(SameMap(read(), state));
}

TEST_F(MapFile, KeepsALabelThatIsNoText) {
  SavedState state = sample_map();
  state.infos[0].label_votes["\xFF\xFE broken"] = 1;  // not UTF-8: it may be changed, the map may not be lost
  state.infos[1].label_votes[std::string("a\0b\x01\x7F", 5)] = 1;
  write(state);
  EXPECT_EQ(read().infos.size(), state.infos.size());
}

TEST_F(MapFile, CarriesTheParametersWhateverTheyLookLike) {
  for (const char* parameters : {"a: 1\nb: 2", "\n\n  indented: 1\nnot: 2\n", "\ttab: 1\n",
                                 "--- # document\n...\n", "quote: \"\n", "windows: 1\r\nline: 2\r\n"}) {
    write(sample_map(), parameters);
    EXPECT_TRUE(SameMap(read(), sample_map())) << parameters;
  }
}

TEST_F(MapFile, MakesTheFolderItIsWrittenTo) {
  path_ = folder_ / "new/deeper/room.yaml";
  write(sample_map());
  EXPECT_TRUE(SameMap(read(), sample_map()));
}

TEST_F(MapFile, SaysWhereItCannotBeWritten) {
  write_text(folder_ / "file", "");
  path_ = folder_ / "file/room.yaml";
  EXPECT_EQ(message_of<MapFileError>([&] { write(sample_map()); }),
            path_ + ": cannot be created: Not a directory");
}

TEST_F(MapFile, IsNotWrittenFromABrokenEstimate) {
  write(sample_map());
  const std::string before = read_text(path_);
  SavedState state = sample_map();
  state.covariance(4, 4) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message_of<MapFileError>([&] { write(state); }),
            path_ + ": not written: the estimate is not finite");
  EXPECT_EQ(read_text(path_), before);
}

/// A file cut off anywhere is refused or, where only the comments are gone, still whole.
TEST_F(MapFile, NeverLoadsAPartOfItself) {
  write(sample_map(), "estimator:\n  type: ekf\n");
  const std::string text = read_text(path_);
  int refused = 0;
  for (std::size_t size = 0; size < text.size(); size += 10) {
    write_text(path_, text.substr(0, size));
    try {
      const SavedState loaded = read();
      EXPECT_TRUE(SameMap(loaded, sample_map())) << "cut off after " << size << " bytes";
    } catch (const MapFileError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, static_cast<int>(text.size() / 10) - 20);
}

TEST_F(MapFile, SurvivesAnyByteBeingWrong) {
  write(sample_map());
  const std::string text = read_text(path_);
  for (std::size_t i = 0; i < text.size(); i += 7) {
    std::string damaged = text;
    damaged[i] = "\0}:\"x-[&*"[i % 9];
    write_text(path_, damaged);
    const std::string line = message_of<MapFileError>([&] { read(); });  // loaded or refused, never worse
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
  }
}

TEST_F(MapFile, IsRefusedWhenItIsAbsent) {
  EXPECT_EQ(refusal(), "cannot be read: No such file or directory");
}

TEST_F(MapFile, IsRefusedWhenItIsSomethingElse) {
  for (const char* text :
       {"", "just text", "[1, 2]", "a: 1\n", "format: rtabmap\nversion: 1\n", "format: [1]\n"}) {
    write_text(path_, text);
    EXPECT_NE(refusal(), "") << text;
  }
  write_text(path_, "image: room.pgm\nresolution: 0.05\n");
  EXPECT_EQ(refusal(), "not a map of kinect_ekf_slam");
}

TEST_F(MapFile, IsRefusedWhenItIsDeeplyNested) {
  write_text(path_, std::string(200000, '['));
  EXPECT_NE(refusal(), "");
  write_text(path_, std::string(200000, '{'));
  EXPECT_NE(refusal(), "");
}

TEST_F(MapFile, IsRefusedWhenItIsNewer) {
  EXPECT_EQ(refusal_after("version: 1", "version: 2"), "version 2 is newer than this program's, 1");
  EXPECT_EQ(refusal_after("version: 1", "version: 0"), "version 0 does not exist");
}

TEST_F(MapFile, IsRefusedInAnotherFrame) {
  write(sample_map());
  EXPECT_EQ(refusal("world"), "its frame is 'map', frames/map is 'world'");
}

TEST_F(MapFile, IsRefusedInAnotherSpace) {
  EXPECT_EQ(refusal_after("space: planar", "space: hyperbolic"),
            "space 'hyperbolic' is not known, allowed: planar, spatial");
}

TEST_F(MapFile, IsRefusedWhenSizesDiffer) {
  EXPECT_EQ(refusal_after("pose: [", "pose: [1, "), "pose should have 3 numbers");
  EXPECT_EQ(refusal_after("position: [", "position: [1, "), "a position should have 2 numbers");
  EXPECT_EQ(refusal_after("covariance_lower_triangle:\n", "covariance_lower_triangle:\n- [1]\n"),
            "covariance_lower_triangle should have 15 rows");
  EXPECT_EQ(refusal_after("covariance_lower_triangle:\n- [", "covariance_lower_triangle:\n- [1, "),
            "a row of the covariance should have 1 numbers");
}

TEST_F(MapFile, IsRefusedWithNumbersThatAreNone) {
  EXPECT_EQ(refusal_after("position: [", "position: [.nan, 0], old: ["), "a position is not finite");
  EXPECT_EQ(refusal_after("pose: [", "pose: [0, .inf, 0]\nold: ["), "pose is not finite");
  EXPECT_EQ(refusal_after("radius: ", "radius: .nan, old: "), "a radius is not finite");
  EXPECT_NE(refusal_after("position: [", "position: [here, there], old: [").find("damaged: "),
            std::string::npos);
}

TEST_F(MapFile, IsRefusedWithNumbersBeyondAllPlaces) {
  EXPECT_EQ(refusal_after("position: [", "position: [1e300, 0], old: ["), "a position is beyond 1e+09");
  EXPECT_EQ(refusal_after("pose: [", "pose: [0, -1e200, 0]\nold: ["), "pose is beyond 1e+09");
  EXPECT_EQ(refusal_after("covariance_lower_triangle:\n- [", "covariance_lower_triangle:\n- [1e300]\n# ["),
            "a row of the covariance is beyond 1e+18");
}

TEST_F(MapFile, IsRefusedWhenItsVotesAreNone) {
  EXPECT_EQ(refusal_after("label_votes: {", "label_votes: 7, old: {"),
            "landmark 1: label_votes is not a map");
}

TEST_F(MapFile, IsRefusedWhenTwoLandmarksShareANumber) {
  EXPECT_EQ(refusal_after("{id: 4,", "{id: 1,"), "landmark id 1 is none or used twice");
  EXPECT_EQ(refusal_after("{id: 4,", "{id: -1,"), "landmark id -1 is none or used twice");
}

TEST_F(MapFile, IsRefusedWhenAKeyIsGivenTwice) {
  EXPECT_EQ(refusal_after("version: 1\n", "version: 1\nversion: 1\n"),
            "line 3: key 'version' is given twice");
  EXPECT_NE(refusal_after("{id: 4,", "{id: 4, id: 5,").find(": key 'id' is given twice"), std::string::npos);
  EXPECT_NE(refusal_after("label_votes: {", "label_votes: {a: 1, a: 2, ").find(": key 'a' is given twice"),
            std::string::npos);
}

TEST_F(MapFile, IsNotReadThroughALinkOrFromAPipe) {
  write(sample_map());
  const std::string sound = path_;
  path_ = folder_ / "link.yaml";
  std::filesystem::create_symlink(sound, path_);
  EXPECT_EQ(refusal(), "is not a regular file");
  path_ = folder_ / "pipe.yaml";
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);  // nobody writes: one that is waited for never opens
  EXPECT_EQ(refusal(), "is not a regular file");
}

TEST_F(MapFile, IsRefusedBeforeItIsReadWhenItIsTooLarge) {
  write(sample_map());
  std::filesystem::resize_file(path_, (1ULL << 30U) + 1);  // sparse: takes no room
  EXPECT_EQ(refusal(), "1073741825 bytes, allowed: no more than 1073741824");
}

TEST_F(MapFile, IsRefusedWhenItsCovarianceIsNone) {
  const std::string line = "its covariance is not positive semi-definite";
  const std::string first = "covariance_lower_triangle:\n- [";
  EXPECT_EQ(refusal_after(first, first + "-"), line);
  SavedState correlated = sample_map();  // each variance is fine, the correlation is not
  correlated.covariance(3, 0) = correlated.covariance(0, 3) =
      1.01 * std::sqrt(correlated.covariance(0, 0) * correlated.covariance(3, 3));
  write(correlated);
  EXPECT_EQ(refusal(), line);
}

TEST_F(MapFile, MayBeExactSomewhere) {
  SavedState state = sample_map();  // semi-definite: the pose is known exactly
  state.covariance.topRows(3).setZero();
  state.covariance.leftCols(3).setZero();
  write(state);
  EXPECT_TRUE(SameMap(read(), state));
}

}  // namespace
}  // namespace kinect_ekf_slam
