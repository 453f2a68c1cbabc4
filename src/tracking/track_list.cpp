// SPDX-License-Identifier: BSD-3-Clause
#include "track_list.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace kestrel {
namespace {

constexpr double kNotFinite = std::numeric_limits<double>::quiet_NaN();
/// What stood at a place for longer than this is not the object that came there later, s.
constexpr double kEarlier = 1.0;
constexpr double kPathStep = 0.1;  ///< m, between the noted places of an object
constexpr std::size_t kPathPlaces = 50;

}  // namespace

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
  entry.was_found_again = track.unseen_s > kPathGap;
  if (entry.was_found_again) findAgain(entry, object);
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

/// What is found again in something that may be a part of a wall, and has not come into free space,
/// must show once more that it moves.
void TrackList::findAgain(Entry& entry, const ObjectCluster& object) {
  if (object.ends != ObjectEnds::kHidden || object.free_share >= 0.5) return;
  entry.track.moved = false;
  entry.samples.clear();
  entry.path.clear();
}

void TrackList::notePath(Entry& entry, double time) {
  std::deque<Place>& path = entry.path;
  const Eigen::Vector2d& position = entry.track.position;
  if (!path.empty() && (path.back().position - position).norm() < kPathStep) return;
  path.push_back({time, position});
  if (path.size() > kPathPlaces) path.pop_front();
}

/// When the object has come to the place, s; nothing if it was there on its whole path.
std::optional<double> TrackList::arrivalAt(const Entry& entry, const Eigen::Vector2d& place) {
  const double radius = radiusOf(entry);
  const auto outside = std::find_if(entry.path.rbegin(), entry.path.rend(), [&](const Place& past) {
    return (past.position - place).norm() > radius;
  });
  return outside == entry.path.rend() ? std::nullopt : std::optional<double>(outside->time);
}

bool TrackList::mayBe(TargetLabel label, const ObjectCluster& object,
                      const MotionGrid<2>& grid) const {
  const auto entry = std::find_if(entries_.begin(), entries_.end(),
                                  [label](const Entry& e) { return e.label == label; });
  if (entry == entries_.end() || entry->path.empty()) return true;
  const double arrival =
      arrivalAt(*entry, object.observation.value).value_or(entry->path.front().time);
  return cameAfter(arrival - kEarlier, object, grid);
}

std::vector<bool> TrackList::stoodBefore(const std::vector<Eigen::Vector2d>& points,
                                         const std::vector<std::size_t>& numbers,
                                         const MotionGrid<2>& grid) const {
  const auto reaches = [&](const Entry& entry) {
    const double radius = radiusOf(entry);
    return std::any_of(numbers.begin(), numbers.end(), [&](std::size_t i) {
      return (entry.track.position - points[i]).squaredNorm() <= radius * radius;
    });
  };
  if (std::none_of(entries_.begin(), entries_.end(),
                   [&](const Entry& entry) { return !entry.track.moved && reaches(entry); })) {
    return {};
  }
  std::vector<bool> stood(numbers.size());
  for (const Entry& entry : entries_) {
    if (entry.path.empty() || !reaches(entry)) continue;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      stood[k] = stoodBefore(entry, points[numbers[k]], grid);
    }
    const auto count = std::count(stood.begin(), stood.end(), true);
    if (count > 0 && count < static_cast<std::ptrdiff_t>(stood.size())) return stood;
  }
  return {};
}

/// Is there a track that has not moved, and was something there before the object came? A foot of a
/// person who walks stands, too, but not for so long.
bool TrackList::stoodBefore(const Entry& entry, const Eigen::Vector2d& point,
                            const MotionGrid<2>& grid) const {
  const Entry* other = at(point);
  if (other == nullptr || other->track.moved) return false;
  const std::optional<double> arrival = arrivalAt(entry, point);
  if (!arrival) return false;
  const double since = std::min(*arrival, grid.time() - kEarlier);
  return !grid.cameAfter(grid.indexOf(point.cast<float>()), since);
}

void TrackList::miss(Entry& entry, const PhdFilter<5, 2>& filter, const Visibility& visibility) {
  Track& track = entry.track;
  track.unseen_s += seconds_;
  entry.was_found_again = false;
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
    if (!entry.track.isShown()) return false;
    const Eigen::Vector2d center = entry.track.position + seconds * entry.track.velocity;
    const double radius = radiusOf(entry);
    return (center - point).squaredNorm() < radius * radius;
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

bool TrackList::wasFoundAgain(TargetLabel label) const {
  return std::any_of(entries_.begin(), entries_.end(), [label](const Entry& entry) {
    return entry.label == label && entry.track.moved && entry.was_found_again;
  });
}

const TrackList::Entry* TrackList::at(const Eigen::Vector2d& point) const {
  const Entry* nearest = nullptr;
  double best = std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    const double distance2 = (entry.track.position - point).squaredNorm();
    const double radius = radiusOf(entry);
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
