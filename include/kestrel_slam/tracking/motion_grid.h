// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <type_traits>
#include <vector>

#include "kestrel_slam/tracking/cell_map.h"

namespace kestrel {

/// Parameters of the static and the dynamic grid [Siew 2018, sec. III].
struct MotionGridConfig {
  double resolution_m = 0.1;
  // Inverse measurement values of tables 1 and 2: the probability that a cell is occupied, given
  // one measurement. They are for scans at 10 Hz; at other rates their log odds are scaled by the
  // time between two scans, so that people who stop become a part of the map after the same time.
  double low = 0.4;     ///< a beam passed the cell: smaller frees cells faster
  double medium = 0.6;  ///< something moves here: larger takes what has stopped into the static
                        ///< grid sooner, and with it slow objects
  double high = 0.9;    ///< something stands here: larger resists beams that miss thin objects
  // Bounds, so that a cell can change again.
  double min_probability = 0.05;
  double max_probability = 0.97;
  // A cell is free below the first and occupied above the second probability; between them it
  // counts as unobserved.
  double free_below = 0.35;
  double occupied_above = 0.65;
  /// A return this near to something static belongs to it: noise of the laser and of the pose, m.
  double tolerance_m = 0.1;
  double tolerance_rad = 0.005;  ///< the same, for each meter of range: error of the yaw
  /// What is seen where nothing was known counts as new for this time, s: it may be an object that
  /// moves in unknown space. 0: it is static at once, as in table 1.
  double new_s = 0.0;
  /// What has stopped belongs to the static grid after this time, s: so a wall that was taken for
  /// something that moves comes back.
  double stopped_s = 30.0;
  double keep_radius_m = 60.0;  ///< the grids forget what is farther from the sensor
  double memory_limit_mb = 256.0;
};

/// One beam in the frame of the grids, m.
template <int D>
struct GridRay {
  Eigen::Matrix<float, D, 1> origin, end;
  bool hit = true;
  /// Without a return: the space is only presumably free, because glass and dark surfaces give no
  /// return. Such a beam can show that something has left its place, but not that a cell is free.
  bool presumed = false;
};

/// What a return belongs to.
enum class CellMotion : std::uint8_t {
  kNone,  ///< no return
  kStatic,
  kNew,      ///< where nothing was known until a moment ago: most of it stands
  kStopped,  ///< in a cell that became static while something that moved stood there
  kMoving
};

/// What the grids know of a cell, from its log odds [Siew 2018, sec. III].
enum class CellState { kFree, kUnobserved, kOccupied };

/// Static and dynamic occupancy grid with conditioned inverse measurement models [Siew 2018, eq.
/// 4-7, tables 1 and 2], and the extraction of moving points.
///
/// Every cell is updated once for each scan: a return overrides beams that pass.
template <int D>
class MotionGrid {
 public:
  using Vector = Eigen::Matrix<float, D, 1>;
  using Index = GridIndex<D>;

  explicit MotionGrid(const MotionGridConfig& config = MotionGridConfig());

  struct Result {
    std::vector<CellMotion> motion;  ///< of each ray
    std::vector<bool> was_free;      ///< of each ray: the return is in a cell that was free
    /// Of each ray: the return is of something that has come into free space, now or before it
    /// stopped. Not so what is only taken as moving because of the imposed map or a claim. In 3D, a
    /// beam must have passed at this height or below: what comes into view below the beams, as the
    /// roof of a parked car, has not come.
    std::vector<bool> has_come;
    std::vector<Index> moving;  ///< occupied cells of the new dynamic map
    bool full = false;          ///< cells are missing because of the memory limit
  };

  /// Classifies the returns by the static grid before this scan and by the imposed dynamic map, and
  /// updates both grids. `seconds`: since the last scan; 0 for the first. Rays that are not finite
  /// are ignored. Valid until the next call.
  const Result& insert(const std::vector<GridRay<D>>& rays, double seconds);

  /// The imposed dynamic map: the moving cells of the last scan are displaced by `displacement`
  /// (m, of a cell's center) and by every vector up to `reach` (m). What is seen for the first time
  /// in these cells by the next scan is taken as moving. A displacement that is not finite leaves
  /// the cell out.
  void impose(const std::function<Vector(const Vector&)>& displacement, double reach);
  /// What is seen here was new, and moves: the cell belongs to the dynamic map of this scan.
  void claim(const Vector& point);

  /// What is farther than the configured radius from `position` is forgotten.
  void forgetFar(const Vector& position);

  CellState staticState(const Index& index) const;
  /// Occupancy probabilities [Siew 2018, eq. 7]; 0.5 if nothing is known.
  double staticProbability(const Index& index) const;
  double dynamicProbability(const Index& index) const;
  /// True if the cell is in the imposed map for the next scan.
  bool isImposed(const Index& index) const;
  /// Time since the first scan, s.
  double time() const { return time_; }
  /// True if a beam has passed the cell since its last return.
  bool wasPassed(const Index& index) const;
  /// The same for a point: in 3D, at its height or below.
  bool wasPassedAt(const Vector& point) const;
  /// Time of the last return in this cell or next to it, s; negative if there was none.
  double lastReturn(const Index& index) const;
  /// True if nothing was in this cell or next to it at `time` (s) or before: what is here now has
  /// come later. (Returns before a gap of half a second do not count.)
  bool cameAfter(const Index& index, double time) const;

