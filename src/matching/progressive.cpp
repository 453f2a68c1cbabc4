// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/progressive.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/matching/thinned.h"

namespace kestrel {
namespace {

static_assert(OccupancyGrid::kLevels == kMatchStages, "one stage per level");
constexpr int kCoarsestLevel = OccupancyGrid::kLevels - 1;
/// Number of points that vote on a level, 5 cm first. Large cells need fewer points, because
/// neighbors hit the same cells.
constexpr std::array<std::size_t, OccupancyGrid::kLevels> kLevelPoints = {180, 120, 90};
/// A candidate is checked for early termination after this many points.
constexpr std::size_t kChunk = 32;
/// Candidates that are less likely than the best one by a factor exp(-kNegligibleLog) are dropped.
constexpr double kNegligibleLog = 6.0;
constexpr float kOccupied = 0.5F;

/// The points of a scan, prepared to count votes on one level for any pose.
class VoteCounter {
 public:
  VoteCounter(const OccupancyGrid& grid, int level, const Points& points)
      : grid_(grid),
        level_(level),
        inverse_cell_(1.0F / (grid.resolution() * static_cast<float>(1 << level))) {
    // Reordered, so that each chunk is a sample of the whole scan.
    const std::size_t stride = points.size() / kChunk + 1;
    cells_.reserve(points.size());
    for (std::size_t first = 0; first < stride; ++first) {
      for (std::size_t i = first; i < points.size(); i += stride) {
        cells_.push_back(points[i] * inverse_cell_);
      }
    }
  }

  /// The voting likelihood, or 0 as soon as it is clear that it is below `enough`.
  double vote(const Pose2& pose, double enough) const {
    static_assert(kCoarsestLevel == 2, "one case per level");
    if (cells_.empty()) return 0.0;
    if (level_ == 0) return count<0>(pose, enough);
    return level_ == 1 ? count<1>(pose, enough) : count<2>(pose, enough);
  }

 private:
  /// The level is a template parameter for speed: the look-up of cells takes most of the time.
  template <int kLevel>
  double count(const Pose2& pose, double enough) const {
    const auto c = static_cast<float>(std::cos(pose.yaw));
    const auto s = static_cast<float>(std::sin(pose.yaw));
    const float x = static_cast<float>(pose.x) * inverse_cell_;
    const float y = static_cast<float>(pose.y) * inverse_cell_;
    const auto needed = static_cast<float>(enough * static_cast<double>(cells_.size()));
    float sum = 0.0F;
    for (std::size_t begin = 0; begin < cells_.size(); begin += kChunk) {
      if (sum + static_cast<float>(cells_.size() - begin) < needed) return 0.0;
      const std::size_t end = std::min(cells_.size(), begin + kChunk);
      for (std::size_t i = begin; i < end; ++i) {
        const Eigen::Vector2f& p = cells_[i];
        const Cell hit{floorToInt(x + c * p.x() - s * p.y()),
                       floorToInt(y + s * p.x() + c * p.y())};
        const auto probability = static_cast<float>(grid_.levelProbability(kLevel, hit));
        sum += probability > kOccupied ? probability : 0.0F;
      }
    }
    return static_cast<double>(sum) / static_cast<double>(cells_.size());
  }

