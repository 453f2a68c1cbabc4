// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <set>

#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/map/map_folder.h"
#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/map/map_path.h"
#include "map/killed_writer.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

constexpr int kKills = 200;

std::set<std::string> namesIn(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

bool isOneOfTwo(const MapSnapshot& map) {
  return equal(map, oneOfTwoMaps(false)) || equal(map, oneOfTwoMaps(true));
}

TEST(MapSave, AKilledWriterLeavesTheWholeOldOrTheWholeNewMap) {
  const TemporaryFolder folder;
  const std::string stem = folder.file("map");
  writeMap(stem, oneOfTwoMaps(false));
  killWhileWriting(
      kKills, [&](int n) { writeMap(stem, oneOfTwoMaps(n % 2 == 0)); },
      [&] { EXPECT_TRUE(isOneOfTwo(readMap(stem + ".yaml"))); });
  writeMap(stem, oneOfTwoMaps(true));
  EXPECT_EQ(namesIn(folder.file("")), (std::set<std::string>{"map.pgm", "map.yaml"}));
  EXPECT_CONTAINS(readFile(stem + ".yaml"), "image: map.pgm\n");
}

TEST(MapSave, AReaderNeverSeesAMixture) {
  const TemporaryFolder folder;
  const std::string stem = folder.file("map");
  writeMap(stem, oneOfTwoMaps(false));
  const pid_t child = ::fork();
  if (child == 0) {
    for (int n = 0;; ++n) writeMap(stem, oneOfTwoMaps(n % 2 == 0));
  }
  for (int i = 0; i < 200; ++i) EXPECT_TRUE(isOneOfTwo(readMap(stem + ".yaml")));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

std::string runName(int n) { return n % 2 == 0 ? "second run" : "first run"; }

void writeRun(const std::string& folder, int n) {
  writeMapFolder(
      folder, oneOfTwoMaps(n % 2 == 0),
      {{"stats.json", runName(n)}, {"report.html", runName(n) + std::string(5000, ' ')}});
}

void expectOneRun(const std::string& folder) {
  const bool second = equal(readMap(folder + "/map.yaml"), oneOfTwoMaps(true));
  EXPECT_TRUE(isOneOfTwo(readMap(folder + "/map.yaml")));
  EXPECT_EQ(readFile(folder + "/stats.json"), runName(second ? 0 : 1));
  EXPECT_EQ(readFile(folder + "/report.html").substr(0, runName(1).size()),
            runName(second ? 0 : 1).substr(0, runName(1).size()));
}

TEST(MapSave, AKilledWriterLeavesAllFilesOfOneRun) {
  const TemporaryFolder folder;
  const std::string out = folder.file("out");
  fs::create_directory(out);
  writeRun(out, 1);
  killWhileWriting(
      kKills, [&](int n) { writeRun(out, n); }, [&] { expectOneRun(out); });
  writeRun(out, 0);
  EXPECT_EQ(namesIn(folder.file("")), std::set<std::string>{"out"});
  EXPECT_EQ(namesIn(out),
            (std::set<std::string>{"map.pgm", "map.yaml", "report.html", "stats.json"}));
}

TEST(MapSave, AKillInAFolderWithOtherFilesKeepsThemAndAWholeMap) {
  const TemporaryFolder folder;
  folder.write("notes.txt", "of the user");
  writeRun(folder.file(""), 1);
  killWhileWriting(
      kKills / 4, [&](int n) { writeRun(folder.file(""), n); },
      [&] { EXPECT_TRUE(isOneOfTwo(readMap(folder.file("map.yaml")))); });
  EXPECT_EQ(readFile(folder.file("notes.txt")), "of the user");
}

TEST(MapSave, TheFolderKeepsItsLinkAndItsPermissions) {
  const TemporaryFolder folder;
  fs::create_directory(folder.file("out"));
  ASSERT_EQ(::chmod(folder.file("out").c_str(), 0750), 0);
  fs::create_symlink("out", folder.file("latest"));
  writeRun(folder.file("latest"), 0);
  EXPECT_TRUE(fs::is_symlink(folder.file("latest")));
  EXPECT_EQ(static_cast<unsigned int>(fs::status(folder.file("out")).permissions()), 0750U);
  expectOneRun(folder.file("out"));
}

TEST(MapSave, TheWorkingFolderIsNotReplaced) {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder.file(""));
  writeRun(".", 1);
  writeRun(".", 0);
  EXPECT_EQ(namesIn("."),
            (std::set<std::string>{"map.pgm", "map.yaml", "report.html", "stats.json"}));
  expectOneRun(".");
  fs::current_path(before);
}

TEST(MapSave, APipeInTheFolderIsAnError) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo(folder.file("report.html").c_str(), 0600), 0);
  EXPECT_CONTAINS(messageOf([&] { writeRun(folder.file(""), 0); }), "report.html: a pipe");
}

