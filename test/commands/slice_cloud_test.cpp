// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "kestrel_slam/recording/cloud_file.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

template <typename T>
std::string bytesOf(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::string pcdHeader(const std::string& data, const std::string& points = "2") {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\n"
         "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " +
         points + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA " + data + "\n";
}

std::string problemOf(const std::string& path) {
  return messageOf([&] { readCloudFile(path); });
}

TEST(CloudFile, ReadsBinaryPcdWithPadding) {
  const TemporaryFolder folder;
  const std::string points = bytesOf<float>({1.0F, 2.0F, 3.0F, 0.5F, 4.0F, 5.0F, -6.0F, 0.5F});
  const PointCloud cloud = readCloudFile(
      folder.write("a.pcd", pcdHeader("binary") + points + std::string(4096, '\x7f')));
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.points[0].x, 1.0F);
  EXPECT_EQ(cloud.points[1].y, 5.0F);
  EXPECT_EQ(cloud.points[1].z, -6.0F);
  EXPECT_EQ(cloud.stamp, 0.0);
}

TEST(CloudFile, ReadsAsciiPcdWithNan) {
  const TemporaryFolder folder;
  const PointCloud cloud =
      readCloudFile(folder.write("a.pcd", pcdHeader("ascii") + "1 2 3 9\nnan nan nan 9\n"));
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.points[0].z, 3.0F);
  EXPECT_TRUE(std::isnan(cloud.points[1].x));
}

TEST(CloudFile, ReadsRawNumbersByFileExtension) {
  const TemporaryFolder folder;
  std::vector<float> numbers(20, 7.0F);
  numbers[4] = 40.0F;
  numbers[5] = 50.0F;
  const PointCloud kitti = readCloudFile(folder.write("a.bin", bytesOf(numbers)));
  ASSERT_EQ(kitti.points.size(), 5U);
  EXPECT_EQ(kitti.points[1].x, 40.0F);
  const PointCloud nuscenes = readCloudFile(folder.write("a.pcd.bin", bytesOf(numbers)));
  ASSERT_EQ(nuscenes.points.size(), 4U);
  EXPECT_EQ(nuscenes.points[1].x, 50.0F);
}

TEST(CloudFile, ErrorsDescribeTheProblem) {
  const TemporaryFolder folder;
  EXPECT_CONTAINS(problemOf(folder.file("no.pcd")), "no.pcd: the file does not exist");
  EXPECT_CONTAINS(problemOf(folder.write("a.txt", "hello")),
                  "a.txt: is not a point cloud; use a rosbag");
  EXPECT_CONTAINS(problemOf(folder.write("a.pcd", pcdHeader("binary") + "abc")),
                  "a.pcd: the payload of the cloud has 3 bytes, fewer than 1 rows of 32 bytes");
  EXPECT_CONTAINS(problemOf(folder.write("a.pcd", pcdHeader("binary_compressed"))),
                  "convert the file with `pcl_convert_pcd_ascii_binary");
  EXPECT_CONTAINS(problemOf(folder.write("a.pcd", pcdHeader("ascii") + "1 2 x 4")),
                  "a.pcd: 'x' is not a number");
  EXPECT_CONTAINS(problemOf(folder.write("a.pcd", pcdHeader("binary", "0"))), "zero points");
  EXPECT_CONTAINS(problemOf(folder.write("a.pcd", pcdHeader("binary", "99999999999999999999"))),
                  "a.pcd: ");
  EXPECT_CONTAINS(problemOf(folder.write("a.pcd", "VERSION 0.7\nFIELDS x y\n")),
                  "the PCD header is invalid");
  EXPECT_CONTAINS(problemOf(folder.write("a.pcd.bin", "1234567")),
                  "is not a multiple of the point size");
}

/// Exit code and output of the tool.
struct ToolRun {
  int code = -1;
  std::string output;
};

ToolRun sliceCloud(const std::string& arguments) {
  const std::string command =
      std::string("'") + KESTREL_TOOL_DIR + "/slice_cloud' " + arguments + " 2>&1";
  ToolRun run;
  FILE* pipe = popen(command.c_str(), "r");
  char buffer[4096];
  while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) run.output += buffer;
  const int status = pclose(pipe);
  run.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return run;
}

std::string magicOf(const std::string& path) {
  std::string bytes(4, '\0');
  std::ifstream(path, std::ios::binary).read(bytes.data(), 4);
  return bytes;
}

/// The numbers in the line of a frame: points, hits, clears, floor, outside.
std::vector<int> rowOf(const std::string& output, const std::string& frame) {
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    if (line.compare(0, frame.size() + 1, frame + ' ') != 0) continue;
    std::istringstream fields(line.substr(frame.size()));
    std::vector<int> numbers;
    for (int number = 0; fields >> number;) numbers.push_back(number);
    return numbers;
  }
  return {};
}