  const OccupancyGrid& grid_;
  int level_;
  float inverse_cell_;
  Points cells_;  ///< end points in the base frame, in cells of the level
};

double meanRange(const Points& points) {
  double sum = 0.0;
  for (const Eigen::Vector2f& p : points) sum += static_cast<double>(p.norm());
  return points.empty() ? 0.0 : sum / static_cast<double>(points.size());
}

}  // namespace

StandardCandidates standardCandidates(int count, int seed) {
  Random random(static_cast<std::uint64_t>(seed));
  StandardCandidates result = {Eigen::Vector3f::Zero()};
  for (int i = 1; i < count; ++i) {
    Eigen::Vector3f& candidate = result.emplace_back();
    for (float& value : candidate) value = static_cast<float>(random.gaussian());
  }
  // Likely candidates first: the earlier a good one is found, the earlier poor ones are dropped.
  std::stable_sort(result.begin(), result.end(),
                   [](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
                     return a.squaredNorm() < b.squaredNorm();
                   });
  return result;
}

CandidateSpread motionSpread(const Pose2& last, const Pose2& initial_guess,
                             const ProgressiveConfig& config) {
  const Pose2 motion = last.inverse() * initial_guess;
  return {std::max(config.min_sigma_m, config.motion_share * motion.distance()),
          std::max(config.min_sigma_rad, config.turn_share * std::abs(motion.yaw))};
}

double votingLikelihood(const OccupancyGrid& grid, int level, const Points& points,
                        const Pose2& map_T_base) {
  return VoteCounter(grid, level, points).vote(map_T_base, 0.0);
}

LevelEstimate bestCandidate(const OccupancyGrid& grid, int level, const Points& points,
                            const Pose2& center, const CandidateSpread& spread,
                            const StandardCandidates& candidates, double beams) {
  const VoteCounter counter(grid, level, points);
  const Eigen::Vector3d sigma(spread.linear_m, spread.linear_m, spread.angular_rad);
  std::vector<double> votes;
  votes.reserve(candidates.size());
  double most_votes = 0.0, best = -std::numeric_limits<double>::infinity();
  LevelEstimate result;
  for (const Eigen::Vector3f& candidate : candidates) {
    const Pose2 pose = addOffset(center, sigma.cwiseProduct(candidate.cast<double>()));
    votes.push_back(counter.vote(pose, most_votes - kNegligibleLog / beams));
    most_votes = std::max(most_votes, votes.back());
    const double log_posterior =
        beams * votes.back() -
        0.5 * static_cast<double>(candidate.squaredNorm());  // [Xie 2010, eq. 7-10, 19]
    if (log_posterior <= best) continue;
    best = log_posterior;
    result.pose = pose;
    result.vote = votes.back();
  }
  // The candidates are drawn from the motion model, so the weight is only their likelihood.
  double total = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double weight = std::exp(beams * (votes[i] - most_votes));
    const Eigen::Vector3d offset = sigma.cwiseProduct(candidates[i].cast<double>());
    total += weight;
    first += weight * offset;
    second += weight * offset * offset.transpose();
  }
  first /= total;
  result.mean = most_votes > 0.0 ? addOffset(center, first) : center;
  result.covariance = second / total - first * first.transpose();
  return result;
}

ProgressiveRefiner::ProgressiveRefiner(const ProgressiveConfig& config)
    : config_(config),
      coarse_(standardCandidates(config.coarse_candidates, config.seed)),
      fine_(standardCandidates(config.fine_candidates, config.seed)),
      wide_(standardCandidates(config.wide_candidates, config.seed)) {}

Refinement ProgressiveRefiner::refine(const OccupancyGrid& grid, const Points& points,
                                      const Pose2& initial_guess,
                                      const CandidateSpread& spread) const {
  const double lever_m = meanRange(points);
  Refinement result;
  Pose2 pose = initial_guess;
  CandidateSpread space = spread;
  for (std::size_t stage = 0; stage < kMatchStages; ++stage) {
    const int level = kCoarsestLevel - static_cast<int>(stage);
    const LevelEstimate estimate =
        bestCandidate(grid, level, thinned(points, kLevelPoints[static_cast<std::size_t>(level)]),
                      pose, space, stage == 0 ? coarse_ : fine_, config_.beams);
    // The mean is more accurate than the spacing of the candidates. It matters for the last level,
    // which is not refined further.
    const Pose2 next = level == 0 ? estimate.mean : estimate.pose;
    const Pose2 correction = pose.inverse() * next;
    result.spreads[stage] = space;
    result.corrections_m[stage] = std::hypot(correction.distance(), lever_m * correction.yaw);
    const double coarser_cell_m = static_cast<double>(grid.resolution()) * (2 << level);
    const double limit_m = stage == 0 ? std::numeric_limits<double>::infinity()
                                      : std::max(result.corrections_m[stage - 1],
                                                 config_.slack_cells * coarser_cell_m);
    result.stopped = result.corrections_m[stage] > limit_m;
    if (result.stopped) break;
    pose = next;
    result.finest = estimate;
    std::fill(result.poses.begin() + static_cast<std::ptrdiff_t>(stage), result.poses.end(), pose);
    result.levels = static_cast<int>(stage) + 1;
    space = {config_.shrink * space.linear_m, config_.shrink * space.angular_rad};
  }
  return result;
}

Pose2 ProgressiveRefiner::findCoarsely(const OccupancyGrid& grid, const Points& points,
                                       const Pose2& center, const CandidateSpread& spread) const {
  return bestCandidate(grid, kCoarsestLevel, thinned(points, kLevelPoints[kCoarsestLevel]), center,
                       spread, wide_, config_.beams)
      .pose;
}

}  // namespace kestrel
