// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/track_evaluation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

namespace kestrel {
namespace {

constexpr double kStampTolerance = 1e-5;  ///< s, between two files
constexpr double kSpeedTime = 0.25;       ///< s before and after, for the true velocity

struct PlacedObject {
  double stamp;
  Eigen::Vector2d position;  ///< in map, m
  bool visible;
};
using Path = std::vector<PlacedObject>;

/// Beyond its ends: the pose at the end.
Pose2 extendedPoseAt(const Trajectory& trajectory, double stamp) {
  const auto next = std::lower_bound(trajectory.begin(), trajectory.end(), stamp,
                                     [](const StampedPose& a, double s) { return a.stamp < s; });
  if (next == trajectory.begin()) return trajectory.front().pose;
  if (next == trajectory.end()) return trajectory.back().pose;
  const auto last = std::prev(next);
  const double share = (stamp - last->stamp) / (next->stamp - last->stamp);
  return interpolate(last->pose, next->pose, share);
}

class Evaluator {
 public:
  Evaluator(const Trajectory& trajectory, const std::vector<TrackRow>& tracks,
            const std::vector<TrueObject>& truth, const TrackEvaluationOptions& options)
      : trajectory_(trajectory),
        tracks_(tracks),
        options_(options),
        all_(options.max_distance_m),
        moving_(options.max_distance_m) {
    for (const TrueObject& object : truth) {
      const Pose2 map_T_sensor = poseOf(object.stamp) * options_.base_T_sensor;
      paths_[object.id].push_back({object.stamp, map_T_sensor * object.position, object.visible});
    }
    first_ = truth.front().stamp - options_.stamp_tolerance_s;
    last_ = truth.back().stamp + options_.stamp_tolerance_s;
  }

  TrackEvaluation run() {
    std::size_t scans = 0;
    for (const StampedPose& scan : trajectory_) {
      if (scan.stamp < first_ || scan.stamp > last_) continue;
      add(scan.stamp);
      ++scans;
    }
    if (scans == 0) throw std::runtime_error("no scan has a true position at its time");
    finish(static_cast<double>(scans));
    return result_;
  }

 private:
  /// Pose of the scan that the true position belongs to: with annotated scans its own, without
  /// interpolation.
  Pose2 poseOf(double stamp) const {
    if (options_.max_gap_s > 0.0) return extendedPoseAt(trajectory_, stamp);
    const auto nearest = std::min_element(
        trajectory_.begin(), trajectory_.end(), [stamp](const auto& a, const auto& b) {
          return std::abs(a.stamp - stamp) < std::abs(b.stamp - stamp);
        });
    return nearest->pose;
  }

  /// Position at the stamp between two true positions that are at most `max_gap` (s) apart.
  static std::optional<Eigen::Vector2d> positionBetween(const Path& path, double stamp,
                                                        double max_gap) {
    const auto next = firstAfter(path, stamp);
    if (next == path.begin() || next == path.end()) return std::nullopt;
    const auto last = std::prev(next);
    if (next->stamp - last->stamp > max_gap) return std::nullopt;
    const double share = (stamp - last->stamp) / (next->stamp - last->stamp);
    return last->position + share * (next->position - last->position);
  }

  static Path::const_iterator firstAfter(const Path& path, double stamp) {
    return std::lower_bound(path.begin(), path.end(), stamp,
                            [](const PlacedObject& a, double s) { return a.stamp < s; });
  }

  std::optional<Eigen::Vector2d> positionAt(const Path& path, double stamp) const {
    if (const auto between = positionBetween(path, stamp, options_.max_gap_s)) return between;
    const auto next = firstAfter(path, stamp);
    if (next != path.end() && next->stamp - stamp <= options_.stamp_tolerance_s) {
      return next->position;
    }
    if (next != path.begin() && stamp - std::prev(next)->stamp <= options_.stamp_tolerance_s) {
      return std::prev(next)->position;
    }
    return std::nullopt;
  }

  /// Visible at the mark nearest to this time?
  static bool isVisible(const Path& path, double stamp) {
    const auto next = firstAfter(path, stamp);
    if (next == path.end()) return path.back().visible;
    if (next == path.begin()) return next->visible;
    const auto last = std::prev(next);
    return (stamp - last->stamp < next->stamp - stamp ? last : next)->visible;
  }

  /// The shown tracks of a scan that lie in the compared part of the view.
  std::vector<const TrackRow*> shownAt(double stamp) const {
    std::vector<const TrackRow*> shown = rowsAt(stamp);
    const Pose2 sensor_T_map = (poseOf(stamp) * options_.base_T_sensor).inverse();
    const auto isLeftOut = [&](const TrackRow* row) {
      const Eigen::Vector2d at = sensor_T_map * row->position;
      const double bearing = std::atan2(at.y(), at.x());
      return !row->shown || bearing < options_.min_bearing || bearing > options_.max_bearing;
    };
    shown.erase(std::remove_if(shown.begin(), shown.end(), isLeftOut), shown.end());
    return shown;
  }