TEST(SliceCloud, CountsAndPlotsARoom) {
  const TemporaryFolder folder;
  std::string points;
  for (int degree = 0; degree < 360; ++degree) {
    const double angle = (degree + 0.1) * 0.0174532925;  // off the border of a bin
    const double x = 5.0 * std::cos(angle), y = 5.0 * std::sin(angle);
    for (const double z : {-1.5, 0.0, 0.3, 2.5}) {  // floor, wall, wall, above
      std::ostringstream line;
      line << x << ' ' << y << ' ' << z << " 1\n";
      points += line.str();
    }
  }
  const std::string file = folder.write("room.pcd", pcdHeader("ascii", "1440") + points);
  const ToolRun run = sliceCloud(file + " --output " + folder.file("out") + " --set height=1.5");
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_EQ(rowOf(run.output, "room"), (std::vector<int>{1440, 360, 0, 360, 360})) << run.output;
  EXPECT_EQ(magicOf(folder.file("out/room.png")), "\x89PNG");
}

TEST(SliceCloud, ReportsBadInput) {
  const TemporaryFolder folder;
  const std::string file = folder.write("a.pcd", pcdHeader("ascii") + "1 0 0 1\n2 1 0 1\n");
  const std::string out = " --output " + folder.file("out");
  EXPECT_EQ(sliceCloud(file).code, 2);
  EXPECT_EQ(sliceCloud("--help").code, 0);
  const ToolRun missing = sliceCloud(folder.file("no.pcd") + out);
  EXPECT_EQ(missing.code, 1);
  EXPECT_CONTAINS(missing.output,
                  "slice_cloud: " + folder.file("no.pcd") + ": the file does not exist");
  const ToolRun parameter = sliceCloud(file + out + " --set hight=1");
  EXPECT_EQ(parameter.code, 1);
  EXPECT_CONTAINS(parameter.output, "hight");
  const std::string far = folder.write("nan.pcd", pcdHeader("ascii") + "nan 0 0 1\n0 0 0 1\n");
  const ToolRun empty = sliceCloud(far + out);
  EXPECT_EQ(empty.code, 1);
  EXPECT_CONTAINS(empty.output, "no frame could be sliced");
}

TEST(SliceCloud, FramesOfAnHdl64GiveSlices) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const TemporaryFolder folder;
  const std::string unpack =
      "tar -xJf '" + data + "/cloud/hdl64e_full_frames.tar.xz' -C " + folder.file("");
  ASSERT_EQ(std::system(unpack.c_str()), 0);
  std::string files;
  for (int i = 0; i < 6; ++i) files += folder.file("000000000" + std::to_string(i) + ".pcd ");
  const ToolRun run =
      sliceCloud(files + "--pictures 1 --output " + folder.file("out") + " --set height=1.73");
  EXPECT_EQ(run.code, 0) << run.output;
  for (int i = 0; i < 6; ++i) {
    const std::string frame = "000000000" + std::to_string(i);
    const std::vector<int> row = rowOf(run.output, frame);
    ASSERT_EQ(row.size(), 5U) << run.output;
    EXPECT_GT(row[0], 120'000) << frame;
    EXPECT_GT(row[1], 300) << frame;     // hits: of 1080 directions
    EXPECT_GT(row[3], 20'000) << frame;  // floor: the road
    EXPECT_EQ(magicOf(folder.file("out/" + frame + ".png")), "\x89PNG");
  }
}

TEST(SliceCloud, FrameOfAnHdl32GivesASlice) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const PointCloud cloud = readCloudFile(data + "/cloud/hdl32e_single_frame.pcd.bin");
  EXPECT_EQ(cloud.points.size(),
            std::filesystem::file_size(data + "/cloud/hdl32e_single_frame.pcd.bin") / 20U);
  const TemporaryFolder folder;
  const ToolRun run = sliceCloud(data + "/cloud/hdl32e_single_frame.pcd.bin --output " +
                                 folder.file("out") + " --set height=1.84");
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_EQ(magicOf(folder.file("out/hdl32e_single_frame.pcd.png")), "\x89PNG");
}

#ifdef KESTREL_WITH_ROS
TEST(SliceCloud, SlicesEveryCloudOfABag) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const TemporaryFolder folder;
  const ToolRun run =
      sliceCloud(data + "/cloud/kitti0000_slice.bag --pictures 1 --output " + folder.file("out"));
  EXPECT_EQ(run.code, 0) << run.output;
  EXPECT_CONTAINS(run.output, "\nkitti0000_slice_0000                30277 ");
  for (int i = 0; i < 154; ++i) {
    char frame[40];
    std::snprintf(frame, sizeof frame, "kitti0000_slice_%04d", i);
    const std::vector<int> row = rowOf(run.output, frame);
    ASSERT_EQ(row.size(), 5U) << frame;
    EXPECT_GT(row[1], 300) << frame;
  }
  EXPECT_EQ(magicOf(folder.file("out/kitti0000_slice_0000.png")), "\x89PNG");
  EXPECT_FALSE(std::filesystem::exists(folder.file("out/kitti0000_slice_0001.png")));
}
#endif

}  // namespace
}  // namespace kestrel
