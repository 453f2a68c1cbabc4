// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/link/session_chunks.h"

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "bytes.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel {
namespace {

/// Key of the poses of a session. Those of a long flight are in several chunks: their keys are
/// larger, and alternate, so that the newest poses that are here as a whole are not replaced by
/// newer ones of which a part is still missing.
constexpr std::uint32_t kPosesKey = 1;
/// part (4 bytes), number of parts (4), content
constexpr std::size_t kPartBytes = 16'384, kPartHeadBytes = 8;
/// Keyframes in one chunk at most.
constexpr std::size_t kTogether = 10;
/// Errors of a motion, added to its covariance.
constexpr double kMotionM = 0.003, kMotionRad = 0.001;

std::optional<Session> decoded(const std::string& content) {
  try {
    return decodeSession(content);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

/// The session without what its keyframes have: that has travelled.
Session withoutScans(const Session& session) {
  Session result = session;
  for (KeyframePtr& keyframe : result.keyframes) {
    auto empty = std::make_shared<Keyframe>();
    empty->id = keyframe->id;
    keyframe = empty;
  }
  return result;
}

std::string partOf(const std::string& content, std::size_t part, std::size_t count) {
  std::string bytes;
  put(bytes, static_cast<std::uint32_t>(part));
  put(bytes, static_cast<std::uint32_t>(count));
  return bytes + content.substr(part * kPartBytes, kPartBytes);
}

/// Puts the poses together that are in several chunks. The chunks come in the order of their
/// numbers.
class PosesOfParts {
 public:
  /// The content, with its last part.
  std::optional<std::string> add(const LinkChunk& chunk) {
    ByteReader reader(chunk.content);
    const auto part = reader.get<std::uint32_t>(), count = reader.get<std::uint32_t>();
    if (part == 0) content_.clear(), next_ = chunk.number, count_ = count;
    if (!reader.ok() || part + 1 > count || count != count_ || chunk.number != next_)
      return std::nullopt;
    content_ += chunk.content.substr(kPartHeadBytes);
    ++next_;
    return part + 1 == count ? std::optional<std::string>(content_) : std::nullopt;
  }

 private:
  std::string content_;
  std::uint64_t next_ = 0;
  std::uint32_t count_ = 0;
};

/// A keyframe with its scan and its pose at the time when it was sent.
struct Sent {
  KeyframePtr keyframe;
  Pose2 pose;
};

/// Puts the scans into the keyframes of the session; those without a scan are left out.
void insertScans(Session& session, std::map<std::uint64_t, Sent>& sent) {
  std::vector<KeyframePtr> whole;
  for (const KeyframePtr& keyframe : session.keyframes) {
    const auto found = sent.find(keyframe->id);
    if (found != sent.end()) whole.push_back(found->second.keyframe);
  }
  session.keyframes = std::move(whole);
  removeDangling(session);
}

std::optional<std::size_t> vertexOf(const Session& session, std::uint64_t keyframe) {
  for (std::size_t i = session.vertices.size(); i-- > 0;) {
    const VertexRecord& vertex = session.vertices[i];
    if (vertex.kind == VertexKind::kKeyframe && vertex.id == keyframe) return i;
  }
  return std::nullopt;
}

/// Appends a keyframe that is newer than the poses of the session.
void appendNewer(Session& session, const Sent& last, const Sent& next) {
  const std::optional<std::size_t> from = vertexOf(session, last.keyframe->id);
  const Pose2 motion = last.pose.between(next.pose);
  const Pose2 pose = from ? session.vertices[*from].vertex.pose * motion : next.pose;
  session.keyframes.push_back(next.keyframe);
  session.vertices.push_back({VertexKind::kKeyframe, next.keyframe->id, {pose, !from}});
  if (!from) return;
  Eigen::Matrix3d covariance = next.keyframe->motion_covariance;
  covariance.diagonal() += Eigen::Vector3d(kMotionM, kMotionM, kMotionRad).cwiseAbs2();
  session.edges.push_back(
      {*from, session.vertices.size() - 1, motion, covariance.inverse(), EdgeKind::kOdometry});
}

}  // namespace

std::uint64_t epochOf(const Session& session) {
  if (session.keyframes.empty()) return 0;
  const Keyframe& first = *session.keyframes.front();
  return checksumOf(first.scan.bytes() + std::to_string(first.stamp)) | 1U;
}

SessionCutter::SessionCutter(ChunkJournal& journal) : journal_(journal) {
  PosesOfParts poses;
  for (std::uint64_t number = 1; number <= journal.last(); ++number) {
    const std::optional<LinkChunk> chunk = journal.get(number);
    if (!chunk || chunk->content.empty()) continue;
    if (chunk->key > kPosesKey) odd_ = (chunk->key - kPosesKey) % 2 == 1;
    const std::optional<std::string> content =
        chunk->key > kPosesKey ? poses.add(*chunk) : chunk->content;
    const std::optional<Session> session = content ? decoded(*content) : std::nullopt;
    if (!session) continue;
    if (chunk->key != 0) keyframes_then_ = session->keyframes.size();
    for (const KeyframePtr& keyframe : session->keyframes) {
      if (chunk->key == 0) sent_.insert(keyframe->id);
    }
  }
}

void SessionCutter::update(const Session& session, bool whole) {
  appendKeyframes(session);
  const std::size_t count = session.keyframes.size();
  const bool grown = count >= keyframes_then_ + std::max<std::size_t>(20, keyframes_then_ / 5);
  if (count == 0 || (!grown && !whole)) return;
  appendPoses(encodeSession(withoutScans(session)));
  keyframes_then_ = count;
}

void SessionCutter::appendPoses(const std::string& poses) {
  const std::size_t parts = (poses.size() + kPartBytes - 1) / kPartBytes;
  if (parts <= 1) {
    journal_.append(kPosesKey, poses);
    return;
  }
  odd_ = !odd_;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t key = kPosesKey + 2 * (part + 1) - (odd_ ? 1 : 0);
    journal_.append(static_cast<std::uint32_t>(key), partOf(poses, part, parts));
  }
}

void SessionCutter::appendKeyframes(const Session& session) {
  const std::vector<Pose2> poses = keyframePoses(session);
  Session part;
  const auto flush = [&] {
    if (!part.keyframes.empty()) journal_.append(0, encodeSession(part));
    part = Session();
  };
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const KeyframePtr& keyframe = session.keyframes[i];
    if (!sent_.insert(keyframe->id).second) continue;
    part.resolution_m = session.resolution_m;
    part.keyframes.push_back(keyframe);
    part.vertices.push_back({VertexKind::kKeyframe, keyframe->id, {poses[i]}});
    if (part.keyframes.size() >= kTogether) flush();
  }
  flush();
}

