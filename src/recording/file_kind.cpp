// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/file_kind.h"

#include <algorithm>
#include <filesystem>
#include <istream>
#include <memory>
#include <vector>

#include "affixes.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMagicBytes = 512;

const std::string kConvertRos2 =
    "convert it with `rosbags-convert --src SOURCE --dst NAME.bag` (Python package rosbags)";
const std::string kUnpack = "unpack it, and give the recording that is in it";

/// The first bytes of a format.
struct Kind {
  std::string magic;
  std::string text;
};

/// Keeps zero bytes in a literal.
template <std::size_t size>
std::string bytes(const char (&literal)[size]) {
  return std::string(literal, size - 1);
}

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kKinds = {
      {bytes("SQLite format 3\0"), "is a ROS 2 bag (SQLite); " + kConvertRos2},
      {bytes("\x89MCAP"), "is a ROS 2 bag (MCAP); " + kConvertRos2},
      {bytes("\x28\xb5\x2f\xfd"), "is a file compressed with zstd; decompress it with `zstd -d`"},
      {bytes("\x04\x22\x4d\x18"), "is a file compressed with lz4; decompress it with `lz4 -d`"},
      {bytes("PK\x03\x04"), "is a ZIP archive; " + kUnpack},
      {bytes("7z\xbc\xaf\x27\x1c"), "is a 7z archive; " + kUnpack},
      {bytes("Rar!"), "is a RAR archive; " + kUnpack},
      {bytes("#ROSLOG"), "is a rosbag of an old version; convert it with `rosbag fix`"},
      {bytes("#ROSRECORD"), "is a rosbag of an old version; convert it with `rosbag fix`"},
      {bytes("#ROSBAG V1"), "is a rosbag of an old version; convert it with `rosbag fix`"},
      {bytes("\xd4\xc3\xb2\xa1"),
       "is a capture of network packets; record a bag while the driver of the lidar replays it"},
      {bytes("\xa1\xb2\xc3\xd4"),
       "is a capture of network packets; record a bag while the driver of the lidar replays it"},
      {bytes("\x0a\x0d\x0d\x0a"),
       "is a capture of network packets; record a bag while the driver of the lidar replays it"},
      {bytes("ULog"), "is a flight log of PX4, which has no laser scans; use a rosbag"},
      {bytes("\xed\xa1\xda\x01"), "is a log of LCM; convert it to a rosbag"},
      {bytes("# .PCD"), "is a single point cloud (PCD); `slice_cloud` reads it"},
      {bytes("ply\n"), "is a single point cloud (PLY), not a recording"},
      {bytes("LASF"), "is a single point cloud (LAS), not a recording"},
      {bytes("\x89HDF"), "is an HDF5 file; convert it to a rosbag or to a table of ranges"},
      {bytes("\x89PNG"), "is an image, not a recording"},
      {bytes("P5\n"), "is an image (a map?), not a recording"},
      {bytes("\x7f"
             "ELF"),
       "is a program, not a recording"}};
  return kKinds;
}

std::string folderKind(const std::string& path) {
  if (fs::exists(fs::path(path) / "metadata.yaml")) {
    return "is the folder of a ROS 2 bag; " + kConvertRos2;
  }
  return "is a folder; give the files in it (several bags of one recording: one after the other)";
}

}  // namespace

bool isCompressed(const std::string& path) {
  const std::string magic = readMagic(path, kMagicBytes);
  return startsWith(magic, bytes("BZh")) || startsWith(magic, bytes("\x1f\x8b")) ||
         startsWith(magic, bytes("\xfd\x37zXZ\0"));
}

std::string startOf(const std::string& path) {
  if (!isCompressed(path)) return readMagic(path, kMagicBytes);
  const std::unique_ptr<std::istream> stream = openText(path);
  std::string start;
  // One by one: damaged data farther on must not hide the first bytes.
  for (char byte = 0; start.size() < kMagicBytes && stream->get(byte);) start += byte;
  return start;
}

std::string foreignKind(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return folderKind(path);
  const std::string head = startOf(path);
  const auto kind = std::find_if(kinds().begin(), kinds().end(),
                                 [&](const Kind& k) { return startsWith(head, k.magic); });
  if (kind != kinds().end()) return kind->text;
  constexpr std::size_t kTarPosition = 257;
  if (head.size() > kTarPosition && head.compare(kTarPosition, 5, "ustar") == 0) {
    return "is a TAR archive; " + kUnpack;
  }
  return "";
}

}  // namespace kestrel
