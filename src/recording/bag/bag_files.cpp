// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "unpacked_bag.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

/// Longer pauses are unusual between two files of one recording, s.
constexpr double kLongGap = 60.0;

std::string adviceFor(const std::string& path, bool any_chunk) {
  if (any_chunk) {
    return "; `rosbag reindex " + path +
           "` may repair it. If it was already reindexed, copy or record it again";
  }
  return "; it is damaged before the end of its first part, so that `rosbag reindex` cannot save "
         "any message: copy or record it again";
}

BagMessageKey keyOf(const rosbag::MessageInstance& message) {
  return {message.getTopic(), message.getTime().toNSec()};
}

}  // namespace

struct BagFiles::File {
  explicit File(const std::string& name, const StopRequest& stop)
      : path(name), content(name, stop) {
    try {
      contradictions = checkBagStructure(content.path());
      bag.open(content.path(), rosbag::bagmode::Read);
    } catch (const rosbag::BagUnindexedException&) {
      throw std::runtime_error(path + ": the bag has no index (its recording was cut off)" +
                               adviceFor(path, hasWholeChunk(content.path())));
    } catch (const BagDamage& damage) {
      throw std::runtime_error(path + ": is not a valid bag: " + damage.what() +
                               adviceFor(path, damage.anyChunk()));
    } catch (const std::exception& error) {
      throw std::runtime_error(path + ": is not a valid bag: " + error.what() +
                               adviceFor(path, true));
    }
  }

  std::string path;
  UnpackedBag content;
  rosbag::Bag bag;
  std::size_t contradictions = 0;  ///< between records
  double begin = 0.0, end = 0.0;   ///< record times, s
};

BagFiles::BagFiles(const std::vector<std::string>& paths, StopRequest stop)
    : stop_(std::move(stop)) {
  std::set<fs::path> names;
  std::size_t messages = 0;
  for (const std::string& path : paths) {
    requireNotStopped();
    if (!names.insert(fs::weakly_canonical(path)).second) {
      throw std::runtime_error(path + ": the bag is given twice");
    }
    files_.push_back(std::make_unique<File>(path, stop_));
    rosbag::View all(files_.back()->bag);
    messages += all.size();
    if (all.size() == 0) continue;
    files_.back()->begin = all.getBeginTime().toSec();
    files_.back()->end = all.getEndTime().toSec();
  }
  if (messages == 0) throw std::runtime_error(paths.front() + ": the bag has no messages");
}

BagFiles::~BagFiles() = default;

void BagFiles::finishOpening() { stop_ = {}; }

void BagFiles::requireNotStopped() const {
  if (stop_ && stop_()) {
    throw std::runtime_error("stopped while the recording was being opened; nothing was written");
  }
}

double BagFiles::begin() const {
  double begin = std::numeric_limits<double>::infinity();
  for (const auto& file : files_) begin = std::min(begin, file->begin);
  return begin;
}

double BagFiles::end() const {
  double end = 0.0;
  for (const auto& file : files_) end = std::max(end, file->end);
  return end;
}

BagTopics BagFiles::topics() const {
  BagTopics topics;
  for (const auto& file : files_) {
    rosbag::View all(file->bag);
    for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
      BagTopic& topic = topics[connection->topic];
      topic.type = connection->datatype;
      topic.md5 = connection->md5sum;
    }
  }
  for (auto& [name, topic] : topics) {
    for (const auto& file : files_) {
      topic.messages += rosbag::View(file->bag, rosbag::TopicQuery(name)).size();
    }
  }
  return topics;
}

std::size_t BagFiles::forEach(const std::string& topic, const Visit& visit) const {
  return forEach(std::vector<std::string>{topic}, visit);
}

std::size_t BagFiles::forEach(const std::vector<std::string>& topics, const Visit& visit) const {
  std::size_t broken = 0;
  BagMessages messages(*this, topics);
  while (const rosbag::MessageInstance* message = messages.next()) {
    try {
      visit(*message);
    } catch (const std::exception&) {
      messages.noteFailure();
      ++broken;
    }
  }
  return broken;
}

bool BagFiles::isLost(const rosbag::MessageInstance& message) const {
  return !lost_keys_.empty() && lost_keys_.count(keyOf(message)) > 0;
}

void BagFiles::noteFailure(const rosbag::MessageInstance& message) const {
  try {
    message.size();
    return;  // its chunk can be read: only this message is damaged
  } catch (const std::exception&) {
  }
  if (!chunks_) {
    chunks_.emplace();
    for (const auto& file : files_) {
      for (auto& chunk : compressedChunks(file->content.path()))
        chunks_->push_back(std::move(chunk));
    }
  }
  const BagMessageKey key = keyOf(message);
  for (const std::set<BagMessageKey>& chunk : *chunks_) {
    if (chunk.count(key) == 0) continue;
    lost_keys_.insert(chunk.begin(), chunk.end());
    ++lost_chunks_;
  }
}

std::vector<std::string> BagFiles::gapWarnings() const {
  std::vector<const File*> sorted;
  for (const auto& file : files_) sorted.push_back(file.get());
  std::sort(sorted.begin(), sorted.end(),
            [](const File* a, const File* b) { return a->begin < b->begin; });
  std::vector<std::string> warnings;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double gap = sorted[i]->begin - sorted[i - 1]->end;
    if (gap <= kLongGap) continue;
    std::ostringstream text;
    text << sorted[i]->path << " begins " << std::lround(gap) << " s after the end of "
         << sorted[i - 1]->path << ": are they parts of one recording?";
    warnings.push_back(text.str());
  }
  return warnings;
}

std::vector<std::string> BagFiles::damageWarnings() const {
  constexpr const char* kAdvice = "; copy or record the bag again";
  std::vector<std::string> warnings;
  for (const auto& file : files_) {
    if (file->contradictions == 0) continue;
    warnings.push_back(file->path + " is damaged: " + std::to_string(file->contradictions) +
                       " of its records contradict its index, so the result may be wrong" +
                       kAdvice);
  }
  if (lost_chunks_ > 0) {
    warnings.push_back(std::to_string(lost_chunks_) + " compressed chunk" +
                       (lost_chunks_ == 1 ? " is" : "s are") +
                       " damaged, and all messages in it were skipped" + kAdvice);
  }
  return warnings;
}

BagMessages::BagMessages(const BagFiles& files, const std::vector<std::string>& topics)
    : files_(files), view_(std::make_unique<rosbag::View>()) {
  for (const auto& file : files.files_) view_->addQuery(file->bag, rosbag::TopicQuery(topics));
  size_ = view_->size();
  position_ = view_->begin();
}

const rosbag::MessageInstance* BagMessages::next() {
  while (true) {
    files_.requireNotStopped();
    if (current_) ++position_;
    current_.reset();
    if (position_ == view_->end()) return nullptr;
    current_.emplace(*position_);
    if (!files_.isLost(*current_)) return &*current_;
    ++lost_;
  }
}

void BagMessages::noteFailure() { files_.noteFailure(*current_); }

}  // namespace kestrel
