#include "kinect_ekf_slam/core/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <atomic>
#include <csignal>
#include <stdexcept>
#include <thread>
#include <vector>

#include "test/support/temporary_folder.h"

namespace kinect_ekf_slam {
namespace {

using testing::message_of;
using testing::read_text;
using testing::TemporaryFolder;

/// As long as it lives no file of this process grows beyond `bytes`: a full disk that needs no disk.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limited{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limited);
  }
  ~SmallDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST(AtomicFile, WritesAndReplaces) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", "first, and longer");
  EXPECT_EQ(read_text(folder / "a"), "first, and longer");
  write_file_atomically(folder / "a", std::string("second\0bytes", 12));
  EXPECT_EQ(read_text(folder / "a"), std::string("second\0bytes", 12));
  EXPECT_EQ(folder.entries(), 1U);
}

TEST(AtomicFile, IsKnownToBeWritableBefore) {
  const TemporaryFolder folder;
  require_writable(folder / "a");
  EXPECT_EQ(folder.entries(), 0U) << "nothing stays";
  EXPECT_NE(message_of<std::runtime_error>([] { require_writable(""); }), "");
  for (const std::string& path : {folder / "none/a", folder.path()}) {
    const std::string line = message_of<std::runtime_error>([&] { require_writable(path); });
    EXPECT_EQ(line.rfind(path + ": cannot be ", 0), 0U) << line;
  }
}

TEST(AtomicFile, TakesWhatAKilledProgramLeft) {
  const TemporaryFolder folder;
  testing::write_text(folder / "a.new", "left between a name and a place");
  write_file_atomically(folder / "a", "text");
  EXPECT_EQ(read_text(folder / "a"), "text");
  EXPECT_EQ(folder.entries(), 1U);
}

TEST(AtomicFile, IsWholeWhileTwoWriteIt) {
  const TemporaryFolder folder;
  const std::string texts[] = {std::string(100000, 'a'), std::string(50000, 'b')};
  write_file_atomically(folder / "a", texts[0]);
  std::atomic<int> writing{2};
  std::vector<std::thread> writers;
  for (const std::string& text : texts) {
    writers.emplace_back([&] {
      for (int i = 0; i < 100; ++i) write_file_atomically(folder / "a", text);
      --writing;
    });
  }
  while (writing > 0) {
    const std::string text = read_text(folder / "a");
    EXPECT_TRUE(text == texts[0] || text == texts[1]) << text.size() << " bytes";
  }
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(folder.entries(), 1U);
}

TEST(AtomicFile, CanBeEmpty) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", "");
  EXPECT_EQ(folder.entries(), 1U);
  EXPECT_EQ(read_text(folder / "a"), "");
}

TEST(AtomicFile, MayBeReadByWhomTheUmaskAllows) {
  const TemporaryFolder folder;
  const mode_t before = ::umask(022);
  write_file_atomically(folder / "a", "text");
  ::umask(before);
  struct stat status {};
  ASSERT_EQ(::stat((folder / "a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0644U);
}

TEST(AtomicFile, OldTextStaysWholeWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", "old");
  std::string message;
  {
    const SmallDisk disk(1000);
    message =
        message_of<std::runtime_error>([&] { write_file_atomically(folder / "a", std::string(5000, 'x')); });
  }
  EXPECT_EQ(message, folder / "a" + ": cannot be written: File too large");
  EXPECT_EQ(read_text(folder / "a"), "old");
  EXPECT_EQ(folder.entries(), 1U) << "a part of the new text lies about";
}

TEST(AtomicFile, SaysThatTheFolderIsMissing) {
  const TemporaryFolder folder;
  const std::string path = folder / "missing/a";
  EXPECT_EQ(message_of<std::runtime_error>([&] { write_file_atomically(path, "text"); }),
            path + ": cannot be created: No such file or directory");
}

TEST(AtomicFile, OldTextStaysWholeInAReadOnlyFolder) {
  if (::geteuid() == 0) GTEST_SKIP() << "nothing is read-only for root";
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", "old");
  ::chmod(folder.path().c_str(), 0555);
  EXPECT_EQ(message_of<std::runtime_error>([&] { write_file_atomically(folder / "a", "new"); }),
            folder / "a" + ": cannot be created: Permission denied");
  ::chmod(folder.path().c_str(), 0755);
  EXPECT_EQ(read_text(folder / "a"), "old");
}

TEST(AtomicFile, DoesNotReplaceAFolder) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "a");
  EXPECT_EQ(message_of<std::runtime_error>([&] { write_file_atomically(folder / "a", "text"); }),
            folder / "a" + ": cannot be written: Is a directory");
  EXPECT_EQ(folder.entries(), 1U);
}

}  // namespace
}  // namespace kinect_ekf_slam
