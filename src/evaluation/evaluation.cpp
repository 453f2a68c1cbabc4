// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/evaluation.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <sstream>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/rigid_alignment.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

constexpr std::size_t kRelationFields = 8;

/// Finds poses of a trajectory by their stamps.
class PoseIndex {
 public:
  explicit PoseIndex(const Trajectory& trajectory) : poses_(trajectory) {
    std::stable_sort(poses_.begin(), poses_.end(),
                     [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  }

  /// The pose with the nearest stamp within kStampTolerance.
  std::optional<Pose2> at(double stamp) const {
    const auto after = lowerBound(stamp);
    auto best = after;
    if (after == poses_.end() ||
        (after != poses_.begin() && stamp - std::prev(after)->stamp < after->stamp - stamp)) {
      if (after == poses_.begin()) return std::nullopt;
      best = std::prev(after);
    }
    if (std::abs(best->stamp - stamp) > kStampTolerance) return std::nullopt;
    return best->pose;
  }

  std::optional<Pose2> between(double stamp1, double stamp2) const {
    const std::optional<Pose2> a = at(stamp1), b = at(stamp2);
    if (!a || !b) return std::nullopt;
    return a->between(*b);
  }

  /// The pose at `stamp`, interpolated if necessary.
  std::optional<Pose2> interpolated(double stamp) const {
    if (const std::optional<Pose2> exact = at(stamp)) return exact;
    const auto after = lowerBound(stamp);
    if (after == poses_.begin() || after == poses_.end()) return std::nullopt;
    const StampedPose &a = *std::prev(after), &b = *after;
    const double gap = b.stamp - a.stamp;
    if (gap > kMaxReferenceGap) return std::nullopt;
    return interpolate(a.pose, b.pose, (stamp - a.stamp) / gap);
  }

 private:
  Trajectory::const_iterator lowerBound(double stamp) const {
    return std::lower_bound(poses_.begin(), poses_.end(), stamp,
                            [](const StampedPose& p, double t) { return p.stamp < t; });
  }

  Trajectory poses_;
};

PoseError errorOf(double stamp, const Pose2& expected, const Pose2& found) {
  const Pose2 error = expected.inverse() * found;
  return {stamp, error.distance(), radToDeg(std::abs(error.yaw))};
}

std::vector<Eigen::Vector2d> positionsOf(const Trajectory& trajectory) {
  std::vector<Eigen::Vector2d> positions;
  for (const StampedPose& entry : trajectory) positions.push_back(entry.pose.translation());
  return positions;
}

/// Errors of the motions from every pose i to the first pose j with progress[j] - progress[i] >=
/// step. `progress` is the path length or the stamp.
PoseErrorStatistics relativeErrors(const ReferenceEvaluation& matched,
                                   const std::vector<double>& progress, double step) {
  std::vector<PoseError> errors;
  std::size_t j = 0;
  for (std::size_t i = 0; i < progress.size(); ++i) {
    while (j < progress.size() && progress[j] - progress[i] < step) ++j;
    if (j == progress.size()) break;
    errors.push_back(errorOf(matched.aligned[i].stamp,
                             matched.reference[i].pose.inverse() * matched.reference[j].pose,
                             matched.aligned[i].pose.inverse() * matched.aligned[j].pose));
  }
  return statisticsOf(errors);
}

std::vector<double> distancesAlong(const Trajectory& trajectory) {
  std::vector<double> distances;
  double distance = 0.0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (i > 0) {
      distance += (trajectory[i].pose.translation() - trajectory[i - 1].pose.translation()).norm();
    }
    distances.push_back(distance);
  }
  return distances;
}

std::vector<double> stampsOf(const Trajectory& trajectory) {
  std::vector<double> stamps;
  for (const StampedPose& entry : trajectory) stamps.push_back(entry.stamp);
  return stamps;
}

void match(const Trajectory& trajectory, const Trajectory& reference, ReferenceEvaluation& result) {
  const PoseIndex index(reference);
  for (const StampedPose& entry : trajectory) {
    const std::optional<Pose2> truth = index.interpolated(entry.stamp);
    if (!truth) {
      ++result.unmatched;
      continue;
    }
    result.aligned.push_back(entry);
    result.reference.push_back({entry.stamp, *truth});
  }
  if (result.aligned.size() < 2) {
    throw ReferenceMismatch("fewer than two poses have a reference within " +
                            std::to_string(kMaxReferenceGap) +
                            " s of their stamp; check that both files use the same clock");
  }
}

Relation parseRelation(const std::string& path, std::size_t line_number, const std::string& line) {
  const std::string place = path + ", line " + std::to_string(line_number) + ": ";
  std::istringstream fields(line);
  std::array<double, kRelationFields> v{};
  std::size_t count = 0;
  for (std::string field; fields >> field; ++count) {
    if (count < v.size() && !parseFinite(field, v[count])) {
      throw std::runtime_error(place + "'" + field + "' is not a finite number");
    }
  }
  if (count != v.size()) {
    throw std::runtime_error(place + "expected 8 fields (t1 t2 x y z roll pitch yaw), found " +
                             std::to_string(count));
  }
  return {v[0], v[1], Pose2(v[2], v[3], v[7])};
}

}  // namespace

