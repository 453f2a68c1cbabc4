// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/loop_quality.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/evaluation/consistency.h"
#include "kestrel_slam/graph/keyframe_errors.h"

namespace kestrel {
namespace {

std::vector<Pose2> posesAt(const std::vector<double>& stamps, const Trajectory& truth) {
  constexpr double kSameStamp = 1e-3;  // s
  std::vector<Pose2> result;
  for (const double stamp : stamps) {
    const auto at =
        std::lower_bound(truth.begin(), truth.end(), stamp - kSameStamp,
                         [](const StampedPose& pose, double time) { return pose.stamp < time; });
    if (at == truth.end() || at->stamp > stamp + kSameStamp)
      throw std::invalid_argument("there is no true pose at " + std::to_string(stamp) + " s");
    result.push_back(at->pose);
  }
  return result;
}

/// Whether the keyframe is near the path of an earlier visit.
bool isBack(std::size_t keyframe, const std::vector<double>& stamps,
            const std::vector<Pose2>& poses) {
  for (std::size_t i = 0; stamps[keyframe] - stamps[i] > kEarlierVisit; ++i) {
    if (poses[i].between(poses[keyframe]).distance() < kNearPath) return true;
  }
  return false;
}

/// Keyframes [first, last) of each revisit.
std::vector<std::pair<std::size_t, std::size_t>> revisitsOf(const std::vector<double>& stamps,
                                                            const std::vector<Pose2>& poses) {
  std::vector<std::pair<std::size_t, std::size_t>> result;
  for (std::size_t i = 0; i < stamps.size();) {
    std::size_t end = i;
    while (end < stamps.size() && isBack(end, stamps, poses)) ++end;
    if (end > i && stamps[end - 1] - stamps[i] >= kRevisit) result.emplace_back(i, end);
    i = std::max(end, i + 1);
  }
  return result;
}

/// At every tenth keyframe.
std::vector<double> neesAlong(const GraphResult& mapped, const std::vector<Pose2>& truth) {
  constexpr std::size_t kEvery = 10;
  std::vector<double> result;
  const KeyframeMarginals marginals(mapped.graph, mapped.errors, {});
  for (std::size_t i = kEvery; i < truth.size(); i += kEvery) {
    const std::optional<GaussianPose2> pose = marginals.between(0, i);
    if (!pose) continue;
    const Pose2 error = pose->mean.between(truth[0].between(truth[i]));
    result.push_back(neesOf(error.log(), pose->covariance + mapped.errors[i].match));
  }
  return result;
}

}  // namespace

LoopQuality qualityOf(const GraphResult& result, const Trajectory& truth) {
  const std::vector<Pose2> poses = posesAt(result.stamps, truth);
  LoopQuality quality;
  std::vector<bool> closed(poses.size(), false);
  for (const Loop& loop : result.loops) {
    if (loop.state != LoopState::kAccepted) continue;
    const Pose2 error =
        poses[loop.anchor].between(poses[loop.query]).between(loop.anchor_T_query.mean);
    ++quality.accepted;
    quality.worst_m = std::max(quality.worst_m, error.distance());
    if (error.distance() > kWrongLoop) {
      ++quality.wrong;
    } else {
      closed[loop.query] = closed[loop.anchor] = true;
    }
  }
  if (quality.accepted > 0) quality.nees = neesAlong(result, poses);
  for (const auto& [first, last] : revisitsOf(result.stamps, poses)) {
    ++quality.revisits;
    const auto begin = closed.begin();
    if (std::find(begin + static_cast<std::ptrdiff_t>(first),
                  begin + static_cast<std::ptrdiff_t>(last),
                  true) != begin + static_cast<std::ptrdiff_t>(last))
      ++quality.found;
  }
  return quality;
}

}  // namespace kestrel