  std::vector<const TrackRow*> rowsAt(double stamp) const {
    std::vector<const TrackRow*> rows;
    const auto first = std::lower_bound(tracks_.begin(), tracks_.end(), stamp - kStampTolerance,
                                        [](const TrackRow& a, double s) { return a.stamp < s; });
    for (auto row = first; row != tracks_.end() && row->stamp < stamp + kStampTolerance; ++row) {
      rows.push_back(&*row);
    }
    return rows;
  }

  bool moves(const Path& path, double stamp, const Eigen::Vector2d& position) const {
    return std::any_of(path.begin(), path.end(), [&](const PlacedObject& at) {
      return at.visible && at.stamp <= stamp && at.stamp >= stamp - options_.moved_within_s &&
             (at.position - position).norm() > options_.moved_m;
    });
  }

  void add(double stamp) {
    TrackedFrame frame;
    const std::vector<const TrackRow*> rows = shownAt(stamp);
    for (const TrackRow* row : rows) {
      frame.tracks.push_back({row->id, {row->position.x(), row->position.y(), 0.0}, true});
    }
    TrackedFrame moving = frame;
    for (const auto& [id, path] : paths_) {
      const auto marked = positionAt(path, stamp);
      const auto position = marked ? marked : positionBetween(path, stamp, options_.unmarked_s);
      if (!position) continue;
      const bool counts = marked && isVisible(path, stamp);
      frame.truth.push_back({id, {position->x(), position->y(), 0.0}, counts});
      moving.truth.push_back(frame.truth.back());
      moving.truth.back().counts = counts && moves(path, stamp, *position);
      if (moving.truth.back().counts) addLoss(stamp, *position);
      if (counts) addSpeed(path, stamp, *position, rows);
    }
    all_.add(frame);
    moving_.add(moving);
    addDistances(frame);
  }

  /// Shown tracks count wherever they are: a track beyond the border of the view is no loss.
  void addLoss(double stamp, const Eigen::Vector2d& position) {
    const TrackRow* nearest = nullptr;
    double best = options_.max_distance_m;
    for (const TrackRow* row : rowsAt(stamp)) {
      const double distance = (row->position - position).norm();
      if (row->shown && distance <= options_.max_distance_m) return;
      if (distance > best) continue;
      best = distance;
      nearest = row;
    }
    LossCounts& losses = result_.losses;
    ++(nearest == nullptr   ? losses.no_track
       : nearest->tentative ? losses.tentative
       : !nearest->moved    ? losses.not_moving
                            : losses.unseen);
  }

  /// Error of the velocity of the nearest track.
  void addSpeed(const Path& path, double stamp, const Eigen::Vector2d& position,
                const std::vector<const TrackRow*>& rows) {
    const auto before = positionAt(path, stamp - kSpeedTime);
    const auto after = positionAt(path, stamp + kSpeedTime);
    const TrackRow* nearest = nullptr;
    double best = options_.max_distance_m;
    for (const TrackRow* row : rows) {
      const double distance = (row->position - position).norm();
      if (distance > best) continue;
      best = distance;
      nearest = row;
    }
    if (nearest == nullptr) return;
    position_squares_ += best * best;
    ++positions_;
    if (!before || !after) return;
    const Eigen::Vector2d velocity = (*after - *before) / (2.0 * kSpeedTime);
    speed_squares_ += (velocity - nearest->velocity).squaredNorm();
    ++result_.speeds;
  }

  void addDistances(const TrackedFrame& frame) {
    const auto points = [](const std::vector<TrackedObject>& objects) {
      PointSet set;
      for (const TrackedObject& object : objects) set.emplace_back(object.position);
      return set;
    };
    const PointSet truth = points(frame.truth), estimate = points(frame.tracks);
    result_.ospa += ospa(truth, estimate, options_.max_distance_m).total;
    result_.gospa += gospa(truth, estimate, options_.max_distance_m).total;
  }

  void finish(double scans) {
    result_.all = all_.result();
    result_.moving = moving_.result();
    result_.ospa /= scans;
    result_.gospa /= scans;
    const auto root = [](double squares, std::size_t count) {
      return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0.0;
    };
    result_.position_rmse = root(position_squares_, positions_);
    result_.speed_rmse = root(speed_squares_, result_.speeds);
    const auto shares = all_.identityShares();
    for (const auto& [id, share] : shares) {
      result_.identity_share += share / static_cast<double>(shares.size());
    }
  }

  const Trajectory& trajectory_;
  const std::vector<TrackRow>& tracks_;
  TrackEvaluationOptions options_;
  std::map<long, Path> paths_;
  double first_ = 0.0, last_ = 0.0;
  ClearMotCounter all_, moving_;
  TrackEvaluation result_;
  double position_squares_ = 0.0, speed_squares_ = 0.0;
  std::size_t positions_ = 0;
};

}  // namespace

TrackEvaluation evaluateTracks(const Trajectory& trajectory, const std::vector<TrackRow>& tracks,
                               const std::vector<TrueObject>& truth,
                               const TrackEvaluationOptions& options) {
  if (trajectory.empty()) throw std::runtime_error("the trajectory is empty");
  if (truth.empty()) throw std::runtime_error("there are no true positions");
  return Evaluator(trajectory, tracks, truth, options).run();
}

}  // namespace kestrel