ErrorStatistics statisticsOf(std::vector<double> errors) {
  ErrorStatistics result;
  if (errors.empty()) return result;
  std::sort(errors.begin(), errors.end());
  const double n = static_cast<double>(errors.size());
  double sum = 0.0, squares = 0.0, deviations = 0.0;
  for (const double e : errors) {
    sum += e;
    squares += e * e;
  }
  result.count = errors.size();
  result.mean = sum / n;
  for (const double e : errors) deviations += (e - result.mean) * (e - result.mean);
  result.std = std::sqrt(deviations / n);
  result.median = 0.5 * (errors[(errors.size() - 1) / 2] + errors[errors.size() / 2]);
  result.max = errors.back();
  result.rmse = std::sqrt(squares / n);
  return result;
}

PoseErrorStatistics statisticsOf(const std::vector<PoseError>& errors) {
  std::vector<double> translations, rotations;
  for (const PoseError& error : errors) {
    translations.push_back(error.translation_m);
    rotations.push_back(error.rotation_deg);
  }
  return {statisticsOf(std::move(translations)), statisticsOf(std::move(rotations))};
}

std::vector<Relation> readRelations(const std::string& path) {
  const std::unique_ptr<std::istream> stream = openText(path);
  std::vector<Relation> relations;
  std::size_t line_number = 0;
  for (std::string line; std::getline(*stream, line);) {
    ++line_number;
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos || line[begin] == '#') continue;
    relations.push_back(parseRelation(path, line_number, line));
  }
  if (relations.empty()) {
    throw std::runtime_error(path +
                             ": has no relations; use a file with a line "
                             "`t1 t2 x y z roll pitch yaw` for each relation");
  }
  return relations;
}

RelationEvaluation evaluateRelations(const Trajectory& trajectory,
                                     const std::vector<Relation>& relations) {
  const PoseIndex index(trajectory);
  RelationEvaluation result;
  std::vector<PoseError> distant;
  std::set<double> unmatched;
  for (const Relation& relation : relations) {
    const std::optional<Pose2> pose1 = index.at(relation.stamp1);
    const std::optional<Pose2> pose2 = index.at(relation.stamp2);
    if (!pose1) unmatched.insert(relation.stamp1);
    if (!pose2) unmatched.insert(relation.stamp2);
    if (!pose1 || !pose2) {
      ++result.skipped_relations;
      continue;
    }
    result.errors.push_back(errorOf(relation.stamp1, relation.pose, pose1->inverse() * *pose2));
    result.end_stamps.push_back(std::max(relation.stamp1, relation.stamp2));
    if (std::abs(relation.stamp2 - relation.stamp1) > kDistantRelation) {
      distant.push_back(result.errors.back());
    }
  }
  result.all = statisticsOf(result.errors);
  result.distant = statisticsOf(distant);
  result.unmatched.assign(unmatched.begin(), unmatched.end());
  return result;
}

RelationNoise noiseOf(const std::vector<Relation>& relations, const Trajectory& trajectory,
                      const Trajectory& odometry) {
  constexpr double kMoved = 0.05;         // m
  constexpr double kMedianOfTwo = 1.386;  // of the sum of two squared normal variables
  const PoseIndex mapped(trajectory), measured(odometry);
  std::vector<double> relation_mapped, relation_measured, mapped_measured;
  for (const Relation& relation : relations) {
    if (std::abs(relation.stamp2 - relation.stamp1) > kShortRelation) continue;
    const std::optional<Pose2> motion = mapped.between(relation.stamp1, relation.stamp2),
                               wheels = measured.between(relation.stamp1, relation.stamp2);
    if (!motion || !wheels || wheels->distance() < kMoved) continue;
    const auto difference = [](const Pose2& a, const Pose2& b) {
      return (a.translation() - b.translation()).squaredNorm();
    };
    relation_mapped.push_back(difference(relation.pose, *motion));
    relation_measured.push_back(difference(relation.pose, *wheels));
    mapped_measured.push_back(difference(*motion, *wheels));
  }
  const double rm = statisticsOf(relation_mapped).median / kMedianOfTwo,
               rw = statisticsOf(relation_measured).median / kMedianOfTwo,
               mw = statisticsOf(mapped_measured).median / kMedianOfTwo;
  const auto sigma = [](double twice) { return std::sqrt(std::max(0.0, 0.5 * twice)); };
  return {relation_mapped.size(), sigma(rm + rw - mw), sigma(rm + mw - rw), sigma(rw + mw - rm)};
}

ReferenceEvaluation evaluateReference(const Trajectory& trajectory, const Trajectory& reference) {
  ReferenceEvaluation result;
  match(trajectory, reference, result);
  result.reference_T_map = alignPoints(positionsOf(result.aligned), positionsOf(result.reference));
  for (std::size_t i = 0; i < result.aligned.size(); ++i) {
    StampedPose& entry = result.aligned[i];
    entry.pose = result.reference_T_map * entry.pose;
    result.ate.push_back(errorOf(entry.stamp, result.reference[i].pose, entry.pose));
  }
  result.ate_statistics = statisticsOf(result.ate);
  result.rpe_per_meter = relativeErrors(result, distancesAlong(result.reference), kRpeDistance);
  result.rpe_per_second = relativeErrors(result, stampsOf(result.aligned), kRpeDuration);
  return result;
}

double pathLength(const Trajectory& trajectory) {
  const std::vector<double> distances = distancesAlong(trajectory);
  return distances.empty() ? 0.0 : distances.back();
}

}  // namespace kestrel
