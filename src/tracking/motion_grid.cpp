// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/motion_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "offsets.h"

namespace kestrel {
namespace {

constexpr double kBytesPerMegabyte = 1e6;
constexpr double kNominalPeriod = 0.1;  ///< s, for which the inverse measurement values hold
// After a gap, a scan does not count more than this many scans at the nominal rate.
constexpr double kMaxScale = 5.0;
constexpr float kEpisodeGap = 0.5F;     ///< s; thin objects are missed for shorter times
constexpr float kMaxCoordinate = 1e6F;  ///< cells; what is beyond comes from a wrong pose

/// [Siew 2018, eq. 4].
float logOdds(double probability) {
  return static_cast<float>(std::log(probability / (1.0 - probability)));
}

/// [Siew 2018, eq. 7].
double probabilityOf(float log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

}  // namespace

template <int D>
MotionGrid<D>::MotionGrid(const MotionGridConfig& config)
    : config_(config),
      per_meter_(static_cast<float>(1.0 / config.resolution_m)),
      low_(logOdds(config.low)),
      medium_(logOdds(config.medium)),
      high_(logOdds(config.high)),
      min_(logOdds(config.min_probability)),
      max_(logOdds(config.max_probability)),
      free_(logOdds(config.free_below)),
      occupied_(logOdds(config.occupied_above)),
      cells_(static_cast<std::size_t>(config.memory_limit_mb * kBytesPerMegabyte)) {}

template <int D>
const typename MotionGrid<D>::Result& MotionGrid<D>::insert(const std::vector<GridRay<D>>& rays,
                                                            double seconds) {
  scale_ = static_cast<float>(std::clamp(seconds / kNominalPeriod, 0.0, kMaxScale));
  if (scan_ == 0) scale_ = 1.0F;
  result_.full = false;
  result_.moving.clear();
  // All returns are classified by the grids of the last scan before the first cell changes.
  findEnds(rays);
  classify(rays);
  ++scan_;
  time_ += std::max(seconds, 0.0);
  updateHits();
  protectSurface(rays);
  clearAlong(rays);
  return result_;
}

template <int D>
void MotionGrid<D>::findEnds(const std::vector<GridRay<D>>& rays) {
  const float limit = kMaxCoordinate * static_cast<float>(config_.resolution_m);
  ends_.clear();
  ends_.reserve(rays.size());
  for (const GridRay<D>& ray : rays) {
    RayEnd& end = ends_.emplace_back();
    end.is_usable =
        (ray.origin.array().abs() < limit).all() && (ray.end.array().abs() < limit).all();
    if (!end.is_usable) continue;
    end.index = indexOf(ray.end);
    if (ray.hit) end.cell = cells_.find(end.index);
  }
}

template <int D>
void MotionGrid<D>::classify(const std::vector<GridRay<D>>& rays) {
  result_.motion.assign(rays.size(), CellMotion::kNone);
  result_.was_free.assign(rays.size(), false);
  result_.has_come.assign(rays.size(), false);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const RayEnd& end = ends_[i];
    if (!rays[i].hit || !end.is_usable) continue;
    result_.motion[i] = motionOf(rays[i], end.cell);
    if (end.cell == nullptr) continue;
    const bool was_free = stateOf(*end.cell) == CellState::kFree;
    if (was_free) result_.was_free[i] = true;
    const bool comes = was_free && isPassedAt(*end.cell, rays[i].end);
    if (comes || (end.cell->has_come && hasStopped(*end.cell))) result_.has_come[i] = true;
  }
}

/// The rows of table 1 and 2 with an occupied measurement. A return near something static belongs
/// to it, because of the noise of laser and pose.
template <int D>
CellMotion MotionGrid<D>::motionOf(const GridRay<D>& ray, const CellData* own) const {
  if (isStatic(own)) return CellMotion::kStatic;  // as most returns, which are from walls
  const CellState state = own != nullptr ? stateOf(*own) : CellState::kUnobserved;
  const double range = static_cast<double>((ray.end - ray.origin).norm());
  const Surroundings near =
      surroundingsOf(ray.end, config_.tolerance_m + config_.tolerance_rad * range);
  if (near.is_static) return CellMotion::kStatic;
  const bool was_moving = own != nullptr && hasStopped(*own) && state != CellState::kFree;
  if (near.has_stopped || was_moving) return CellMotion::kStopped;
  const bool is_imposed = own != nullptr && own->imposed == scan_ + 1;
  if (state == CellState::kFree || is_imposed) return CellMotion::kMoving;
  const bool is_new = near.is_new || state == CellState::kUnobserved;
  return is_new && scan_ > 0 && config_.new_s > 0.0 ? CellMotion::kNew : CellMotion::kStatic;
}

template <int D>
void MotionGrid<D>::updateHits() {
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    const CellMotion motion = result_.motion[i];
    if (motion == CellMotion::kNone) continue;
    const RayEnd& end = ends_[i];
    CellData* cell = end.cell != nullptr ? end.cell : cells_.obtain(end.index);
    if (cell == nullptr) {
      result_.full = true;
      continue;
    }
    if (motion == CellMotion::kMoving) addMoving(end.index);
    if (cell->scan != scan_) updateHit(*cell, motion, result_.has_come[i]);
  }
}

