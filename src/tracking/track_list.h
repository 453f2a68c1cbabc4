// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <deque>
#include <optional>
#include <vector>

#include "kestrel_slam/tracking/phd_filter.h"
#include "kestrel_slam/tracking/tracker.h"
#include "object_clusters.h"
#include "visibility.h"

namespace kestrel {

constexpr double kPersonWidth = 0.4;  ///< m
constexpr double kMargin = 0.25;      ///< m; points farther from an object belong to something else
/// After a longer gap without observations (s), the path starts anew: what is seen then may be
/// something else that stands.
constexpr double kPathGap = 0.5;

/// The tracks that belong to the labels of the PHD filter.
class TrackList {
 public:
  explicit TrackList(const TrackerConfig& config) : config_(config) {}

  /// Moves all tracks on with their velocities.
  void predict(double seconds);
  /// Takes over the targets of the last update, and makes the filter forget deleted tracks.
  void update(PhdFilter<5, 2>& filter, const std::vector<ObjectCluster>& objects,
              const Visibility& visibility, const MotionGrid<2>& grid);

  /// All tracks by rising id.
  std::vector<Track> tracks() const;

  /// True if the point belongs to the predicted place of a track.
  bool covers(const Eigen::Vector2d& point) const;
  /// Velocity of what moves at the point; NaN if nothing does.
  Eigen::Vector2d velocityAt(const Eigen::Vector2d& point) const;
  /// Width of the track at the point; that of a person if there is none, m.
  double widthAt(const Eigen::Vector2d& point) const;

  /// True if a shown object is at the point after this time, s.
  bool showsAt(const Eigen::Vector2d& point, double seconds) const;
  bool showsAny() const;
  /// True if the object of this label has moved.
  bool hasMoved(TargetLabel label) const;
  /// True if the object of this label was observed in the last scan, after a gap.
  bool wasFoundAgain(TargetLabel label) const;

  /// False if the object stood at its place before this target came there: it is something else.
  bool mayBe(TargetLabel label, const ObjectCluster& object, const MotionGrid<2>& grid) const;

  /// Of each of the points with these numbers, which are a cluster: did something stand there
  /// before an object came that makes up the rest of the cluster? Empty: nowhere.
  std::vector<bool> stoodBefore(const std::vector<Eigen::Vector2d>& points,
                                const std::vector<std::size_t>& numbers,
                                const MotionGrid<2>& grid) const;

  /// An observed place and the cells that the object filled.
  struct Sample {
    double time;  ///< of the grid, s
    Eigen::Vector2d position;
    double variance;  ///< of the position, m²
    std::vector<GridIndex<2>> cells;
    double free_share;  ///< see ObjectCluster
    double length;      ///< of its box, m
  };
  /// Velocity of the straight path with the least squares, in its sigmas; 0 if a step explains the
  /// positions better.
  static double speedSignificance(const std::deque<Sample>& samples);

  long nextId() const { return next_id_; }
  void continueFrom(long id) { next_id_ = id; }

 private:
  struct Place {
    double time;  ///< of the grid, s
    Eigen::Vector2d position;
  };
  struct Entry {
    Track track;
    TargetLabel label = 0;
    std::deque<Sample> samples;  ///< last places; until it has moved
    std::deque<Place> path;      ///< since it has moved
    double length = 0.0;         ///< largest length that was seen, m
    double seen_s = 0.0;         ///< time with observations
    double hidden_s = 0.0;
    bool was_found_again = false;  ///< in the last scan
  };

  const Entry* at(const Eigen::Vector2d& point) const;
  /// What is farther from the middle than this belongs to something else, m.
  static double radiusOf(const Entry& entry) {
    return 0.5 * std::max(entry.length, kPersonWidth) + kMargin;
  }
  bool stoodBefore(const Entry& entry, const Eigen::Vector2d& point,
                   const MotionGrid<2>& grid) const;
  static void findAgain(Entry& entry, const ObjectCluster& object);
  void see(Entry& entry, const LabeledTarget<5>& target, const ObjectCluster& object,
           const Visibility& visibility, const MotionGrid<2>& grid);
  static double stepResidual(const std::deque<Sample>& samples, const Eigen::Vector2d& origin);
  static std::optional<double> arrivalAt(const Entry& entry, const Eigen::Vector2d& place);
  static void notePath(Entry& entry, double time);
  void noteMove(Entry& entry, const ObjectCluster& object, const Visibility& visibility,
                const MotionGrid<2>& grid) const;
  bool hasJumped(const Entry& entry, const ObjectCluster& object) const;
  static double distanceMoved(const Eigen::Vector2d& way, const ObjectCluster& object);
  bool hasLeft(const Entry& entry, const ObjectCluster& object, const Visibility& visibility,
               const MotionGrid<2>& grid) const;
  static bool cameThroughFree(const std::deque<Sample>& samples, const ObjectCluster& object,
                              double length, double needed);
  static bool isEmptyNow(const Sample& place, const ObjectCluster& object, double length,
                         const Visibility& visibility, const MotionGrid<2>& grid);
  static bool cameAfter(double time, const ObjectCluster& object, const MotionGrid<2>& grid);
  void miss(Entry& entry, const PhdFilter<5, 2>& filter, const Visibility& visibility);
  static void setState(const Eigen::Matrix<double, 5, 1>& mean,
                       const Eigen::Matrix<double, 5, 5>& covariance, Track& track);
  bool isOver(const Entry& entry) const;

  TrackerConfig config_;
  std::vector<Entry> entries_;
  double seconds_ = 0.0;  ///< of the last prediction
  long next_id_ = 1;
};

}  // namespace kestrel
