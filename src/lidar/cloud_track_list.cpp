// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_track_list.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel {
namespace {

constexpr double kPersonWidth = 0.6, kPersonHeight = 1.6;  ///< m
/// Points farther than this from the box of a track belong to something else, m.
constexpr double kMargin = 0.5;
/// A place is left if it gave no return for this time, s.
constexpr double kLeftTime = 0.15;
constexpr double kHiddenShare = 0.3;  ///< an object is hidden if less of it is visible
constexpr double kKnownSpeed = 1.5;   ///< m/s; from here on, an object points where it goes
constexpr double kLongest = 12.0;     ///< m; two vehicles that were one cluster are longer
constexpr double kWidest = 2.8;       ///< m

void setState(const Eigen::Matrix<double, 7, 1>& mean,
              const Eigen::Matrix<double, 7, 7>& covariance, CloudTrack& track) {
  track.plane.position = mean.head<2>();
  track.plane.velocity = mean.segment<2>(3);
  track.plane.turn_rate = mean(6);
  track.z = mean(2);
  track.climb = mean(5);
  const int kept[] = {0, 1, 3, 4};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) track.plane.covariance(i, j) = covariance(kept[i], kept[j]);
  }
}

std::vector<GridIndex<3>> cellsOf(const CloudObject& object, const std::vector<MovingVoxel>& voxels,
                                  const MotionGrid<3>& grid) {
  std::vector<GridIndex<3>> cells;
  for (const std::size_t v : object.voxels) {
    cells.push_back(grid.indexOf(voxels[v].centroid.cast<float>()));
  }
  return cells;
}

}  // namespace

void CloudTrackList::predict(double seconds) {
  seconds_ = seconds;
  for (Entry& entry : entries_) {
    entry.track.plane.position += seconds * entry.track.plane.velocity;
    entry.track.plane.age_s += seconds;
  }
}

void CloudTrackList::update(PhdFilter<7, 3>& filter, const std::vector<CloudObject>& objects,
                            const std::vector<MovingVoxel>& voxels, const LidarView& view,
                            const MotionGrid<3>& grid) {
  for (Entry& entry : entries_) entry.observation = -1;
  for (const LabeledTarget<7>& target : filter.targets()) {
    if (target.observation < 0) continue;
    const CloudObject& object = objects[static_cast<std::size_t>(target.observation)];
    Entry& entry = entryOf(target, object, voxels, grid);
    entry.observation = target.observation;
    see(entry, target, object, voxels, grid);
  }
  for (Entry& entry : entries_) {
    if (entry.observation < 0) miss(entry, filter, view);
  }
  removeOver(filter);
  track_of_.assign(objects.size(), -1);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const int observation = entries_[i].observation;
    if (observation >= 0) track_of_[static_cast<std::size_t>(observation)] = static_cast<int>(i);
  }
}

CloudTrackList::Entry& CloudTrackList::entryOf(const LabeledTarget<7>& target,
                                               const CloudObject& object,
                                               const std::vector<MovingVoxel>& voxels,
                                               const MotionGrid<3>& grid) {
  const auto known = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& e) { return e.label == target.label; });
  if (known != entries_.end()) return *known;
  Entry entry;
  entry.label = target.label;
  entry.track.plane.id = next_id_++;
  entry.first = object.box.center;
  entry.first_time = grid.time();
  entry.first_cells = cellsOf(object, voxels, grid);
  entries_.push_back(std::move(entry));
  return entries_.back();
}

void CloudTrackList::see(Entry& entry, const LabeledTarget<7>& target, const CloudObject& object,
                         const std::vector<MovingVoxel>& voxels, const MotionGrid<3>& grid) const {
  Track& track = entry.track.plane;
  setState(target.mean, target.covariance, entry.track);
  track.standing = target.modes.size() > 1 ? target.modes[1] : 0.0;
  track.unseen_s = entry.hidden_s = 0.0;
  entry.seen_s += seconds_;
  track.box = object.box;
  entry.track.bottom = object.bottom;
  entry.track.top = object.top;
  learnShape(entry, object);
  if (track.state != TrackState::kTentative || entry.seen_s >= config_.confirm_s) {
    track.state = TrackState::kConfirmed;
  }
  if (!track.moved) track.moved = hasMoved(entry, object, voxels, grid);
}

/// The extents along and across the motion; while its direction is not known, only the size.
void CloudTrackList::learnShape(Entry& entry, const CloudObject& object) const {
  const bool has_direction = entry.track.plane.velocity.norm() > kKnownSpeed;
  if (has_direction) {
    entry.length = std::max(entry.length, std::min(object.length, kLongest));
    entry.width = std::max(entry.width, std::min(object.width, kWidest));
  }
  entry.track.plane.size = sizeClassOf(
      std::max({entry.length, entry.width, std::min(object.length, kLongest), object.width}));
}

