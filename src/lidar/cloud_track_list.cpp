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
constexpr double kProvenWay = 2.0;  ///< m; a false track on a surface does not get so far
/// s; what has moved by less than that and stood as long may be a surface that came into view
constexpr double kStanding = 1.0;
constexpr double kBoxMargin = 0.3;  ///< m; how far points may lie outside of the predicted box
/// A place is left if it gave no return for this time, s.
constexpr double kLeftTime = 0.15;
constexpr double kGap = 0.25;         ///< s; what is found again after this may be something else
constexpr double kInside = 0.15;      ///< s; a prediction may be inside of another object by chance
constexpr double kHiddenShare = 0.3;  ///< an object is hidden if less of it is visible
constexpr double kKnownSpeed = 1.5;   ///< m/s; from here on, an object points where it goes
/// What was seen of the size fades in each sweep: a label may go over from one object to another.
constexpr double kFade = 0.93;
constexpr double kLongest = 12.0;  ///< m; two vehicles that were one cluster are longer
constexpr double kWidest = 2.8;    ///< m

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

/// The box of a track goes with it; that of the last sweep is where it was then.
bool isInBox(const Track& track, const Eigen::Vector2d& point, double margin) {
  OrientedBox box = track.box;
  box.center = track.position;
  return box.contains(point, margin);
}

/// Of the position, m.
double sigmaOf(const Track& track) {
  return std::sqrt(track.covariance.topLeftCorner<2, 2>().trace() / 2.0);
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
  for (Entry& entry : entries_) entry.inside_s = isInOther(entry) ? entry.inside_s + seconds_ : 0.0;
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
  startAt(entry, object, voxels, grid);
  entries_.push_back(std::move(entry));
  return entries_.back();
}

/// From here on, it has to show that it moves.
void CloudTrackList::startAt(Entry& entry, const CloudObject& object,
                             const std::vector<MovingVoxel>& voxels, const MotionGrid<3>& grid) {
  entry.first = object.box.center;
  entry.first_time = grid.time();
  entry.standing_s = 0.0;
  entry.first_points.clear();
  for (const std::size_t v : object.voxels) {
    entry.first_points.push_back(voxels[v].centroid.cast<float>());
  }
  entry.way = 0.0;
}

void CloudTrackList::see(Entry& entry, const LabeledTarget<7>& target, const CloudObject& object,
                         const std::vector<MovingVoxel>& voxels, const MotionGrid<3>& grid) const {
  Track& track = entry.track.plane;
  const bool is_found_again = track.unseen_s > kGap;
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
  entry.way = std::max(entry.way, (track.position - entry.first).norm());
  if (track.standing > 0.5) entry.standing_s += seconds_;
  const bool is_surface = track.moved && entry.standing_s >= kStanding &&
                          (track.position - entry.moved_at).norm() < kProvenWay;
  const bool is_other = is_found_again && !(track.moved && isWhereItWasFree(object, voxels));
  if (is_surface || is_other) {
    track.moved = false;
    startAt(entry, object, voxels, grid);
  }
  if (!track.moved && hasMoved(entry, object, voxels, grid)) {
    track.moved = true;
    entry.moved_at = track.position;
    entry.standing_s = 0.0;
  }
}

/// The extents along and across the motion; while its direction is not known, only the size.
void CloudTrackList::learnShape(Entry& entry, const CloudObject& object) const {
  if (object.refutes_shape) entry.length = entry.width = 0.0;
  const bool has_direction = entry.track.plane.velocity.norm() > kKnownSpeed;
  if (has_direction) {
    entry.length = std::max(kFade * entry.length, std::min(object.length, kLongest));
    entry.width = std::max(kFade * entry.width, std::min(object.width, kWidest));
  }
  entry.track.plane.size = sizeClassOf(
      std::max({entry.length, entry.width, std::min(object.length, kLongest), object.width}));
}

/// Most of the places where it is now were known as free. So it is not what came into view there.
bool CloudTrackList::isWhereItWasFree(const CloudObject& object,
                                      const std::vector<MovingVoxel>& voxels) {
  const auto was_free = std::count_if(object.voxels.begin(), object.voxels.end(),
                                      [&](std::size_t v) { return voxels[v].was_free; });
  return 2 * static_cast<std::size_t>(was_free) > object.voxels.size();
}

