// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <vector>

namespace kestrel {

/// Distance between two sets of points. OSPA [Schuhmacher 2008] divides by the number of points,
/// GOSPA [Rahmathullah 2017] (alpha = 2) does not.
struct SetDistance {
  double total = 0.0;
  double localization = 0.0;  ///< part from the distances of assigned points
  double cardinality = 0.0;   ///< part from points without a partner
  std::size_t missed = 0;     ///< points of the truth without a partner
  std::size_t extra = 0;      ///< estimated points without a partner
};

using PointSet = std::vector<Eigen::VectorXd>;

/// `cutoff` c: largest distance that counts. `order` p. Total, localization and cardinality add up
/// for p = 1.
SetDistance ospa(const PointSet& truth, const PointSet& estimate, double cutoff,
                 double order = 1.0);
SetDistance gospa(const PointSet& truth, const PointSet& estimate, double cutoff,
                  double order = 2.0);

/// One object in one frame.
struct TrackedObject {
  long id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m
  /// Of a true object: false if it need not be found. A track on it is neither right nor wrong.
  bool counts = true;
};

/// All objects at one time.
struct TrackedFrame {
  std::vector<TrackedObject> truth, tracks;
};

/// CLEAR-MOT [Bernardin 2008].
struct ClearMot {
  std::size_t frames = 0;
  std::size_t truths = 0;  ///< true objects, summed over the frames
  std::size_t matches = 0;
  std::size_t misses = 0;
  std::size_t false_tracks = 0;
  std::size_t switches = 0;   ///< an object gets another track than the last one it had
  std::size_t fragments = 0;  ///< an object is lost and found again
  double distance_sum = 0.0;  ///< m, of the matches

  double mota() const;  ///< at most 1; negative if there are more errors than objects
  double motp() const;  ///< mean distance of the matches, m
};

/// Counts matches and errors frame by frame.
class ClearMotCounter {
 public:
  /// A track that is farther than this from an object cannot be its match, m.
  explicit ClearMotCounter(double max_distance) : max_distance_(max_distance) {}

  /// Matches of the last frame are kept while they are close enough; the others are assigned with
  /// the smallest sum of distances.
  void add(const TrackedFrame& frame);
  const ClearMot& result() const { return result_; }
  /// The longest time, in frames, that one track had each object, divided by the frames in which
  /// the object was there.
  std::map<long, double> identityShares() const;

 private:
  struct Seen {
    std::size_t frames = 0;
    std::map<long, std::size_t> by_track;
    long track = -1;     ///< the last that it had; -1: none yet
    long counted = -1;   ///< the last while it counted
    bool found = false;  ///< in the last frame
  };

  std::vector<int> match(const TrackedFrame& frame) const;
  void assignRest(const TrackedFrame& frame, std::vector<int>& track_of) const;
  void count(const TrackedObject& object, const TrackedObject* track);

  double max_distance_;
  ClearMot result_;
  std::map<long, Seen> objects_;
};

}  // namespace kestrel