/// It is elsewhere, most of the place where it was first seen gives no returns any more, and the
/// place where it is now was empty then. So surfaces that come into view do not move.
bool CloudTrackList::hasMoved(const Entry& entry, const CloudObject& object,
                              const std::vector<MovingVoxel>& voxels,
                              const MotionGrid<3>& grid) const {
  if ((object.box.center - entry.first).norm() < config_.moved_m) return false;
  const auto cells = cellsOf(object, voxels, grid);
  const auto isNow = [&](const GridIndex<3>& cell) {
    return std::find(cells.begin(), cells.end(), cell) != cells.end();
  };
  const double left_before = grid.time() - kLeftTime;
  const auto left = std::count_if(entry.first_cells.begin(), entry.first_cells.end(),
                                  [&](const GridIndex<3>& cell) {
                                    return !isNow(cell) && grid.lastReturn(cell) < left_before;
                                  });
  const auto arrived = std::count_if(cells.begin(), cells.end(), [&](const GridIndex<3>& cell) {
    return grid.cameAfter(cell, entry.first_time);
  });
  return left > 0 && 2 * static_cast<std::size_t>(arrived) > cells.size();
}

void CloudTrackList::miss(Entry& entry, const PhdFilter<7, 3>& filter,
                          const LidarView& view) const {
  Track& track = entry.track.plane;
  track.unseen_s += seconds_;
  const Eigen::Vector3d center(track.position.x(), track.position.y(), entry.track.z);
  const double width = std::max({entry.length, entry.width, kPersonWidth});
  const double height = std::max(entry.track.top - entry.track.bottom, 0.5);
  if (view.visibleShare(center, width, height) < kHiddenShare) entry.hidden_s += seconds_;
  if (track.state != TrackState::kTentative) track.state = TrackState::kCoasting;
  if (const auto component = filter.find(entry.label)) {
    setState(component->mean, component->covariance, entry.track);
    track.box.center = track.position;
  } else {
    track.unseen_s = std::numeric_limits<double>::infinity();
  }
}

bool CloudTrackList::isOver(const Entry& entry) const {
  const double unseen = entry.track.plane.unseen_s;
  return unseen - entry.hidden_s > config_.coast_s || unseen > config_.hidden_s;
}

void CloudTrackList::removeOver(PhdFilter<7, 3>& filter) {
  for (const Entry& entry : entries_) {
    if (isOver(entry)) filter.forget(entry.label);
  }
  entries_.erase(std::remove_if(entries_.begin(), entries_.end(),
                                [this](const Entry& entry) { return isOver(entry); }),
                 entries_.end());
}

std::vector<CloudTrack> CloudTrackList::tracks() const {
  std::vector<CloudTrack> result;
  for (const Entry& entry : entries_) result.push_back(entry.track);
  return result;
}

const CloudTrackList::Entry* CloudTrackList::at(const Eigen::Vector2d& point) const {
  const Entry* nearest = nullptr;
  double best = std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    const double distance = (entry.track.plane.position - point).norm();
    const double reach = 0.5 * std::max({entry.length, entry.width, kPersonWidth}) + kMargin;
    if (distance > reach || distance >= best) continue;
    best = distance;
    nearest = &entry;
  }
  return nearest;
}

Eigen::Vector3d CloudTrackList::velocityAt(const Eigen::Vector3d& point) const {
  const Entry* entry = at(point.head<2>());
  if (entry == nullptr) return Eigen::Vector3d::Zero();
  const Eigen::Vector2d& velocity = entry->track.plane.velocity;
  return {velocity.x(), velocity.y(), 0.0};
}

std::optional<KnownShape> CloudTrackList::shapeAt(const Eigen::Vector2d& point) const {
  const Entry* entry = at(point);
  if (entry == nullptr) return std::nullopt;
  KnownShape shape{entry->length, entry->width, std::nullopt};
  const Eigen::Vector2d& velocity = entry->track.plane.velocity;
  if (velocity.norm() > kKnownSpeed) {
    shape.yaw = std::atan2(velocity.y(), velocity.x());
  } else if (entry->length > 0.0) {
    shape.yaw = entry->track.plane.box.yaw;
  }
  return shape;
}

Eigen::Vector2d CloudTrackList::sizeAt(const Eigen::Vector2d& point) const {
  const Entry* entry = at(point);
  if (entry == nullptr) return {kPersonWidth, kPersonHeight};
  return {std::max({entry->length, entry->width, kPersonWidth}),
          std::max(entry->track.top - entry->track.bottom, 0.5)};
}

}  // namespace kestrel
