// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_index.h"

#include <filesystem>
#include <fstream>

#include "bag_maker.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/recording/bag/bag_files.h"
#include "kestrel_slam/recording/bag/bag_structure.h"
#include "kestrel_slam/recording/recording_info.h"

namespace kestrel {
namespace {

/// Bytes that this process has read so far.
std::uintmax_t bytesRead() {
  std::ifstream file("/proc/self/io");
  std::string name;
  std::uintmax_t bytes = 0;
  file >> name >> bytes;
  return bytes;
}

class BagIndexTest : public BagTest {
 protected:
  std::string flight(rosbag::CompressionType compression) {
    writeBag(
        [](rosbag::Bag& bag) {
          bag.setChunkThreshold(20000);
          for (int i = 0; i < 3000; ++i) {
            const double time = kBagStart + 0.01 * i;
            record(bag, "/imu", time, imuReading(time));
            if (i % 10 == 0) record(bag, "/scan", time, turnPart(0, 360));
          }
        },
        path_, compression);
    return path_;
  }
};

TEST_F(BagIndexTest, SaysTheSameAsTheWholeBag) {
  for (const auto compression : {rosbag::compression::Uncompressed, rosbag::compression::BZ2}) {
    const std::string path = flight(compression);
    const BagIndex index = readBagIndex(path);
    const BagFiles whole({path});
    EXPECT_EQ(index.begin, whole.begin());
    EXPECT_EQ(index.end, whole.end());
    const BagTopics topics = whole.topics();
    ASSERT_EQ(index.topics.size(), topics.size());
    for (const auto& [name, topic] : topics) {
      const BagTopic& found = index.topics.at(name);
      EXPECT_EQ(found.messages, topic.messages) << name;
      EXPECT_EQ(found.type, topic.type);
      EXPECT_EQ(found.md5, topic.md5);
    }
  }
}

TEST_F(BagIndexTest, ReadsOnlyTheEnd) {
  const std::string path = flight(rosbag::compression::Uncompressed);
  const std::uintmax_t size = std::filesystem::file_size(path), before = bytesRead();
  readBagIndex(path);
  EXPECT_LT(bytesRead() - before, size / 10);
}

/// Thousands of short messages once cost 8 kB for every part of a record.
TEST_F(BagIndexTest, TheCheckOfTheStructureReadsTheFileOnce) {
  const std::string path = flight(rosbag::compression::Uncompressed);
  const std::uintmax_t size = std::filesystem::file_size(path), before = bytesRead();
  EXPECT_EQ(checkBagStructure(path), 0U);
  EXPECT_LT(bytesRead() - before, size + size / 2);
}

TEST_F(BagIndexTest, WithoutAnIndexTheWholeBagIsAsked) {
  const std::string path = flight(rosbag::compression::Uncompressed);
  const std::string content = readFile(path);
  for (const double part : {0.01, 0.5, 0.99}) {
    const auto bytes = static_cast<std::size_t>(part * static_cast<double>(content.size()));
    folder_.write("a.bag", content.substr(0, bytes));
    EXPECT_THROW(readBagIndex(path), std::exception) << part;
    const RecordingInfo quick = infoOf(path, true), whole = infoOf(path);
    EXPECT_EQ(quick.problem, whole.problem);
    EXPECT_FALSE(quick.problem.empty()) << part;
  }
  writeBag([](rosbag::Bag&) {}, path_);
  EXPECT_THROW(readBagIndex(path), std::exception);
  EXPECT_CONTAINS(infoOf(path, true).problem, "has no messages");
}

TEST_F(BagIndexTest, EveryDamagedByteOfTheIndexIsRefusedOrRead) {
  const std::string path = flight(rosbag::compression::Uncompressed);
  const std::string content = readFile(path);
  const std::size_t tail = 3000;
  for (std::size_t i = 13; i < content.size(); i += i < 200 ? 1 : 37) {
    if (i > 200 && i < content.size() - tail) i = content.size() - tail;
    std::string damaged = content;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x55);
    folder_.write("a.bag", damaged);
    const RecordingInfo info = infoOf(path, true);
    EXPECT_EQ(info.format, "rosbag") << i;
    EXPECT_TRUE(!info.problem.empty() || !info.topics.empty()) << i;
  }
}

}  // namespace
}  // namespace kestrel
