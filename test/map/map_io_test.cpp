// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/map_io.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <stdexcept>

#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/map/pgm.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

constexpr std::int8_t kU = MapSnapshot::kUnknown, kF = MapSnapshot::kFree,
                      kO = MapSnapshot::kOccupied;

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

class MapIoTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("kestrel_map_io_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Writes a map of 2 x 1 cells, replaces `from` by `to` in its YAML, and returns the error of
  /// reading it.
  std::string errorOfChangedYaml(const std::string& from, const std::string& to) {
    writeFileAtomically(path("m.pgm"), std::string("P5 2 1 255\n\x00\xfe", 13));
    std::string yaml =
        "image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    yaml.replace(yaml.find(from), from.size(), to);
    writeFileAtomically(path("m.yaml"), yaml);
    return errorOf([&] { readMap(path("m.yaml")); });
  }

  fs::path folder_;
};

MapSnapshot smallMap() {
  MapSnapshot map;
  map.resolution_m = 0.05;
  map.origin_x = -1.25;
  map.origin_y = 3.1;
  map.width = 3;
  map.height = 2;
  map.cells = {kU, kF, kO,   // lower row
               kO, kO, kF};  // upper row
  return map;
}

TEST_F(MapIoTest, WritesTheBytesThatMapServerExpects) {
  writeMap(path("office"), smallMap());
  const std::string pixels = {'\x00', '\x00', '\xfe', '\xcd', '\xfe', '\x00'};
  EXPECT_EQ(readFile(path("office.pgm")),
            "P5\n# CREATOR: kestrel_slam 0.05 m/pix\n3 2\n255\n" + pixels);
  EXPECT_EQ(readFile(path("office.yaml")),
            "image: office.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1.25, 3.1, 0.0]\n"
            "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

TEST_F(MapIoTest, RoundTripKeepsEverything) {
  MapSnapshot map = smallMap();
  map.origin_x = -1.0 / 3.0;  // needs all digits
  writeMap(path("a"), map);
  const MapSnapshot read = readMap(path("a.yaml"));
  EXPECT_EQ(read.resolution_m, map.resolution_m);
  EXPECT_EQ(read.origin_x, map.origin_x);
  EXPECT_EQ(read.origin_y, map.origin_y);
  EXPECT_EQ(read.width, 3);
  EXPECT_EQ(read.height, 2);
  EXPECT_EQ(read.cells, map.cells);
}

TEST_F(MapIoTest, LeavesNoTemporaryFile) {
  writeMap(path("a"), smallMap());
  const auto count = std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  EXPECT_EQ(count, 2);
}

TEST_F(MapIoTest, ReadsWhatMapSaverAndOthersWrite) {
  writeFileAtomically(path("m.pgm"), "P2\n# a comment\n3 # wide\n1\n# max\n100\n0 20 100\n");
  writeFileAtomically(path("m.yaml"),
                      "---\n# saved by hand\nimage: \"m.pgm\"  # beside\nresolution: 0.050000\n"
                      "origin:\n- -10.5\n- 2\n- 0.0\nnegate: 1\noccupied_thresh: 0.65\n"
                      "free_thresh: 0.196\n\n");
  const MapSnapshot map = readMap(path("m.yaml"));
  EXPECT_EQ(map.origin_x, -10.5);
  EXPECT_EQ(map.origin_y, 2.0);
  // Negated: black is free and white is occupied; 20 of 100 is above the free threshold.
  EXPECT_EQ(map.cells, (std::vector<std::int8_t>{kF, kU, kO}));
}

TEST_F(MapIoTest, RawValuesAreTheOccupancyInPercent) {
  writeFileAtomically(path("m.pgm"), std::string("P5 5 1 255\n\x00\x13\x32\x64\xff", 16));
  writeFileAtomically(path("m.yaml"),
                      "image: m.pgm\nmode: raw\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n"
                      "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
  EXPECT_EQ(readMap(path("m.yaml")).cells, (std::vector<std::int8_t>{kF, kF, kU, kO, kU}));
}

/// The corner of the image stays at the origin.
TEST_F(MapIoTest, AYawInTheOriginTurnsTheImage) {
  writeFileAtomically(path("m.pgm"), std::string("P5 3 1 255\n\x00\xfe\xfe", 14));
  writeFileAtomically(path("m.yaml"),
                      "image: m.pgm\nresolution: 0.5\norigin: [1, 2, 1.5707963267948966]\n"
                      "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  const MapSnapshot map = readMap(path("m.yaml"));
  EXPECT_NEAR(map.origin_x, 0.5, 1e-9);
  EXPECT_NEAR(map.origin_y, 2.0, 1e-9);
  std::vector<std::int8_t> known;
  for (const std::int8_t cell : map.cells)
    if (cell != kU) known.push_back(cell);
  EXPECT_EQ(known, (std::vector<std::int8_t>{kO, kF, kF}));
}

TEST_F(MapIoTest, SupportsAnAbsoluteImagePath) {
  fs::create_directories(folder_ / "images");
  writeFileAtomically(path("images/m.pgm"), std::string("P5 1 1 255\n\x00", 12));
  writeFileAtomically(path("m.yaml"), "image: " + path("images/m.pgm") +
                                          "\nresolution: 1\norigin: [0, 0, 0]\nnegate: 0\n"
                                          "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
  EXPECT_EQ(readMap(path("m.yaml")).cells, std::vector<std::int8_t>{kO});
}

TEST_F(MapIoTest, RefusesToWriteAnEmptyMap) {
  EXPECT_EQ(errorOf([&] { writeMap(path("a"), MapSnapshot()); }),
            "cannot write " + path("a.pgm") + ": the map is still empty");
  EXPECT_FALSE(fs::exists(path("a.pgm")));
}

TEST_F(MapIoTest, ReportsAnUnwritableFolderWithTheReason) {
  EXPECT_EQ(errorOf([&] { writeMap(path("missing/a"), smallMap()); }),
            "cannot write " + path("missing/a.pgm") + ": No such file or directory");
  writeFileAtomically(path("file"), "");
  EXPECT_EQ(errorOf([&] { writeMap(path("file/a"), smallMap()); }),
            "cannot write " + path("file/a.pgm") + ": Not a directory");
}

TEST_F(MapIoTest, AFailureKeepsTheOlderFile) {
  writeMap(path("a"), smallMap());
  const std::string before = readFile(path("a.pgm"));
  fs::remove(path("a.yaml"));
  fs::create_directories(path("a.yaml"));  // a folder has this name
  EXPECT_THROW(writeMap(path("a"), smallMap()), std::runtime_error);
  EXPECT_EQ(readFile(path("a.pgm")), before);
}

TEST_F(MapIoTest, ReportsErrorsOfTheYaml) {
  const std::string start = "cannot read the map " + path("m.yaml") + ": ";
  EXPECT_EQ(errorOfChangedYaml("0.1", "0.1"), "no error");
  EXPECT_EQ(errorOfChangedYaml("resolution: 0.1\n", ""),
            start + "the key 'resolution' is missing; is this the YAML file of a map?");
  EXPECT_EQ(errorOfChangedYaml("0.1", "fine"), start + "'resolution' is 'fine', not a number");
  EXPECT_EQ(errorOfChangedYaml("0.1", "nan"), start + "'resolution' is 'nan', not a number");
  EXPECT_EQ(errorOfChangedYaml("0.1", "-1"),
            start + "'resolution' is -1, not within 0.0001 to 100");
  EXPECT_EQ(errorOfChangedYaml("[0, 0, 0]", "[0, 0]"),
            start + "'origin' is not a list of three numbers [x, y, yaw]");
  EXPECT_EQ(errorOfChangedYaml("negate: 0", "negate: 2"), start + "'negate' is '2', not 0 or 1");
  EXPECT_EQ(errorOfChangedYaml("free_thresh: 0.196", "free_thresh: 0.7"),
            start + "'free_thresh' is above 'occupied_thresh'");
  EXPECT_EQ(errorOfChangedYaml("negate: 0", "mode: color\nnegate: 0"),
            start + "the mode is 'color', not trinary, scale or raw");
  EXPECT_EQ(errorOfChangedYaml("negate: 0", "nonsense"),
            start + "the line 'nonsense' is not 'key: value'");
  EXPECT_EQ(errorOfChangedYaml("m.pgm", "x.pgm"),
            start + "cannot read " + path("x.pgm") + ": No such file or directory");
}

TEST_F(MapIoTest, ReportsAMissingYamlOrAFolder) {
  EXPECT_EQ(errorOf([&] { readMap(path("none.yaml")); }),
            "cannot read " + path("none.yaml") + ": No such file or directory");
  EXPECT_EQ(errorOf([&] { readMap(folder_.string()); }),
            "cannot read " + folder_.string() + ": Is a directory");
}

struct BrokenPgm {
  std::string bytes;
  std::string error;
};

class BrokenPgmTest : public ::testing::TestWithParam<BrokenPgm> {};

TEST_P(BrokenPgmTest, ReportsTheError) {
  EXPECT_EQ(errorOf([&] { decodePgm(GetParam().bytes); }), GetParam().error);
}

INSTANTIATE_TEST_SUITE_P(
    Pgm, BrokenPgmTest,
    ::testing::Values(
        BrokenPgm{"", "it is not a PGM image (it does not begin with P2 or P5); convert it"},
        BrokenPgm{"\x89PNG", "it is not a PGM image (it does not begin with P2 or P5); convert it"},
        BrokenPgm{"P5", "it ends before its width"},
        BrokenPgm{"P5\nx 2\n255\n", "its width is not a number"},
        BrokenPgm{"P5\n0 2\n255\n", "its width is 0, not within 1 to 1000000"},
        BrokenPgm{"P5\n99999999999 2\n255\n", "its width is too large"},
        BrokenPgm{"P5\n2 2\n0\n", "its maximum value is 0, not within 1 to 65535"},
        BrokenPgm{"P5\n1000000 1000000\n255\nabc",
                  "it is truncated: 1000000000000 bytes of pixels expected, 3 found"},
        BrokenPgm{"P5\n2 2\n255\nabc", "it is truncated: 4 bytes of pixels expected, 3 found"},
        BrokenPgm{"P5\n2 1\n300\nabc", "it is truncated: 4 bytes of pixels expected, 3 found"},
        BrokenPgm{"P2\n2 1\n255\n1  ", "it ends before its pixel 2 of 2"},
        BrokenPgm{"P2\n2 1\n255\n1 x", "its pixel 2 of 2 is not a number"},
        BrokenPgm{"P2\n2 1\n100\n1 101", "it has a pixel of 101 above its maximum of 100"}));

TEST(PgmTest, ScalesSixteenBitValues) {
  const GrayImage image = decodePgm(std::string("P5\n2 1\n65535\n\xff\xff\x80\x00", 17));
  EXPECT_EQ(image.pixels, (std::vector<std::uint8_t>{255, 128}));
}

}  // namespace
}  // namespace kestrel
