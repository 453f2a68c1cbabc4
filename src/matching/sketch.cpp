// SPDX-License-Identifier: BSD-3-Clause
#include "sketch.h"

#include <algorithm>

#include "hybrid_matcher.h"

namespace kestrel {
namespace {

constexpr int kSketchIterations = 6;
constexpr std::size_t kSketchStages = kMatchStages - 1;

Descent stageOf(const SurfelField& surface, const Points& sample, const Pose2& start,
                std::size_t stage) {
  GaussNewtonConfig config;
  config.max_iterations = kSketchIterations;
  config.min_step_m = kCoarseStepM;
  config.min_step_rad = kCoarseStepRad;
  const Eigen::Vector3f pull =
      Eigen::Vector3f::Constant(kPriorWeight * static_cast<float>(sample.size()));
  return descend(start, config, pull, [&](const Pose2& at) {
    return linearizeDistance(surface, sample, at, kStageScales[stage]);
  });
}

/// The same, if it is not in the memory yet.
Descent rememberedStage(const SurfelField& surface, const Points& sample, const Pose2& start,
                        std::size_t stage, SharedSearch* memory) {
  if (memory == nullptr) return stageOf(surface, sample, start, stage);
  if (const Descent* known = memory->find(static_cast<int>(stage), start)) return *known;
  const Descent descent = stageOf(surface, sample, start, stage);
  memory->add(static_cast<int>(stage), start, descent);
  return descent;
}

std::int64_t sketchWork(const Points& sample) {
  constexpr std::int64_t kPerPoint = 1000;
  return kPerPoint * static_cast<std::int64_t>(sample.size());
}

/// Leaves the half with the lowest cost, at least `least`, in the same order.
void halve(std::vector<Descent>& descents, std::size_t least) {
  const std::size_t keep = std::max(least, (descents.size() + 1) / 2);
  if (descents.size() <= keep) return;
  std::vector<float> costs;
  for (const Descent& descent : descents) costs.push_back(descent.at_pose.cost);
  std::sort(costs.begin(), costs.end());
  const float most = costs[keep - 1];
  descents.erase(std::remove_if(descents.begin(), descents.end(),
                                [&](const Descent& d) { return !(d.at_pose.cost <= most); }),
                 descents.end());
}

}  // namespace

Pose2 sketch(const SurfelField& surface, const Points& sample, const Pose2& hypothesis) {
  Pose2 pose = hypothesis;
  for (std::size_t stage = 0; stage < kSketchStages; ++stage)
    pose = stageOf(surface, sample, pose, stage).pose;
  return pose;
}

std::vector<Pose2> sketches(const SurfelField& surface, const Points& sample,
                            const std::vector<Pose2>& hypotheses, std::size_t least,
                            WorkBudget& budget, SharedSearch* memory) {
  if (memory != nullptr) memory->use(surface);
  std::vector<Descent> descents;
  for (const Pose2& hypothesis : hypotheses) {
    if (!budget.take(sketchWork(sample))) break;
    descents.push_back(rememberedStage(surface, sample, hypothesis, 0, memory));
  }
  halve(descents, least);
  std::vector<Pose2> poses;
  for (const Descent& descent : descents) {
    Pose2 pose = descent.pose;
    for (std::size_t stage = 1; stage < kSketchStages; ++stage)
      pose = rememberedStage(surface, sample, pose, stage, memory).pose;
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace kestrel
