#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>

#include "kinect_ekf_slam/mapping/map_file.h"
#include "test/support/temporary_folder.h"

namespace kinect_ekf_slam {
namespace {

using testing::message_of;
using testing::TemporaryFolder;
using testing::write_text;

TEST(MapDirectory, FindsAPlainName) {
  const TemporaryFolder folder;
  const MapDirectory maps(folder.path());
  EXPECT_EQ(maps.resolve("room.yaml"), folder / "room.yaml");
  EXPECT_EQ(maps.resolve("first floor, east.yaml"), folder / "first floor, east.yaml");
  write_text(folder / "room.yaml", "");
  EXPECT_EQ(maps.resolve("room.yaml"), folder / "room.yaml");
}

TEST(MapDirectory, RefusesNamesThatLeadElsewhere) {
  const TemporaryFolder folder;
  const MapDirectory maps(folder.path());
  const std::string names[] = {
      "",   "room",         "room.yml",       "room.yaml.bak", ".yaml",         ".hidden.yaml",
      "..", "../room.yaml", "/etc/room.yaml", "sub/room.yaml", "..\\room.yaml", "room\\.yaml"};
  for (const std::string& name : names) {
    EXPECT_EQ(message_of<MapFileError>([&] { maps.resolve(name); }),
              "'" + name + "': a map's name is a plain file name that ends in .yaml, in " + folder.path());
  }
}

TEST(MapDirectory, RefusesControlCharactersAndStaysOnOneLine) {
  const MapDirectory maps("folder");
  for (const std::string& name :
       {std::string("a\0.yaml", 7), std::string("a\n.yaml"), std::string("a\x7F.yaml")}) {
    EXPECT_EQ(message_of<MapFileError>([&] { maps.resolve(name); }),
              "'a?.yaml': a map's name is a plain file name that ends in .yaml, in folder");
  }
}

TEST(MapDirectory, FollowsNoLink) {
  const TemporaryFolder folder;
  const TemporaryFolder outside;
  write_text(outside / "secret.yaml", "");
  std::filesystem::create_symlink(outside / "secret.yaml", folder / "link.yaml");
  std::filesystem::create_symlink(outside / "absent.yaml", folder / "dangling.yaml");
  const MapDirectory maps(folder.path());
  for (const char* name : {"link.yaml", "dangling.yaml"}) {
    EXPECT_EQ(message_of<MapFileError>([&] { maps.resolve(name); }),
              folder / name + ": is not a regular file");
  }
}

TEST(MapDirectory, TakesOnlyFiles) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "folder.yaml");
  ASSERT_EQ(::mkfifo((folder / "pipe.yaml").c_str(), 0600), 0);
  const MapDirectory maps(folder.path());
  for (const char* name : {"folder.yaml", "pipe.yaml"}) {
    EXPECT_EQ(message_of<MapFileError>([&] { maps.resolve(name); }),
              folder / name + ": is not a regular file");
  }
}

TEST(MapDirectory, KnowsTheHomeFolder) {
  const char* home = std::getenv("HOME");
  if (home == nullptr) GTEST_SKIP() << "no HOME";
  EXPECT_EQ(MapDirectory("~/maps").resolve("room.yaml"), std::string(home) + "/maps/room.yaml");
}

}  // namespace
}  // namespace kinect_ekf_slam
