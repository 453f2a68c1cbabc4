// SPDX-License-Identifier: BSD-3-Clause
// The parts of TrackList that decide whether an object moves.

#include <algorithm>
#include <cmath>
#include <utility>

#include "track_list.h"

namespace kestrel {
namespace {

/// A place is left if it gave no return for this time, s, and for this share of the time since the
/// object was seen there: thin objects are not hit by every scan.
constexpr double kLeftTime = 0.2, kLeftShare = 0.4;
constexpr double kPathTime = 2.0;  ///< s, of the path that shows whether an object moves
constexpr std::size_t kPathPoints = 3;
/// Of a foot between two scans, m, and the error of the velocity of a new track, m/s.
constexpr double kStep = 0.6, kFast = 1.5;
/// A surface that is at least as long as a person is wide, and not deeper than this share of its
/// length, is flat.
constexpr double kFlat = 0.2;
constexpr double kInFree = 0.8;  ///< the other returns are at the borders of the free cells

std::vector<GridIndex<2>> cellsOf(const ObjectCluster& object, const MotionGrid<2>& grid) {
  std::vector<GridIndex<2>> cells;
  cells.reserve(object.points.size());
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

/// Sum of the squared residuals if it stood and was then at another place: the track has changed
/// from one thing that stands to another. `origin`: near the path.
double TrackList::stepResidual(const std::deque<Sample>& samples, const Eigen::Vector2d& origin) {
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
    explained =
        std::max(explained, before.squaredNorm() / static_cast<double>(i) +
                                after.squaredNorm() / static_cast<double>(samples.size() - i));
  }
  return squares - explained;
}

double TrackList::speedSignificance(const std::deque<Sample>& samples) {
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

}  // namespace kestrel
