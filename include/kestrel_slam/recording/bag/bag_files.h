// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "kestrel_slam/recording/bag/bag_structure.h"
#include "kestrel_slam/recording/bag/bag_topics.h"

namespace kestrel {

/// The bags of one recording: one file, or all files of a recording that was split. A bag may be
/// compressed as a whole (.gz, .bz2, .xz). It is then decompressed into a temporary file.
class BagFiles {
 public:
  /// Throws std::runtime_error with the name of the file if a bag is damaged, has no index or has
  /// no messages, or if `stop` returns true.
  explicit BagFiles(const std::vector<std::string>& paths, StopRequest stop = {});
  ~BagFiles();

  BagTopics topics() const;
  double begin() const;  ///< record time of the first message, s
  double end() const;    ///< and of the last one

  /// Calls `visit` for every message on the topics, in the order of their record times. Returns the
  /// number of messages that could not be read, or for which `visit` threw an exception.
  using Visit = std::function<void(const rosbag::MessageInstance&)>;
  std::size_t forEach(const std::vector<std::string>& topics, const Visit& visit) const;
  std::size_t forEach(const std::string& topic, const Visit& visit) const;

  /// From now on, `stop` is not asked any more.
  void finishOpening();

  /// Long gaps between the files.
  std::vector<std::string> gapWarnings() const;
  /// The damage that was found so far.
  std::vector<std::string> damageWarnings() const;

 private:
  friend class BagMessages;
  struct File;

  void requireNotStopped() const;
  bool isLost(const rosbag::MessageInstance& message) const;
  void noteFailure(const rosbag::MessageInstance& message) const;

  std::vector<std::unique_ptr<File>> files_;
  StopRequest stop_;
  // Messages in chunks that could not be decompressed. Without them every message of such a chunk
  // would cost a decompression of the chunk.
  mutable std::optional<std::vector<std::set<BagMessageKey>>> chunks_;
  mutable std::set<BagMessageKey> lost_keys_;
  mutable std::size_t lost_chunks_ = 0;
};

/// Reads the messages on some topics one by one, in the order of their record times.
class BagMessages {
 public:
  BagMessages(const BagFiles& files, const std::vector<std::string>& topics);

  /// The next message that is not in a damaged chunk; nullptr at the end. It is valid until the
  /// next call.
  const rosbag::MessageInstance* next();
  /// Call this if the message that next() returned could not be read.
  void noteFailure();

  std::size_t size() const { return size_; }
  std::size_t lost() const { return lost_; }  ///< messages in damaged chunks so far

 private:
  const BagFiles& files_;
  std::unique_ptr<rosbag::View> view_;
  std::size_t size_ = 0, lost_ = 0;
  rosbag::View::iterator position_;
  std::optional<rosbag::MessageInstance> current_;
};

}  // namespace kestrel
