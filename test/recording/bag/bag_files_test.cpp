// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_files.h"

#include <sys/stat.h>

#include <boost/iostreams/copy.hpp>
#include <boost/iostreams/filter/bzip2.hpp>
#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filtering_stream.hpp>
#include <chrono>
#include <fstream>
#include <sstream>

#include "bag_maker.h"

namespace kestrel {
namespace {

std::string contentOf(const std::string& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

template <typename Compressor>
std::string compressed(const std::string& content) {
  std::istringstream source(content);
  boost::iostreams::filtering_istream stream;
  stream.push(Compressor());
  stream.push(source);
  std::ostringstream result;
  boost::iostreams::copy(stream, result);
  return result.str();
}

class BagFilesTest : public BagTest {
 protected:
  /// Scans `from` to `to` of a recording, in chunks of a few scans.
  std::string part(const std::string& name, int from, int to,
                   rosbag::CompressionType compression = rosbag::compression::Uncompressed) {
    const std::string path = folder_.file(name);
    writeBag(
        [&](rosbag::Bag& bag) {
          bag.setChunkThreshold(10000);
          if (from == 0) {
            record(bag, "/tf_static", kBagStart, transform("base_link", "laser", kBagStart, 0.5));
          }
          for (int i = from; i < to; ++i) {
            record(bag, "/scan", kBagStart + 0.1 * i,
                   turnPart(static_cast<std::size_t>(360 * i), 360));
          }
        },
        path, compression);
    return path;
  }

  static std::string problem(const std::string& path) {
    return messageOf([&] { openRecording(path); });
  }
};

TEST_F(BagFilesTest, TheFilesOfASplitRecordingAreOneRecording) {
  const std::string first = part("r_0.bag", 0, 20), second = part("r_1.bag", 20, 45);
  const auto recording = openRecording(std::vector<std::string>{second, first});
  EXPECT_EQ(recording->scanCount(), 45U);
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 45U);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_NEAR(scans[i].scan.stamp, kBagStart + 0.1 * static_cast<double>(i), 1e-6);
    EXPECT_EQ(scans[i].base_T_laser.translation().x(), 0.5)
        << "tf_static is in the first file only";
  }
  EXPECT_EQ(warningsOf(*recording), "");
}

TEST_F(BagFilesTest, FilesFarApartAreDoubted) {
  const std::string first = part("a_0.bag", 0, 20), second = part("b_0.bag", 40000, 40010);
  const auto recording = openRecording(std::vector<std::string>{first, second});
  EXPECT_CONTAINS(warningsOf(*recording), "3998 s after the end of " + first);
  EXPECT_CONTAINS(messageOf([&] {
                    openRecording(std::vector<std::string>{first, first});
                  }),
                  "the bag is given twice");
  const std::string log = folder_.write("a.clf", "FLASER 1 1 0 0 0 0 0 0 5 h 0\n");
  EXPECT_CONTAINS(messageOf([&] {
                    openRecording(std::vector<std::string>{first, log});
                  }),
                  "a.clf: is no rosbag; only bags can be parts of one recording");
}

TEST_F(BagFilesTest, CompressedBagsAreReadWhateverTheirName) {
  const std::string content = contentOf(part("a.bag", 0, 200));
  namespace io = boost::iostreams;
  const std::string gzip = folder_.write("b", compressed<io::gzip_compressor>(content));
  const std::string bzip2 = folder_.write("c.bag", compressed<io::bzip2_compressor>(content));
  for (const std::string& path : {gzip, bzip2}) {
    const auto recording = openRecording(path);
    EXPECT_EQ(readAll(*recording).size(), 200U) << path;
  }
  const std::string cut =
      folder_.write("d.bag.gz", contentOf(gzip).substr(0, contentOf(gzip).size() / 2));
  EXPECT_CONTAINS(problem(cut), "d.bag.gz: the compressed data are damaged or cut off");
}

TEST_F(BagFilesTest, OtherFormatsAreNamedWithWhatToDo) {
  const std::pair<std::string, std::string> kinds[] = {
      {std::string("SQLite format 3\0", 16), "is a ROS 2 bag (SQLite); convert it with"},
      {"\x89MCAP0\r\n", "is a ROS 2 bag (MCAP); convert it with"},
      {"\x28\xb5\x2f\xfd....", "compressed with zstd"},
      {"PK\x03\x04....", "is a ZIP archive"},
      {"#ROSBAG V1.2\n", "is a rosbag of an old version"},
      {"ULog\x01\x12\x35", "is a flight log of PX4"},
      {std::string(257, 'x') + "ustar", "is a TAR archive"}};
  for (const auto& [content, text] : kinds) {
    EXPECT_CONTAINS(problem(folder_.write("x.bag", content)), text);
  }
  std::filesystem::create_directory(folder_.file("ros2"));
  folder_.write("ros2/metadata.yaml", "rosbag2_bagfile_information:\n");
  EXPECT_CONTAINS(problem(folder_.file("ros2")), "is the folder of a ROS 2 bag; convert it with");
  ASSERT_EQ(mkfifo(folder_.file("pipe").c_str(), 0600), 0);
  EXPECT_CONTAINS(problem(folder_.file("pipe")), "is a pipe or a device, not a file");
  std::filesystem::create_directory(folder_.file("parts"));
  EXPECT_CONTAINS(problem(folder_.file("parts")), "is a folder");
}

TEST_F(BagFilesTest, ReindexIsAdvisedOnlyWhereItHelps) {
  const std::string path = part("a.bag", 0, 50);
  const std::string whole = contentOf(path);
  folder_.write("a.bag", whole.substr(0, whole.size() / 2));
  EXPECT_CONTAINS(problem(path), "rosbag reindex " + path + "` may repair it");
  folder_.write("a.bag", whole.substr(0, 4200 + 2000));  // inside of the first chunk
  EXPECT_CONTAINS(problem(path), "`rosbag reindex` cannot save any message");
}

TEST_F(BagFilesTest, AnEmptyBagIsNamed) {
  writeBag([](rosbag::Bag&) {}, path_);
  EXPECT_CONTAINS(problem(path_), "a.bag: the bag has no messages");
}

TEST_F(BagFilesTest, ADamagedChunkCostsItsMessagesOnlyAndIsCounted) {
  for (const auto& [compression, magic] : {std::pair{rosbag::compression::BZ2, "BZh"},
                                           {rosbag::compression::LZ4, "\x04\x22\x4d\x18"}}) {
    const std::string path = part("a.bag", 0, 400, compression);
    const std::string good = contentOf(path);
    std::string bad = good;
    const std::size_t chunk = bad.find(magic, bad.size() / 3);
    for (std::size_t i = 0; i < 8; ++i) bad[chunk + 100 + i] ^= '\x55';
    folder_.write("a.bag", bad);
    const auto recording = openRecording(path);
    const std::vector<RecordedScan> scans = readAll(*recording);
    EXPECT_LT(scans.size(), 400U);
    EXPECT_GT(scans.size(), 350U);
    std::size_t skipped = 0;
    for (const auto& [reason, count] : recording->skipped()) skipped += count;
    EXPECT_EQ(scans.size() + skipped, 400U);
    EXPECT_CONTAINS(warningsOf(*recording),
                    "1 compressed chunk is damaged, and all messages in it were skipped");
  }
}

TEST_F(BagFilesTest, ADamagedLargeChunkDoesNotCostMinutes) {
  writeBag(
      [](rosbag::Bag& bag) {
        bag.setChunkThreshold(8000000);
        recordTurns(bag, 3000);
      },
      path_, rosbag::compression::BZ2);
  std::string bad = contentOf(path_);
  for (std::size_t i = 0; i < 8; ++i) bad[bad.size() / 2 + i] ^= '\x55';
  folder_.write("a.bag", bad);
  const auto start = std::chrono::steady_clock::now();
  try {
    readAll(*openRecording(path_));
  } catch (const std::runtime_error& error) {
    EXPECT_CONTAINS(error.what(), "a.bag: ");
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  EXPECT_LT(elapsed.count(), 20.0);  // 3000 decompressions of the chunk would take minutes
}

TEST_F(BagFilesTest, BitFlipsInTheHeadersOfMessagesAreReported) {
  const std::string path = part("a.bag", 0, 50);
  const std::string good = contentOf(path);
  int silent = 0, flips = 0;
  for (std::size_t at = good.find("time="); at != std::string::npos;
       at = good.find("time=", at + 1000)) {
    if (good.compare(at - 4, 4, std::string("\x0d\0\0\0", 4)) != 0) continue;
    std::string bad = good;
    bad[at + 5] ^= '\x10';  // seconds of a record time
    folder_.write("a.bag", bad);
    ++flips;
    try {
      const auto recording = openRecording(path);
      readAll(*recording);
      silent += warningsOf(*recording).find("damaged") == std::string::npos ? 1 : 0;
    } catch (const std::runtime_error&) {
    }
  }
  EXPECT_GT(flips, 20);
  EXPECT_EQ(silent, 0);
}

TEST_F(BagFilesTest, OpeningCanBeStopped) {
  const std::string path = part("a.bag", 0, 50);
  RecordingOptions options;
  int asked = 0;
  options.stop = [&] { return ++asked > 3; };
  EXPECT_CONTAINS(messageOf([&] { openRecording(path, options); }),
                  "stopped while the recording was being opened; nothing was written");
  options.stop = [] { return false; };
  EXPECT_EQ(readAll(*openRecording(path, options)).size(), 50U);
}

}  // namespace
}  // namespace kestrel
