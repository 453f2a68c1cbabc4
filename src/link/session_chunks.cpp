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

constexpr std::uint32_t kPosesKey = 1;
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

/// The session without its scans.
Session withoutScans(const Session& session) {
  Session result = session;
  for (KeyframePtr& keyframe : result.keyframes) {
    auto empty = std::make_shared<Keyframe>(*keyframe);
    empty->scan = CompactScan();
    keyframe = empty;
  }
  return result;
}

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
  for (std::uint64_t number = 1; number <= journal.last(); ++number) {
    const std::optional<LinkChunk> chunk = journal.get(number);
    if (!chunk || chunk->content.empty()) continue;
    const std::optional<Session> session = decoded(chunk->content);
    if (!session) continue;
    if (chunk->key == kPosesKey) keyframes_then_ = session->keyframes.size();
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
  journal_.append(kPosesKey, encodeSession(withoutScans(session)));
  keyframes_then_ = count;
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
  for (const auto& [first, last] : journal.numbers().ranges()) {
    for (std::uint64_t number = first; number <= last; ++number) {
      const std::optional<LinkChunk> chunk = journal.get(number);
      if (!chunk || chunk->content.empty()) continue;
      std::optional<Session> part = decoded(chunk->content);
      if (!part) {
        if (damaged != nullptr) ++*damaged;
      } else if (chunk->key == kPosesKey) {
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
