// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/session/finished_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "kestrel_slam/graph/relocalizer.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/map/pgm.h"
#include "room.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// How a picture of the room differs from what save_map writes.
struct Variant {
  const char* name = "";
  double resolution_m = 0.05;
  Pose2 map_T_picture;  ///< in the frame of the picture the room is turned and moved
  std::string mode = "trinary";
  bool negate = false;
  /// Of the gray value that save_map writes (0, 205 or 254).
  std::function<int(int)> gray = [](int value) { return value; };
};

void PrintTo(const Variant& variant, std::ostream* out) { *out << variant.name; }

MapSnapshot pictureOf(const Variant& variant) {
  OccupancyGridConfig config;
  config.resolution_m = variant.resolution_m;
  Submap map(config);
  for (const Pose2& pose : {Pose2(0, 0, 0), Pose2(0.5, 0.3, 1), Pose2(-2, -1, 2)})
    map.insert(room::scanFrom(pose), variant.map_T_picture.inverse() * pose, true);
  return map.grid().snapshot();
}

std::string yamlOf(const Variant& variant, const MapSnapshot& picture) {
  const Pose2 origin = variant.map_T_picture * Pose2(picture.origin_x, picture.origin_y, 0.0);
  char text[300];
  std::snprintf(text, sizeof text,
                "image: m.pgm\nmode: %s\nresolution: %g\norigin: [%.9f, %.9f, %.9f]\nnegate: %d\n"
                "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
                variant.mode.c_str(), variant.resolution_m, origin.x, origin.y, origin.yaw,
                variant.negate ? 1 : 0);
  return text;
}

class PictureOfAMap : public ::testing::TestWithParam<Variant> {};

TEST_P(PictureOfAMap, AVehicleIsFoundInIt) {
  const Variant& variant = GetParam();
  const TemporaryFolder folder;
  const MapSnapshot picture = pictureOf(variant);
  writeMap(folder.file("m"), picture);
  GrayImage image = decodePgm(readFile(folder.file("m.pgm")));
  for (std::uint8_t& pixel : image.pixels) pixel = static_cast<std::uint8_t>(variant.gray(pixel));
  writeFileAtomically(folder.file("m.pgm"), encodePgm(image, "a test"));
  writeFileAtomically(folder.file("m.yaml"), yamlOf(variant, picture));
  const Submap map = loadFinishedMap(folder.file("m.yaml"), OccupancyGridConfig());
  const GlobalMap global(map);
  Relocalizer relocalizer(global, MatcherConfig(), RelocalizationConfig());
  const Pose2 truth(1, -1, 2.1);
  const RelocalizationAnswer answer = relocalizer.locate({{{Pose2(), room::scanFrom(truth)}}});
  ASSERT_EQ(answer.state, RelocalizationState::kFound) << answer.reason;
  const Pose2 error = truth.between(answer.pose().mean);
  EXPECT_LT(error.distance(), variant.resolution_m);
  EXPECT_LT(std::abs(error.yaw), 0.03);
}

int rawOf(int gray) { return gray == 254 ? 0 : (gray == 0 ? 100 : 255); }

std::vector<Variant> variants() {
  std::vector<Variant> result(8);
  result[0].name = "plain";
  result[1].name = "coarse";
  result[1].resolution_m = 0.1;
  result[2].name = "fine";
  result[2].resolution_m = 0.025;
  result[3].name = "turned";
  result[3].map_T_picture = Pose2(3, -2, 0.6);
  result[4].name = "turned_by_a_right_angle";
  result[4].map_T_picture = Pose2(0, 0, kPi / 2.0);
  result[5].name = "negated";
  result[5].negate = true;
  result[5].gray = [](int gray) { return 255 - gray; };
  result[6].name = "scale";
  result[6].mode = "scale";
  result[7].name = "raw";
  result[7].mode = "raw";
  result[7].gray = rawOf;
  return result;
}

std::string nameOf(const ::testing::TestParamInfo<Variant>& variant) { return variant.param.name; }

INSTANTIATE_TEST_SUITE_P(Kinds, PictureOfAMap, ::testing::ValuesIn(variants()), nameOf);

std::string errorOf(const std::string& file) {
  try {
    loadFinishedMap(file, OccupancyGridConfig());
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(FinishedMap, SaysWhatIsNoMap) {
  const TemporaryFolder folder;
  writeMap(folder.file("m"), room::map().grid().snapshot());
  EXPECT_NE(errorOf(folder.file("m.pgm")).find("give its YAML file"), std::string::npos);
  EXPECT_NE(errorOf(folder.file("")).find("is a folder"), std::string::npos);
  EXPECT_NE(errorOf(folder.file("none.yaml")).find("does not exist"), std::string::npos);
  EXPECT_NE(errorOf(folder.write("text.yaml", "a: b\n")).find("'resolution' is missing"),
            std::string::npos);
}

}  // namespace
}  // namespace kestrel