  Index indexOf(const Vector& point) const;
  Vector centerOf(const Index& index) const;
  double resolution() const { return config_.resolution_m; }
  std::size_t memoryBytes() const { return cells_.memoryBytes(); }

 private:
  static constexpr std::uint32_t kClear = std::numeric_limits<std::uint32_t>::max();
  struct PassHeight {
    /// Of the beams that have passed since the last return that does not move, m. Voxels are large:
    /// one in which the top of something lies is free for the beams above it.
    float lowest_pass = std::numeric_limits<float>::infinity();
  };
  struct Nothing {};
  struct CellData : std::conditional_t<D == 3, PassHeight, Nothing> {
    float static_odds = 0.0F, dynamic_odds = 0.0F;  ///< log odds; the prior of 0.5 is 0
    /// That updated it last; kClear if another beam that passes changes nothing.
    std::uint32_t scan = 0;
    std::uint32_t imposed = 0;    ///< number of the scan for which it is in the imposed map
    std::uint32_t moved_in = 0;   ///< last scan with something moving in it
    float first_hit = -1.0F;      ///< time of the first of the returns without long gaps, s
    float last_hit = -1.0F;       ///< negative: none yet
    float last_pass = -1.0F;      ///< time of the last beam that passed, s
    float occupied_since = 0.0F;  ///< time when it became occupied, s
    bool was_moving = false;      ///< it was free, and then filled by something that moved
    bool has_come = false;        ///< it was free, and then filled by something that is still here
  };

  /// What is occupied near a point.
  struct Surroundings {
    bool is_static = false, has_stopped = false, is_new = false;
  };

  /// Where a ray ends.
  struct RayEnd {
    Index index = Index::Zero();
    CellData* cell = nullptr;  ///< nullptr if nothing is known there
    bool is_usable = false;
  };

  void findEnds(const std::vector<GridRay<D>>& rays);
  void classify(const std::vector<GridRay<D>>& rays);
  Surroundings surroundingsOf(const Vector& point, double distance) const;
  CellState stateOf(const CellData& cell) const;
  bool isStatic(const CellData* cell) const;
  CellMotion motionOf(const GridRay<D>& ray, const CellData* own) const;
  CellData* addMoving(const Index& index);
  void updateHits();
  void updateHit(CellData& cell, CellMotion motion, bool has_come);
  void protectSurface(const std::vector<GridRay<D>>& rays);
  void protectAround(const Index& index);
  void protectCell(const Index& index);
  void clearAlong(const std::vector<GridRay<D>>& rays);
  void passAlong(const GridRay<D>& ray, const Vector& from);
  void passCell(CellData& cell, bool presumed) const;
  static bool isPassedAt(const CellData& cell, const Vector& point);
  bool isNew(const CellData& cell) const;
  bool hasStopped(const CellData& cell) const;
  void add(CellData& cell, float static_change, float dynamic_change) const;

  MotionGridConfig config_;
  float per_meter_;                    ///< cells
  float low_, medium_, high_;          ///< log odds at 10 Hz
  float min_, max_, free_, occupied_;  ///< log odds
  float scale_ = 1.0F;                 ///< of the log odds, for the current scan
  CellMap<D, CellData> cells_;
  Result result_;
  std::vector<RayEnd> ends_;  ///< of the rays of this scan
  std::uint32_t scan_ = 0;
  double time_ = 0.0;
};

/// The cells from the one of `from` to the one of `to`, in order [Amanatides 1987]. Coordinates in
/// cells.
template <int D>
struct CellWalk {
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  int index[D], last[D], step[D];
  double next[D], per_cell[D];  // shares of the way: of the next border, and between two of them
  int remaining = 0;            // steps to the last cell

  CellWalk(const Eigen::Matrix<float, D, 1>& from, const Eigen::Matrix<float, D, 1>& to) {
    for (int i = 0; i < D; ++i) {
      index[i] = floorToInt(from(i));
      last[i] = floorToInt(to(i));
      const double difference = static_cast<double>(to(i)) - static_cast<double>(from(i));
      step[i] = difference > 0.0 ? 1 : -1;
      per_cell[i] = 1.0 / std::abs(difference);
      const double border = index[i] + (step[i] > 0 ? 1.0 : 0.0);
      next[i] = index[i] != last[i] ? (border - static_cast<double>(from(i))) / difference : kNever;
      remaining += std::abs(last[i] - index[i]);
    }
  }

  /// Goes to the next cell, and returns the share of the way at which it leaves this one.
  double advance() {
    int axis = 0;
    for (int i = 1; i < D; ++i) {
      if (next[i] < next[axis]) axis = i;
    }
    const double share = next[axis];
    index[axis] += step[axis];
    next[axis] = index[axis] != last[axis] ? share + per_cell[axis] : kNever;
    --remaining;
    return share;
  }
};

/// Calls `visit(index)` for every cell of a walk but the last, until it returns false.
template <int D, typename Visit>
void traverse(const Eigen::Matrix<float, D, 1>& from, const Eigen::Matrix<float, D, 1>& to,
              Visit visit) {
  CellWalk<D> walk(from, to);
  while (walk.remaining > 0) {
    if (!visit(GridIndex<D>(Eigen::Map<const GridIndex<D>>(walk.index)))) return;
    walk.advance();
  }
}

}  // namespace kestrel