TEST(MapSave, AnImageThatCannotBeReplacedLeavesTheOlderMap) {
  const TemporaryFolder folder;
  const std::string stem = folder.file("map");
  writeMap(stem, oneOfTwoMaps(false));
  const std::string before = readFile(stem + ".yaml");
  fs::remove(stem + ".pgm");
  ASSERT_EQ(::mkfifo((stem + ".pgm").c_str(), 0600), 0);
  EXPECT_CONTAINS(messageOf([&] { writeMap(stem, oneOfTwoMaps(true)); }), "map.pgm: a pipe");
  EXPECT_EQ(readFile(stem + ".yaml"), before);
}

TEST(MapSave, EveryNameIsFoundAgain) {
  const TemporaryFolder folder;
  for (const std::string name : {"#1", "a: b", "[a] b", "a\"b\\c", "'a'", "-x", "~", "a #b", "1e5",
                                 "Büro 3. Stock", "no", "{a}", "&a", "*a", "!a", "%a", "@a"}) {
    const std::string stem = folder.file(name);
    writeMap(stem, oneOfTwoMaps(true));
    EXPECT_TRUE(equal(readMap(stem + ".yaml"), oneOfTwoMaps(true))) << name;
  }
}

TEST(MapSave, NamesAreQuotedForOtherYamlParsers) {
  const TemporaryFolder folder;
  const auto firstLine = [&](const std::string& name) {
    writeMap(folder.file(name), oneOfTwoMaps(true));
    const std::string text = readFile(folder.file(name + ".yaml"));
    return text.substr(0, text.find('\n'));
  };
  EXPECT_EQ(firstLine("office-2_b"), "image: office-2_b.pgm");
  EXPECT_EQ(firstLine("#1"), "image: \"#1.pgm\"");
  EXPECT_EQ(firstLine("a: b"), "image: \"a: b.pgm\"");
  EXPECT_EQ(firstLine("[a] b"), "image: \"[a] b.pgm\"");
  EXPECT_EQ(firstLine("a\"b\\c"), "image: \"a\\\"b\\\\c.pgm\"");
}

TEST(MapPath, LeavesOutTheExtension) {
  for (const char* path :
       {"/maps/m", "/maps/m.pgm", "/maps/m.yaml", "/maps/m.yml", "/maps//x/../m"}) {
    EXPECT_EQ(mapStemOf(path), "/maps/m") << path;
  }
  EXPECT_EQ(mapStemOf("/maps/floor.2"), "/maps/floor.2");
}

TEST(MapPath, InAFolderTheMapIsCalledMap) {
  const TemporaryFolder folder;
  const std::string path = folder.file("");
  EXPECT_EQ(mapStemOf(path), path + "map");
  EXPECT_EQ(mapStemOf(path.substr(0, path.size() - 1)), path + "map");
  EXPECT_EQ(mapStemOf("/not/there/"), "/not/there/map");
  EXPECT_EQ(mapStemOf("/"), "/map");
}

TEST(MapPath, ExpandsTheHomeFolder) {
  const TemporaryFolder folder;
  const char* home = std::getenv("HOME");
  const std::string before = home != nullptr ? home : "";
  ::setenv("HOME", folder.file("home").c_str(), 1);
  EXPECT_EQ(mapStemOf("~/maps/a"), folder.file("home/maps/a"));
  EXPECT_EQ(mapStemOf("~/"), folder.file("home/map"));
  EXPECT_CONTAINS(messageOf([] { mapStemOf("~someone/a"); }), "only ~/ is supported");
  ::setenv("HOME", before.c_str(), 1);
}

TEST(MapPath, RefusesWhatNoYamlFileCanName) {
  EXPECT_CONTAINS(messageOf([] { mapStemOf(""); }), "the path of the map is empty");
  EXPECT_CONTAINS(messageOf([] { mapStemOf("/tmp/a\nb"); }), "control character");
  EXPECT_CONTAINS(messageOf([] { mapStemOf(std::string("/tmp/a\0b", 8)); }), "control character");
  EXPECT_CONTAINS(messageOf([] { mapStemOf("/tmp/\xff"); }), "not UTF-8");
}

TEST(MapPath, CreatesTheFolderOrSaysWhyNot) {
  const TemporaryFolder folder;
  createFolderOf(folder.file("a/b/map"));
  EXPECT_TRUE(fs::is_directory(folder.file("a/b")));
  createFolderOf(folder.file("a/b/map"));
  folder.write("file", "");
  EXPECT_CONTAINS(messageOf([&] { createFolderOf(folder.file("file/map")); }),
                  "the folder " + folder.file("file") + " cannot be created: ");
}

}  // namespace
}  // namespace kestrel
