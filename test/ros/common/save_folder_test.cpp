// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/save_folder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace kestrel {
namespace {

namespace fs = std::filesystem;

class SaveFolderTest : public testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/kestrel_save_folder_XXXXXX";
    ASSERT_NE(mkdtemp(name), nullptr);
    root_ = fs::canonical(name);
    fs::create_directory(root_ / "maps");
  }
  void TearDown() override { fs::remove_all(root_); }

  /// The stem for a path, or the reason of the refusal.
  std::string answer(const std::string& path) const {
    try {
      return SaveFolder((root_ / "maps").string()).stemOf(path);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }
  std::string inMaps(const std::string& name) const { return (root_ / "maps" / name).string(); }
  bool isRefused(const std::string& path, const std::string& reason) const {
    return answer(path).find(reason) != std::string::npos;
  }

  fs::path root_;
};

TEST_F(SaveFolderTest, RelativeAndAbsolutePathsInTheFolder) {
  EXPECT_EQ(answer("room"), inMaps("room"));
  EXPECT_EQ(answer("a/../room"), inMaps("room"));
  EXPECT_EQ(answer(inMaps("room")), inMaps("room"));
  EXPECT_EQ(answer("new/deep/room"), inMaps("new/deep/room"));
  EXPECT_TRUE(fs::is_directory(inMaps("new/deep")));
}

TEST_F(SaveFolderTest, OddNamesAndExtensions) {
  for (const char* name : {"#1", "a: b", "[a] b"}) EXPECT_EQ(answer(name), inMaps(name));
  EXPECT_EQ(answer("room.pgm"), inMaps("room"));
  EXPECT_EQ(answer("room.yaml"), inMaps("room"));
  EXPECT_EQ(answer("x/"), inMaps("x/map"));
}

TEST_F(SaveFolderTest, NothingLeavesTheFolder) {
  for (const char* path :
       {"../escape", "../../escape", "a/../../escape", "/dev/null.pgm", "/dev/null", "/etc/robot",
        "/tmp/elsewhere", "~/elsewhere", "../maps2/x"}) {
    EXPECT_TRUE(isRefused(path, "is refused")) << path << ": " << answer(path);
  }
  fs::create_directory_symlink("/tmp", root_ / "maps" / "link");
  EXPECT_TRUE(isRefused("link/escape", "is refused")) << answer("link/escape");
  EXPECT_TRUE(isRefused("", "path of the map is empty")) << answer("");
}

TEST_F(SaveFolderTest, PipesAndForeignFilesAreNotReplaced) {
  ASSERT_EQ(mkfifo(inMaps("pipe.pgm").c_str(), 0600), 0);
  EXPECT_TRUE(isRefused("pipe", "no plain file")) << answer("pipe");
  fs::create_symlink("/tmp/kestrel_foreign_target", inMaps("linked.pgm"));
  EXPECT_TRUE(isRefused("linked", "no plain file")) << answer("linked");
  std::ofstream(inMaps("robot.yaml")) << "base_frame: base_link\n";
  EXPECT_TRUE(isRefused("robot", "is no map")) << answer("robot");
  std::ofstream(inMaps("old.yaml")) << "image: old.pgm\nresolution: 0.05\n";
  EXPECT_EQ(answer("old"), inMaps("old"));
}

TEST_F(SaveFolderTest, WithoutTheParameter) {
  const SaveFolder folder("");
  EXPECT_EQ(folder.stemOf((root_ / "room").string()), (root_ / "room").string());
  EXPECT_EQ(folder.stemOf("room"), (fs::current_path() / "room").string());
  for (const char* path : {"/dev/null.pgm", "/etc/robot", "../escape", "../../escape"}) {
    EXPECT_THROW(folder.stemOf(path), std::runtime_error) << path;
  }
}

}  // namespace
}  // namespace kestrel