template <int D>
void MotionGrid<D>::updateHit(CellData& cell, CellMotion motion, bool has_come) {
  cell.scan = scan_;
  const auto now = static_cast<float>(time_);
  if (cell.last_hit < 0.0F || now - cell.last_hit > kEpisodeGap) cell.first_hit = now;
  cell.last_hit = now;
  cell.has_come = has_come;
  if constexpr (D == 3) {
    if (!has_come) cell.lowest_pass = std::numeric_limits<float>::infinity();
  }
  const bool is_moving = motion == CellMotion::kMoving;
  cell.was_moving = is_moving || (cell.was_moving && motion == CellMotion::kStopped);
  const bool by_medium = is_moving || motion == CellMotion::kStopped;
  add(cell, by_medium ? medium_ : high_, is_moving ? high_ : low_);
}

template <int D>
typename MotionGrid<D>::CellData* MotionGrid<D>::addMoving(const Index& index) {
  CellData* cell = cells_.obtain(index);
  if (cell == nullptr || cell->moved_in == scan_) return cell;
  cell->moved_in = scan_;
  result_.moving.push_back(index);
  return cell;
}

template <int D>
void MotionGrid<D>::claim(const Vector& point) {
  CellData* cell = addMoving(indexOf(point));
  if (cell != nullptr) cell->was_moving = true;
}

template <int D>
void MotionGrid<D>::passCell(CellData& cell, bool presumed) const {
  cell.scan = scan_;
  cell.last_pass = static_cast<float>(time_);
  const float low = presumed ? std::clamp(-cell.static_odds / scale_, low_, 0.0F) : low_;
  add(cell, low, low_);
  if (cell.static_odds < free_) cell.was_moving = false;
  if (cell.static_odds == min_ && cell.dynamic_odds == min_) cell.scan = kClear;
}

/// [Siew 2018, eq. 6] with the prior 0.5, within the bounds.
template <int D>
void MotionGrid<D>::add(CellData& cell, float static_change, float dynamic_change) const {
  const bool was_occupied = cell.static_odds > occupied_;
  cell.static_odds = std::clamp(cell.static_odds + scale_ * static_change, min_, max_);
  if (!was_occupied && cell.static_odds > occupied_) {
    cell.occupied_since = static_cast<float>(time_);
  }
  cell.dynamic_odds = std::clamp(cell.dynamic_odds + scale_ * dynamic_change, min_, max_);
}

template <int D>
void MotionGrid<D>::impose(const std::function<Vector(const Vector&)>& displacement, double reach) {
  const int radius = static_cast<int>(std::ceil(reach / config_.resolution_m));
  const double limit = reach / config_.resolution_m + 0.5;
  std::vector<Index> offsets;
  anyBetween<D>(Index::Constant(-radius), Index::Constant(radius), [&](const Index& offset) {
    if (offset.template cast<double>().norm() <= limit) offsets.push_back(offset);
    return false;
  });
  for (const Index& moving : result_.moving) {
    const Vector center = centerOf(moving);
    const Vector displaced = center + displacement(center);
    if (!displaced.allFinite()) continue;
    const Index moved = indexOf(displaced);
    for (const Index& offset : offsets) {
      if (CellData* cell = cells_.obtain(moved + offset)) cell->imposed = scan_ + 1;
    }
  }
}

