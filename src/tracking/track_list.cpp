// SPDX-License-Identifier: BSD-3-Clause
#include "track_list.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace kestrel {
namespace {

constexpr double kPersonWidth = 0.4;  ///< m
/// Points farther than this from the box of a track belong to something else, m.
constexpr double kMargin = 0.25;
/// A place is left if it gave no return for this time, s, and for this share of the time since the
/// object was seen there: thin objects are not hit by every scan.
constexpr double kLeftTime = 0.2, kLeftShare = 0.4;
constexpr double kNotFinite = std::numeric_limits<double>::quiet_NaN();
constexpr double kPathTime = 2.0;  ///< s, of the path that shows whether an object moves
constexpr std::size_t kPathPoints = 3;
/// After a longer gap without observations (s), the path starts anew: what is seen then may be
/// something else that stands.
constexpr double kPathGap = 0.5;
/// What stood at a place for longer than this before an object came there is something else, s.
constexpr double kEarlier = 1.0;
/// Of a foot between two scans, m, and the error of the velocity of a new track, m/s.
constexpr double kStep = 0.6, kFast = 1.5;
constexpr double kPathStep = 0.1;  ///< m, between the noted places of an object
constexpr std::size_t kPathPlaces = 50;
constexpr double kMissed = 1.5;  ///< periods between two observations, from which on one is missing
/// A surface that is at least as long as a person is wide, and not deeper than this share of its
/// length, is flat.
constexpr double kFlat = 0.2;
constexpr double kInFree = 0.8;  ///< the other returns are at the borders of the free cells

std::vector<GridIndex<2>> cellsOf(const ObjectCluster& object, const MotionGrid<2>& grid) {
  std::vector<GridIndex<2>> cells;
  for (const Eigen::Vector2d& point : object.points) {
    const GridIndex<2> cell = grid.indexOf(point.cast<float>());
    if (std::find(cells.rbegin(), cells.rend(), cell) == cells.rend()) cells.push_back(cell);
  }
  return cells;
}

/// A flat surface looks the same after a motion along itself: what has moved may be the part of it
/// that gives returns. `length` (m): the largest that was seen of it.
bool slides(const Eigen::Vector2d& way, const ObjectCluster& object, double length) {
  const double c = std::cos(object.box.yaw), s = std::sin(object.box.yaw);
  const double along = c * way.x() + s * way.y(), across = c * way.y() - s * way.x();
  return length > kPersonWidth && object.box.size.y() < kFlat * length &&
         std::abs(along) > std::abs(across);
}

}  // namespace

/// Sum of the squared residuals if it stood, was missed, and was then at another place: the track
/// has changed from one thing that stands to another. `origin`: near the path.
double TrackList::stepResidual(const std::deque<Sample>& samples,
                               const Eigen::Vector2d& origin) const {
  Eigen::Vector2d before = Eigen::Vector2d::Zero(), after = Eigen::Vector2d::Zero();
  double squares = 0.0;
  for (const Sample& sample : samples) {
    after += sample.position - origin;
    squares += (sample.position - origin).squaredNorm();
  }
  double explained = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    before += samples[i - 1].position - origin;
    after -= samples[i - 1].position - origin;
    if (samples[i].time - samples[i - 1].time < kMissed * seconds_) continue;
    explained =
        std::max(explained, before.squaredNorm() / static_cast<double>(i) +
                                after.squaredNorm() / static_cast<double>(samples.size() - i));
  }
  return squares - explained;
}

/// Velocity of the straight path with the least squares, in its sigmas; 0 if a step explains the
/// positions better.
double TrackList::speedSignificance(const std::deque<Sample>& samples) const {
  const auto count = static_cast<double>(samples.size());
  if (samples.size() < kPathPoints) return 0.0;
  double time = 0.0, time2 = 0.0, residual2 = 0.0, noise = 0.0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), velocity = Eigen::Vector2d::Zero();
  for (const Sample& sample : samples) {
    time += sample.time / count;
    mean += sample.position / count;
    noise += sample.variance / count;
  }
  for (const Sample& sample : samples) {
    time2 += (sample.time - time) * (sample.time - time);
    velocity += (sample.time - time) * (sample.position - mean);
  }
  velocity /= time2;
  for (const Sample& sample : samples) {
    residual2 += (sample.position - mean - (sample.time - time) * velocity).squaredNorm();
  }
  if (stepResidual(samples, mean) <= residual2) return 0.0;
  const double variance = std::max(residual2 / (2.0 * (count - 2.0)), noise);
  return velocity.norm() * std::sqrt(time2 / variance);
}