Session assembledSession(ChunkJournal& journal, std::size_t* damaged) {
  Session session;
  std::map<std::uint64_t, Sent> sent;
  std::vector<std::uint64_t> order;
  PosesOfParts poses_of_parts;
  for (const auto& [first, last] : journal.numbers().ranges()) {
    for (std::uint64_t number = first; number <= last; ++number) {
      const std::optional<LinkChunk> chunk = journal.get(number);
      if (!chunk || chunk->content.empty()) continue;
      const bool is_part = chunk->key > kPosesKey;
      const std::optional<std::string> content =
          is_part ? poses_of_parts.add(*chunk) : chunk->content;
      if (!content) continue;
      std::optional<Session> part = decoded(*content);
      if (!part) {
        if (damaged != nullptr) ++*damaged;
      } else if (chunk->key != 0) {
        session = std::move(*part);
      } else {
        const std::vector<Pose2> poses = keyframePoses(*part);
        for (std::size_t i = 0; i < poses.size(); ++i) {
          order.push_back(part->keyframes[i]->id);
          sent[order.back()] = {part->keyframes[i], poses[i]};
        }
        if (session.keyframes.empty()) session.resolution_m = part->resolution_m;
      }
    }
  }
  std::set<std::uint64_t> placed;
  for (const KeyframePtr& keyframe : session.keyframes) placed.insert(keyframe->id);
  insertScans(session, sent);
  const Sent* last = nullptr;
  for (const std::uint64_t id : order) {
    const Sent& next = sent[id];
    if (placed.count(id) == 0) appendNewer(session, last == nullptr ? next : *last, next);
    last = &next;
  }
  return session;
}

}  // namespace kestrel