template <int D>
void MotionGrid<D>::forgetFar(const Vector& position) {
  cells_.keepAround(indexOf(position),
                    static_cast<int>(config_.keep_radius_m / config_.resolution_m));
}

template <int D>
CellState MotionGrid<D>::stateOf(const CellData& cell) const {
  if (cell.static_odds < free_) return CellState::kFree;
  return cell.static_odds > occupied_ ? CellState::kOccupied : CellState::kUnobserved;
}

template <int D>
bool MotionGrid<D>::isStatic(const CellData* cell) const {
  return cell != nullptr && stateOf(*cell) == CellState::kOccupied && !hasStopped(*cell) &&
         !isNew(*cell);
}

template <int D>
CellState MotionGrid<D>::staticState(const Index& index) const {
  const CellData* cell = cells_.find(index);
  return cell != nullptr ? stateOf(*cell) : CellState::kUnobserved;
}

/// What the first scan shows is static.
template <int D>
bool MotionGrid<D>::isNew(const CellData& cell) const {
  return cell.occupied_since > 0.0F &&
         time_ - static_cast<double>(cell.occupied_since) < config_.new_s;
}

/// It came there, and has not been there for long.
template <int D>
bool MotionGrid<D>::hasStopped(const CellData& cell) const {
  return cell.was_moving && time_ - static_cast<double>(cell.first_hit) < config_.stopped_s;
}

template <int D>
bool MotionGrid<D>::wasPassed(const Index& index) const {
  const CellData* cell = cells_.find(index);
  return cell != nullptr && cell->last_pass > cell->last_hit;
}

template <int D>
bool MotionGrid<D>::isPassedAt(const CellData& cell, const Vector& point) {
  if constexpr (D == 3) return cell.lowest_pass <= point.z();
  return true;
}

template <int D>
bool MotionGrid<D>::wasPassedAt(const Vector& point) const {
  const CellData* cell = cells_.find(indexOf(point));
  return cell != nullptr && cell->last_pass > cell->last_hit && isPassedAt(*cell, point);
}

template <int D>
double MotionGrid<D>::lastReturn(const Index& index) const {
  const Index ones = Index::Ones();
  float last = -1.0F;
  anyKnown<D>(cells_, index - ones, index + ones, [&](const Index&, const CellData& near) {
    last = std::max(last, near.last_hit);
    return false;
  });
  return static_cast<double>(last);
}

template <int D>
bool MotionGrid<D>::cameAfter(const Index& index, double time) const {
  const Index ones = Index::Ones();
  return !anyKnown<D>(cells_, index - ones, index + ones, [&](const Index&, const CellData& near) {
    return near.last_hit >= 0.0F && static_cast<float>(time_) - near.last_hit <= kEpisodeGap &&
           near.first_hit <= static_cast<float>(time);
  });
}

template <int D>
double MotionGrid<D>::staticProbability(const Index& index) const {
  const CellData* cell = cells_.find(index);
  return cell != nullptr ? probabilityOf(cell->static_odds) : 0.5;
}

template <int D>
double MotionGrid<D>::dynamicProbability(const Index& index) const {
  const CellData* cell = cells_.find(index);
  return cell != nullptr ? probabilityOf(cell->dynamic_odds) : 0.5;
}

template <int D>
bool MotionGrid<D>::isImposed(const Index& index) const {
  const CellData* cell = cells_.find(index);
  return cell != nullptr && cell->imposed == scan_ + 1;
}

template <int D>
GridIndex<D> MotionGrid<D>::indexOf(const Vector& point) const {
  Index index;
  for (int i = 0; i < D; ++i) index(i) = floorToInt(point(i) * per_meter_);
  return index;
}

template <int D>
Eigen::Matrix<float, D, 1> MotionGrid<D>::centerOf(const Index& index) const {
  return (index.template cast<float>() + Vector::Constant(0.5F)) *
         static_cast<float>(config_.resolution_m);
}

template class MotionGrid<2>;
template class MotionGrid<3>;

}  // namespace kestrel