void TrackList::predict(double seconds) {
  seconds_ = seconds;
  for (Entry& entry : entries_) {
    entry.track.position += seconds * entry.track.velocity;
    entry.track.age_s += seconds;
  }
}

void TrackList::update(PhdFilter<5, 2>& filter, const std::vector<ObjectCluster>& objects,
                       const Visibility& visibility, const MotionGrid<2>& grid) {
  std::vector<bool> seen(entries_.size(), false);
  for (const LabeledTarget<5>& target : filter.targets()) {
    auto entry = std::find_if(entries_.begin(), entries_.end(),
                              [&](const Entry& e) { return e.label == target.label; });
    if (target.observation < 0) continue;
    const ObjectCluster& object = objects[static_cast<std::size_t>(target.observation)];
    if (entry == entries_.end()) {
      Entry created;
      created.label = target.label;
      created.track.id = next_id_++;
      entry = entries_.insert(entries_.end(), created);
      seen.push_back(false);
    }
    seen[static_cast<std::size_t>(entry - entries_.begin())] = true;
    see(*entry, target, object, visibility, grid);
  }
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (!seen[i]) miss(entries_[i], filter, visibility);
  }
  for (const Entry& entry : entries_) {
    if (isOver(entry)) filter.forget(entry.label);
  }
  entries_.erase(std::remove_if(entries_.begin(), entries_.end(),
                                [this](const Entry& entry) { return isOver(entry); }),
                 entries_.end());
}

void TrackList::see(Entry& entry, const LabeledTarget<5>& target, const ObjectCluster& object,
                    const Visibility& visibility, const MotionGrid<2>& grid) {
  Track& track = entry.track;
  if (!track.moved && object.ends != ObjectEnds::kHidden) noteMove(entry, object, visibility, grid);
  setState(target.mean, target.covariance, track);
  track.standing = target.modes.size() > 1 ? target.modes[1] : 0.0;
  track.unseen_s = entry.hidden_s = 0.0;
  entry.seen_s += seconds_;
  track.box = object.box;
  if (track.moved) notePath(entry, grid.time());
  entry.length = std::max(entry.length, object.box.size.x());
  track.size = sizeClassOf(entry.length);
  if (track.state != TrackState::kTentative || entry.seen_s >= config_.confirm_s) {
    track.state = TrackState::kConfirmed;
  }
}

void TrackList::notePath(Entry& entry, double time) {
  std::deque<Place>& path = entry.path;
  const Eigen::Vector2d& position = entry.track.position;
  if (!path.empty() && (path.back().position - position).norm() < kPathStep) return;
  path.push_back({time, position});
  if (path.size() > kPathPlaces) path.pop_front();
}

/// When the object has come to the place, s; the start of its path if it was always there.
double TrackList::arrivalAt(const Entry& entry, const Eigen::Vector2d& place) {
  const double radius = 0.5 * std::max(entry.length, kPersonWidth) + kMargin;
  const auto outside = std::find_if(entry.path.rbegin(), entry.path.rend(), [&](const Place& past) {
    return (past.position - place).norm() > radius;
  });
  return outside == entry.path.rend() ? entry.path.front().time : outside->time;
}

bool TrackList::mayBe(TargetLabel label, const ObjectCluster& object,
                      const MotionGrid<2>& grid) const {
  const auto entry = std::find_if(entries_.begin(), entries_.end(),
                                  [label](const Entry& e) { return e.label == label; });
  if (entry == entries_.end() || entry->path.empty()) return true;
  return cameAfter(arrivalAt(*entry, object.observation.value) - kEarlier, object, grid);
}