/// It is elsewhere, a part of the place where it was first seen gives no returns any more, and the
/// place where it is now was known as free. So surfaces that come into view do not move. Beams must
/// have passed at its height: now at the old place, or before at the new one, which may have been
/// hidden behind the object itself.
bool CloudTrackList::hasMoved(const Entry& entry, const CloudObject& object,
                              const std::vector<MovingVoxel>& voxels,
                              const MotionGrid<3>& grid) const {
  if ((object.box.center - entry.first).norm() < config_.moved_m) return false;
  if (!isWhereItWasFree(object, voxels)) return false;
  const auto cells = cellsOf(object, voxels, grid);
  const double left_before = grid.time() - kLeftTime;
  std::size_t left = 0, passed = 0, arrived = 0, has_come = 0;
  for (const Eigen::Vector3f& point : entry.first_points) {
    const GridIndex<3> cell = grid.indexOf(point);
    const bool is_now = std::find(cells.begin(), cells.end(), cell) != cells.end();
    if (is_now || grid.lastReturn(cell) >= left_before) continue;
    ++left;
    if (grid.wasPassedAt(point)) ++passed;
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const MovingVoxel& voxel = voxels[object.voxels[i]];
    if (grid.cameAfter(cells[i], entry.first_time)) ++arrived;
    if (voxel.has_come) ++has_come;
  }
  const bool is_shown_by_beams =
      2 * has_come > cells.size() || 2 * passed > entry.first_points.size();
  return left > 0 && 2 * arrived > cells.size() && is_shown_by_beams;
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

/// Two bodies are not at one place: what is only predicted where another one is seen is a second
/// track of that.
bool CloudTrackList::isInOther(const Entry& entry) const {
  if (entry.observation >= 0) return false;
  return std::any_of(entries_.begin(), entries_.end(), [&](const Entry& other) {
    return other.observation >= 0 && other.track.plane.moved &&
           isInBox(other.track.plane, entry.track.plane.position, 0.0);
  });
}

bool CloudTrackList::isOver(const Entry& entry) const {
  if (entry.inside_s > kInside) return true;
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

/// `whole`: also in the part of the box behind the visible sides. The middle of a vehicle of which
/// only the rear is seen is far ahead of all points. But what lies in the part that is not seen,
/// and stands, must not be taken for the object.
const CloudTrackList::Entry* CloudTrackList::nearestAt(const Eigen::Vector2d& point,
                                                       bool whole) const {
  const Entry* nearest = nullptr;
  double best = std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    const double distance = (entry.track.plane.position - point).norm();
    const double reach = 0.5 * std::max({entry.length, entry.width, kPersonWidth}) + kMargin;
    const double margin = kMargin + sigmaOf(entry.track.plane);
    if (distance >= best ||
        (distance > reach && !(whole && isInBox(entry.track.plane, point, margin)))) {
      continue;
    }
    best = distance;
    nearest = &entry;
  }
  return nearest;
}

bool CloudTrackList::claims(const Eigen::Vector3d& point, const MotionGrid<3>& grid) const {
  const Entry* entry = at(point.head<2>());
  if (entry == nullptr || !entry->track.plane.moved || entry->way < kProvenWay) return false;
  return isInBox(entry->track.plane, point.head<2>(), kBoxMargin) &&
         point.z() <= entry->track.top + kBoxMargin &&
         grid.cameAfter(grid.indexOf(point.cast<float>()), entry->first_time);
}

Eigen::Vector3d CloudTrackList::velocityAt(const Eigen::Vector3d& point) const {
  const Entry* entry = at(point.head<2>());
  if (entry == nullptr) return Eigen::Vector3d::Zero();
  const Eigen::Vector2d& velocity = entry->track.plane.velocity;
  return {velocity.x(), velocity.y(), 0.0};
}

std::optional<KnownShape> CloudTrackList::shapeAt(const Eigen::Vector2d& point) const {
  const Entry* entry = nearestAt(point, true);
  if (entry == nullptr || entry->track.plane.state == TrackState::kTentative) return std::nullopt;
  const Track& track = entry->track.plane;
  KnownShape shape;
  shape.track = track.moved ? track.id : 0;
  shape.center = track.position;
  shape.reach = 0.5 * std::max({entry->length, entry->width, track.box.size.maxCoeff()});
  shape.length = entry->length;
  shape.width = entry->width;
  if (track.velocity.norm() > kKnownSpeed) {
    shape.yaw = std::atan2(track.velocity.y(), track.velocity.x());
  } else if (entry->length > 0.0) {
    shape.yaw = track.box.yaw;
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
