// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/map_image.h"

#include <cairo/cairo.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace kestrel {
namespace {

constexpr std::int8_t kU = MapSnapshot::kUnknown, kF = MapSnapshot::kFree,
                      kO = MapSnapshot::kOccupied;

MapSnapshot mapOf(int width, int height, std::vector<std::int8_t> cells) {
  MapSnapshot map;
  map.width = width;
  map.height = height;
  map.cells = std::move(cells);
  return map;
}

struct Source {
  const std::string& bytes;
  std::size_t position = 0;
};

cairo_status_t readSome(void* closure, unsigned char* data, unsigned int length) {
  Source& source = *static_cast<Source*>(closure);
  if (source.position + length > source.bytes.size()) return CAIRO_STATUS_READ_ERROR;
  std::copy_n(source.bytes.begin() + static_cast<std::ptrdiff_t>(source.position), length, data);
  source.position += length;
  return CAIRO_STATUS_SUCCESS;
}

/// The gray values of a PNG, row-major, top row first.
std::vector<int> graysOf(const std::string& png) {
  Source source{png};
  const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface(
      cairo_image_surface_create_from_png_stream(readSome, &source), &cairo_surface_destroy);
  EXPECT_EQ(cairo_surface_status(surface.get()), CAIRO_STATUS_SUCCESS);
  std::vector<int> grays;
  for (int y = 0; y < cairo_image_surface_get_height(surface.get()); ++y) {
    const unsigned char* row = cairo_image_surface_get_data(surface.get()) +
                               y * cairo_image_surface_get_stride(surface.get());
    constexpr int kBytesPerPixel = 4;
    for (int x = 0; x < cairo_image_surface_get_width(surface.get()); ++x) {
      grays.push_back(row[kBytesPerPixel * x]);
    }
  }
  return grays;
}

TEST(MapImageTest, FirstRowIsTheTopOfTheMap) {
  const MapImage image = renderMap(mapOf(2, 2, {kU, kF, kO, kF}));
  EXPECT_EQ(image.width, 2);
  EXPECT_EQ(image.height, 2);
  EXPECT_EQ(image.cells_per_pixel, 1);
  EXPECT_EQ(graysOf(image.png), (std::vector<int>{0, 254, 205, 254}));
}

TEST(MapImageTest, LargeMapIsReducedAndKeepsItsWalls) {
  // Bottom row first. With at most two pixels, blocks have 2 x 2 cells; the last one has one
  // column.
  const MapImage image = renderMap(mapOf(3, 2, {kF, kU, kU, kO, kF, kF}), 2);
  EXPECT_EQ(image.width, 2);
  EXPECT_EQ(image.height, 1);
  EXPECT_EQ(image.cells_per_pixel, 2);
  EXPECT_EQ(graysOf(image.png), (std::vector<int>{0, 254}));
}

TEST(MapImageTest, EmptyMapGivesNoImage) {
  const MapImage image = renderMap(MapSnapshot());
  EXPECT_TRUE(image.png.empty());
  EXPECT_EQ(image.width, 0);
}

TEST(WallBoxTest, EnclosesTheWallsButNotFreeSpaceOrAFarCell) {
  MapSnapshot map = mapOf(1000, 500, std::vector<std::int8_t>(500000, kF));
  map.resolution_m = 0.1;
  map.origin_x = -50.0;
  const auto occupy = [&map](int column, int row) {
    map.cells[static_cast<std::size_t>(1000 * row + column)] = kO;
  };
  EXPECT_FALSE(wallBox(map));
  for (int column = 300; column < 700; ++column) {
    for (const int row : {100, 199}) occupy(column, row);
  }
  occupy(990, 490);
  const std::optional<Eigen::AlignedBox2d> box = wallBox(map);
  ASSERT_TRUE(box);
  EXPECT_NEAR(box->min().x(), -20.0, 0.5);
  EXPECT_NEAR(box->max().x(), 20.0, 0.5);
  EXPECT_NEAR(box->min().y(), 10.0, 1e-9);
  EXPECT_NEAR(box->max().y(), 20.0, 1e-9);
}

TEST(Base64Test, MatchesTheVectorsOfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64(std::string("\xff\x00\xfe", 3)), "/wD+");
}

}  // namespace
}  // namespace kestrel