/// It is farther from the predicted place than a step of a person: the track has changed to
/// something else.
bool TrackList::hasJumped(const Entry& entry, const ObjectCluster& object) const {
  const double jump = (object.observation.value - entry.track.position).norm();
  const double unseen = entry.track.unseen_s + seconds_;
  return jump > kStep + kFast * unseen + 0.5 * std::max(entry.length, object.box.size.x());
}

/// Does it move? A straight path is fitted to its last positions: the velocity must be significant,
/// measured by how well the path fits. A track that jumps between things that stand has none.
void TrackList::noteMove(Entry& entry, const ObjectCluster& object, const Visibility& visibility,
                         const MotionGrid<2>& grid) const {
  Sample sample{grid.time(),           object.observation.value, object.observation.noise(0, 0),
                cellsOf(object, grid), object.free_share,        object.box.size.x()};
  if (object.ends == ObjectEnds::kUnknown) sample.variance += config_.cut_sigma * config_.cut_sigma;
  std::deque<Sample>& samples = entry.samples;
  const bool has_gap = !samples.empty() && sample.time - samples.back().time > kPathGap;
  if (has_gap || hasJumped(entry, object)) samples.clear();
  samples.push_back(std::move(sample));
  while (grid.time() - samples.front().time > kPathTime) samples.pop_front();
  if (speedSignificance(samples) < config_.motion_significance) return;
  entry.track.moved = hasLeft(entry, object, visibility, grid);
}

/// Between beams without return, the visible part of a wall may move along the wall: only the
/// motion across the longer side of the object counts.
double TrackList::distanceMoved(const Eigen::Vector2d& way, const ObjectCluster& object) {
  if (object.ends == ObjectEnds::kSeen) return way.norm();
  const double yaw = object.box.yaw;
  return std::abs(way.dot(Eigen::Vector2d(-std::sin(yaw), std::cos(yaw))));
}

/// It came through free space. Or it is elsewhere; a place where it was seen is empty now, or it
/// hides it and came from free space; and the place where it is now was empty then. So the visible
/// part of a wall does not move with the sensor, nor do thin objects that are seen by turns.
bool TrackList::hasLeft(const Entry& entry, const ObjectCluster& object,
                        const Visibility& visibility, const MotionGrid<2>& grid) const {
  const double needed = std::max(config_.moved_m, 0.5 * entry.length);
  if (cameThroughFree(entry.samples, object, entry.length, needed)) return true;
  return std::any_of(entry.samples.begin(), entry.samples.end(), [&](const Sample& sample) {
    return distanceMoved(object.observation.value - sample.position, object) >= needed &&
           isEmptyNow(sample, object, entry.length, visibility, grid) &&
           cameAfter(sample.time, object, grid);
  });
}

/// On a way as long as needed, nearly all of its returns were always in cells that had been free.
/// Then its old place need not be empty: there may be the next person of a group. A part of a wall
/// that comes into view has returns in unknown cells, too; what grows moves its middle by half.
bool TrackList::cameThroughFree(const std::deque<Sample>& samples, const ObjectCluster& object,
                                double length, double needed) {
  for (auto sample = samples.rbegin(); sample != samples.rend(); ++sample) {
    if (sample->free_share < kInFree) return false;
    const Eigen::Vector2d way = object.observation.value - sample->position;
    const double grown = 0.5 * std::abs(object.box.size.x() - sample->length);
    if (distanceMoved(way, object) - grown >= needed && !slides(way, object, length)) return true;
  }
  return false;
}

