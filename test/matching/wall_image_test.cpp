// SPDX-License-Identifier: BSD-3-Clause
// The rough image of the walls and the sums over it, compared with their definitions.

#include "../../src/matching/wall_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "../../src/matching/rough_grid.h"
#include "kestrel_slam/map/submap.h"
#include "room.h"

namespace kestrel {
namespace {

/// Two rooms with nothing between them, so that rows of the image are empty.
Submap rooms() {
  Submap map = room::map();
  map.insert(room::scanFrom(Pose2()), Pose2(14.0, 20.0, 0.7));
  return map;
}

class Image : public ::testing::TestWithParam<int> {
 protected:
  static constexpr int kLayers = WallImage::kMostLayers, kFarthest = 9;
  const CellBox box_{{-160, -140}, {500, 620}};
  Submap map_ = rooms();
  WallImage image_{map_.surface(), box_, GetParam(), kLayers};

  int valueAt(int layer, int column, int row) const {
    return image_.layer(layer)[row * image_.stride() + column];
  }
  int columns() const { return (box_.high.x - image_.corner().x) / image_.cellsPerPixel(); }
  int rows() const { return (box_.high.y - image_.corner().y) / image_.cellsPerPixel(); }
  bool isWall(int column, int row) const {
    const int side = image_.cellsPerPixel();
    const Cell corner{image_.corner().x + column * side, image_.corner().y + row * side};
    for (int y = corner.y; y < corner.y + side; ++y) {
      for (int x = corner.x; x < corner.x + side; ++x)
        if (map_.grid().isOccupied({x, y})) return true;
    }
    return false;
  }
  /// The maximum of a layer over the pixels that are not farther than `reach` in x and y.
  int most(int layer, int column, int row, int reach) const {
    int result = 0;
    for (int y = row - reach; y <= row + reach; ++y) {
      for (int x = column - reach; x <= column + reach; ++x)
        result = std::max(result, valueAt(layer, x, y));
    }
    return result;
  }
};

TEST_P(Image, TheFirstLayerHasTheWallsAndHalfBesideThem) {
  int walls = 0;
  for (int row = kFarthest; row < rows() - kFarthest; ++row) {
    for (int column = kFarthest; column < columns() - kFarthest; ++column) {
      const bool is_beside = isWall(column - 1, row) || isWall(column + 1, row) ||
                             isWall(column, row - 1) || isWall(column, row + 1);
      const int value = valueAt(0, column, row);
      walls += isWall(column, row) ? 1 : 0;
      if (isWall(column, row)) {
        ASSERT_EQ(value, WallImage::kWall);
      } else if (is_beside) {
        ASSERT_EQ(value, WallImage::kWall / 2);
      } else {
        ASSERT_LT(value, WallImage::kWall / 2);
      }
    }
  }
  EXPECT_GT(walls, 50);
}

TEST_P(Image, EveryOtherLayerIsTheMaximumOfTheFirst) {
  for (int layer = 1; layer < kLayers; ++layer) {
    const int reach = 1 << (layer - 1);
    for (int row = kFarthest; row < rows() - kFarthest; ++row) {
      for (int column = kFarthest; column < columns() - kFarthest; ++column)
        ASSERT_EQ(valueAt(layer, column, row), most(0, column, row, reach))
            << "layer " << layer << ", " << column << ", " << row;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfPixels, Image, ::testing::Values(1, 2, 3));

/// How much of the scan is on walls in layer 0, if all of its points are so near that they use it.
int sumAt(const WallImage& image, const Points& points, const Pose2& pose, double pixel_m) {
  const double cell_m = pixel_m / image.cellsPerPixel();
  int sum = 0;
  for (const Eigen::Vector2f& p : points) {
    const Eigen::Vector2d at = (pose * p.cast<double>()) / cell_m;
    const auto column = static_cast<int>((at.x() - image.corner().x) / image.cellsPerPixel());
    const auto row = static_cast<int>((at.y() - image.corner().y) / image.cellsPerPixel());
    sum += image.layer(0)[row * image.stride() + column];
  }
  return sum;
}

TEST(RoughGrid, SumsTheValuesOfAllPointsAtEveryPose) {
  const Submap map = rooms();
  std::mt19937_64 random(3);
  std::uniform_real_distribution<float> angle(-3.1F, 3.1F);
  // Numbers of points that are no multiple of those that are summed together.
  for (const std::size_t count : {3U, 8U, 21U, 96U}) {
    Points points;
    for (std::size_t i = 0; i < count; ++i) {
      const float a = angle(random);
      points.emplace_back(3.0F * std::cos(a), 3.0F * std::sin(a));
    }
    RoughWindow window{Pose2(0.3, -0.2, 0.4), {2.0, 0.5}, {}, {}, 0};
    RoughGrid grid(map.surface(), points, window, 2);
    const auto image = grid.imageOf(map.surface());
    RoughGrid::Sums sums;
    int wrong = 0, all = 0;
    for (int k = -grid.angularSteps(); k <= grid.angularSteps(); ++k) {
      grid.rotate(*image, k);
      const RoughPart part{-7, -5, 16, 11};
      grid.sum(part, sums);
      for (int row = 0; row < part.rows; ++row) {
        for (int column = 0; column < part.columns; ++column, ++all) {
          const Pose2 pose = grid.pose(k, part.dx + column, part.dy + row);
          const int sum = sums[static_cast<std::size_t>(row * RoughPart::kSide + column)];
          // A point at the border of a pixel may be rounded into the one beside it.
          wrong += std::abs(sum - sumAt(*image, points, pose, grid.pixel())) > 0 ? 1 : 0;
        }
      }
    }
    EXPECT_LT(wrong, all / 50) << count << " points";
    EXPECT_GT(all, 1000);
  }
}

}  // namespace
}  // namespace kestrel
