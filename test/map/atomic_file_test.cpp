// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/atomic_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "temporary_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

std::ptrdiff_t filesIn(const TemporaryFolder& folder) {
  return std::distance(fs::directory_iterator(folder.file("")), fs::directory_iterator());
}

TEST(AtomicFile, ReplacesTheContentAndLeavesNothingBeside) {
  const TemporaryFolder folder;
  writeFileAtomically(folder.file("a"), "old");
  writeFileAtomically(folder.file("a"), "new");
  EXPECT_EQ(readFile(folder.file("a")), "new");
  EXPECT_EQ(filesIn(folder), 1);
}

TEST(AtomicFile, HasThePermissionsThatTheUmaskLeaves) {
  const TemporaryFolder folder;
  const mode_t before = ::umask(027);
  writeFileAtomically(folder.file("a"), "");
  ::umask(before);
  struct stat status {};
  ASSERT_EQ(::stat(folder.file("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777U, 0640U);
}

TEST(AtomicFile, ReplacesALinkAndNotItsTarget) {
  const TemporaryFolder folder;
  const std::string target = folder.write("target", "precious");
  fs::create_symlink(target, folder.file("link"));
  fs::create_symlink(target, folder.file("link.tmp"));  // the temporary name of earlier versions
  writeFileAtomically(folder.file("link"), "new");
  EXPECT_EQ(readFile(target), "precious");
  EXPECT_EQ(readFile(folder.file("link")), "new");
  EXPECT_FALSE(fs::is_symlink(folder.file("link")));
}

TEST(AtomicFile, DoesNotWaitForAPipe) {
  const TemporaryFolder folder;
  const std::string pipe = folder.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(
      messageOf([&] { writeFileAtomically(pipe, "x"); }),
      "cannot write " + pipe + ": a pipe, socket or device has this name; choose another one");
  EXPECT_EQ(messageOf([&] { readFile(pipe); }),
            "cannot read " + pipe + ": it is a pipe, socket or device; use a plain file");
  EXPECT_EQ(filesIn(folder), 1);
}

TEST(AtomicFile, RefusesDevicesFoldersAndPathsWithoutAName) {
  const TemporaryFolder folder;
  EXPECT_CONTAINS(messageOf([] { writeFileAtomically("/dev/null", "x"); }), "device");
  EXPECT_CONTAINS(messageOf([] { readFile("/dev/zero"); }), "device");
  EXPECT_CONTAINS(messageOf([&] { writeFileAtomically(folder.file(""), "x"); }),
                  "does not name a file");
  fs::create_directory(folder.file("sub"));
  EXPECT_EQ(messageOf([&] { writeFileAtomically(folder.file("sub"), "x"); }),
            "cannot write " + folder.file("sub") + ": Is a directory");
}

TEST(AtomicFile, RemovesWhatAKilledProcessLeft) {
  const TemporaryFolder folder;
  folder.write(".kestrel_slam.4711.0.tmp", "half a fi");
  folder.write("other.tmp", "of somebody else");
  writeFileAtomically(folder.file("a"), "new");
  EXPECT_FALSE(fs::exists(folder.file(".kestrel_slam.4711.0.tmp")));
  EXPECT_TRUE(fs::exists(folder.file("other.tmp")));
}

/// Writes until it is ended by `signal`, at a time that differs from run to run.
void endWhileWriting(const std::string& path, int signal, useconds_t delay_us) {
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string content(1 << 20, 'x');
    while (true) writeFileAtomically(path, content);
  }
  ::usleep(delay_us);
  ::kill(child, signal);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status));
}

TEST(AtomicFile, LeavesNothingBesideWhenItIsAskedToEnd) {
  const TemporaryFolder folder;
  for (unsigned int i = 0; i < 40; ++i) {
    endWhileWriting(folder.file("a"), i % 2 == 0 ? SIGINT : SIGTERM, 5000 + 331 * i);
    if (fs::exists(folder.file("a"))) {
      EXPECT_EQ(fs::file_size(folder.file("a")), 1U << 20);
      EXPECT_EQ(filesIn(folder), 1);
    }
  }
}

}  // namespace
}  // namespace kestrel