bool TrackList::isEmptyNow(const Sample& place, const ObjectCluster& object, double length,
                           const Visibility& visibility, const MotionGrid<2>& grid) {
  const double since = grid.time() - place.time;
  const double left_before = grid.time() - std::max(kLeftTime, kLeftShare * since);
  const bool by_returns = slides(object.observation.value - place.position, object, length);
  std::size_t passed = 0, hidden = 0;
  for (const GridIndex<2>& cell : place.cells) {
    if (grid.lastReturn(cell) >= left_before) continue;
    const Eigen::Vector2d center = grid.centerOf(cell).cast<double>();
    const bool was_passed = grid.wasPassed(cell);
    const double width = grid.resolution();
    if (was_passed && (by_returns ? visibility.isSeenThroughByReturns(center, width)
                                  : visibility.isSeenThrough(center, width))) {
      ++passed;
    } else if (was_passed || visibility.isHidden(center)) {
      ++hidden;
    }
  }
  if (2 * (passed + hidden) <= place.cells.size()) return false;
  return 2 * passed > place.cells.size() || object.free_share > 0.5;
}

bool TrackList::cameAfter(double time, const ObjectCluster& object, const MotionGrid<2>& grid) {
  const std::vector<GridIndex<2>> cells = cellsOf(object, grid);
  const auto arrived = std::count_if(cells.begin(), cells.end(), [&](const GridIndex<2>& cell) {
    return grid.cameAfter(cell, time);
  });
  return 2 * static_cast<std::size_t>(arrived) > cells.size();
}

void TrackList::miss(Entry& entry, const PhdFilter<5, 2>& filter, const Visibility& visibility) {
  Track& track = entry.track;
  track.unseen_s += seconds_;
  const double width = std::max(entry.length, kPersonWidth);
  if (visibility.visibleShare(track.position, width) < kHiddenShare) entry.hidden_s += seconds_;
  if (track.state != TrackState::kTentative) track.state = TrackState::kCoasting;
  if (const auto component = filter.find(entry.label)) {
    setState(component->mean, component->covariance, track);
  } else {
    track.unseen_s = std::numeric_limits<double>::infinity();
  }
}

void TrackList::setState(const Eigen::Matrix<double, 5, 1>& mean,
                         const Eigen::Matrix<double, 5, 5>& covariance, Track& track) {
  track.position = mean.head<2>();
  track.velocity = mean.segment<2>(2);
  track.turn_rate = mean(4);
  track.covariance = covariance.topLeftCorner<4, 4>();
}

bool TrackList::isOver(const Entry& entry) const {
  return entry.track.unseen_s - entry.hidden_s > config_.coast_s ||
         entry.track.unseen_s > config_.hidden_s;
}

std::vector<Track> TrackList::tracks() const {
  std::vector<Track> result;
  for (const Entry& entry : entries_) result.push_back(entry.track);
  return result;
}

bool TrackList::showsAt(const Eigen::Vector2d& point, double seconds) const {
  return std::any_of(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    const Eigen::Vector2d center = entry.track.position + seconds * entry.track.velocity;
    const double radius = 0.5 * std::max(entry.length, kPersonWidth) + kMargin;
    return entry.track.isShown() && (center - point).squaredNorm() < radius * radius;
  });
}

bool TrackList::showsAny() const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [](const Entry& entry) { return entry.track.isShown(); });
}

bool TrackList::hasMoved(TargetLabel label) const {
  return std::any_of(entries_.begin(), entries_.end(), [label](const Entry& entry) {
    return entry.label == label && entry.track.moved;
  });
}

const TrackList::Entry* TrackList::at(const Eigen::Vector2d& point) const {
  const Entry* nearest = nullptr;
  double best = std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    const double distance2 = (entry.track.position - point).squaredNorm();
    const double radius = 0.5 * std::max(entry.length, kPersonWidth) + kMargin;
    if (distance2 > radius * radius || distance2 >= best) continue;
    best = distance2;
    nearest = &entry;
  }
  return nearest;
}

bool TrackList::covers(const Eigen::Vector2d& point) const { return at(point) != nullptr; }

Eigen::Vector2d TrackList::velocityAt(const Eigen::Vector2d& point) const {
  const Entry* entry = at(point);
  if (entry == nullptr || !entry->track.moved) return Eigen::Vector2d::Constant(kNotFinite);
  return entry->track.velocity;
}

double TrackList::widthAt(const Eigen::Vector2d& point) const {
  const Entry* entry = at(point);
  return entry != nullptr ? std::max(entry->length, kPersonWidth) : kPersonWidth;
}

}  // namespace kestrel
