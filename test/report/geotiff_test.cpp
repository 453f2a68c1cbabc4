// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/geotiff.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "kestrel_slam/map/atomic_file.h"
#include "run_command.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kWall = 0x002878, kFree = 0xFFFFFF;

/// 4 x 2 m around the origin, free, with an occupied cell at (1.02, -0.48).
GeotiffContent exampleContent() {
  GeotiffContent content;
  MapSnapshot& map = content.map;
  map.resolution_m = 0.05;
  map.origin_x = -2.0;
  map.origin_y = -1.0;
  map.width = 80;
  map.height = 40;
  map.cells.assign(3200, MapSnapshot::kFree);
  map.cells[10 * 80 + 60] = MapSnapshot::kOccupied;
  content.path = {Pose2(-1.0, 0.0, 0.0), Pose2(1.0, 0.5, 0.0)};
  content.marks = {{GeotiffMark::Kind::kVictim, {0.5, -0.5}, "1"}};
  content.title = "test";
  return content;
}

class Picture {
 public:
  explicit Picture(const std::string& path) {
    TIFF* tiff = TIFFOpen(path.c_str(), "r");
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width_);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height_);
    pixels_.resize(static_cast<std::size_t>(width_) * height_);
    TIFFReadRGBAImageOriented(tiff, width_, height_, pixels_.data(), ORIENTATION_TOPLEFT, 1);
    TIFFClose(tiff);
  }

  /// 0xRRGGBB
  std::uint32_t at(double column, double row) const {
    const std::uint32_t abgr =
        pixels_[static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column)];
    return TIFFGetR(abgr) << 16U | TIFFGetG(abgr) << 8U | TIFFGetB(abgr);
  }

 private:
  std::uint32_t width_ = 0, height_ = 0;
  std::vector<std::uint32_t> pixels_;
};

TEST(GeotiffTest, PointsOfTheMapAreWhereTheWorldFileSays) {
  const TemporaryFolder folder;
  writeGeotiff(folder.file("map"), exampleContent());
  std::istringstream file(readFile(folder.file("map.tfw")));
  double pixel = 0.0, zero = 0.0, down = 0.0, east = 0.0, north = 0.0;
  file >> pixel >> zero >> zero >> down >> east >> north;
  EXPECT_NEAR(pixel, 0.05 / 3.0, 1e-9);
  EXPECT_NEAR(down, -pixel, 1e-9);
  const Picture picture(folder.file("map.tif"));
  const auto at = [&](double x, double y) {  // of the map; half a pixel to be at its corner
    return picture.at((-y - east) / pixel + 0.5, (x - north) / down + 0.5);
  };
  EXPECT_EQ(at(1.02, -0.48), kWall);
  EXPECT_EQ(at(1.02, -0.42), kFree);
  EXPECT_EQ(at(1.08, -0.48), kFree);
  EXPECT_EQ(at(0.5, -0.38), 0xF00A0AU) << "the victim";
  EXPECT_EQ(at(0.0, 0.25), 0x78008CU) << "the path";
  EXPECT_EQ(at(-0.9, 0.0), 0xFFC800U) << "the start";
  EXPECT_EQ(at(0.25, 0.5), 0xBEBEBFU) << "a line of the grid";
  EXPECT_NE(at(2.6, 1.4), at(2.6, 0.4)) << "the checkerboard";
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.file("")), {}), 2);
}

TEST(GeotiffTest, OpensInGdalWithScaleAndCorner) {
  const TemporaryFolder folder;
  writeGeotiff(folder.file("map"), exampleContent());
  std::filesystem::remove(folder.file("map.tfw"));  // the TIFF alone must tell it
  if (runCommand("gdalinfo --version").code != 0) GTEST_SKIP() << "gdal-bin is not installed";
  const Outcome outcome = runCommand("(gdalinfo -json " + folder.file("map.tif") + " 2>/dev/null)");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const auto info = nlohmann::json::parse(outcome.output);
  const auto transform = info["geoTransform"];
  // The map ends at x = 2 and y = 1; 3 m above and on the left are for title and scale.
  EXPECT_NEAR(transform[0].get<double>(), -4.0, 1e-9);  // east
  EXPECT_NEAR(transform[3].get<double>(), 5.0, 1e-9);   // north
  EXPECT_NEAR(transform[1].get<double>(), 0.05 / 3.0, 1e-12);
  EXPECT_NEAR(transform[5].get<double>(), -0.05 / 3.0, 1e-12);
  EXPECT_EQ(transform[2], 0.0);
  EXPECT_EQ(info["size"], nlohmann::json::array({360, 480}));
  EXPECT_EQ(info["bands"].size(), 3U);
}

TEST(GeotiffTest, LargeMapsHaveFewerPixels) {
  const TemporaryFolder folder;
  GeotiffContent content = exampleContent();
  content.map.width = 20000;
  content.map.height = 10;
  content.map.cells.assign(200000, MapSnapshot::kUnknown);
  content.path.clear();
  writeGeotiff(folder.file("large"), content);
  EXPECT_CONTAINS(readFile(folder.file("large.tfw")), "0.0500000000\n");
}

TEST(GeotiffTest, ErrorsNameTheFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(messageOf([&] { writeGeotiff(folder.file("map"), GeotiffContent()); }),
            "cannot write " + folder.file("map.tif") + ": the map is empty");
  EXPECT_CONTAINS(messageOf([&] { writeGeotiff(folder.file("no/map"), exampleContent()); }),
                  "No such file");
}

}  // namespace
}  // namespace kestrel
