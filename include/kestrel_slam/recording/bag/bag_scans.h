// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "kestrel_slam/recording/bag/bag_files.h"
#include "kestrel_slam/recording/bag/bag_scan_messages.h"
#include "kestrel_slam/recording/bag/bag_transforms.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/sensor/cloud_joiner.h"
#include "kestrel_slam/sensor/scan_joiner.h"

namespace kestrel {

/// Reads the scans on one topic. The segments or packets of a turn are joined.
class BagScans {
 public:
  BagScans(const BagFiles& files, const std::string& topic);

  bool next(BagScan& scan);  ///< false at the end

  std::size_t messages() const { return messages_.size(); }
  std::size_t messagesRead() const { return read_; }
  bool joins() const;

  /// Called for messages that are left out, with a reason for statistics, a sentence for the user
  /// (may be "") and their number.
  std::function<void(const std::string& reason, const std::string& warning, std::size_t count)>
      on_skip;

 private:
  /// The joiners of one frame: some drivers send several lasers on one topic.
  struct Frame {
    ScanJoiner scans;
    CloudJoiner clouds;
    std::map<double, BagScan> messages;  ///< the newest ones without their data, by stamp
    std::deque<double> order;            ///< their stamps

    void remember(BagScan message);
  };

  void add(BagScan scan);
  void read(const rosbag::MessageInstance& message);
  void finish();
  template <typename Sweeps>
  void release(Frame& frame, Sweeps sweeps);
  void skip(const std::string& reason, const std::string& warning, std::size_t count = 1);

  std::string topic_;
  BagMessages messages_;
  std::map<std::string, Frame> frames_;
  std::deque<BagScan> ready_;
  std::size_t read_ = 0;
  bool at_end_ = false;
};

/// The topic that is mapped.
struct ScanTopic {
  std::string name;
  bool clouds = false;
  std::string frame;               ///< of the first scan
  double messages_per_scan = 1.0;  ///< above 1 if turns are sent in several messages
  double clock_offset = 0.0;       ///< stamp minus time of recording of the first scan, s
};

/// Selects the topic: the wanted one, or the one whose scanner sees most (field of view, beams and
/// range; for a 2D laser also how level it is mounted). 2D lasers come before 3D lidars. Throws
/// std::runtime_error if there is none.
ScanTopic chooseScanTopic(const BagFiles& files, const BagTopics& topics,
                          const BagTransforms& transforms, const RecordingOptions& options,
                          std::vector<std::string>& warnings);

}  // namespace kestrel
