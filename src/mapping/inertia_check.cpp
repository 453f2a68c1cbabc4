// SPDX-License-Identifier: BSD-3-Clause
#include "inertia_check.h"

#include <algorithm>

namespace kestrel {
namespace {

constexpr double kNoiseM = 0.02;  ///< of a match
constexpr double kSigmas = 3.0;
constexpr double kGain = 0.05;  ///< of the usual distance, for each scan

}  // namespace

bool InertiaCheck::isMeasured(const MotionModel& motion, const PlanarScan& scan) {
  return motion.predictionSourceOf(scan, {}) == PredictionSource::kAccelerometer;
}

std::optional<Eigen::Vector2d> InertiaCheck::contradiction(const PlanarScan& scan,
                                                           const Pose2& matched) const {
  if (!alone_ || !isMeasured(*alone_, scan)) return std::nullopt;
  const Eigen::Vector2d away = alone_->predict(scan, {}).translation() - matched.translation();
  const double sigma = std::max(alone_->errorAt(scan, {}).position_m(), scans_ * usual_m_);
  return away.norm() > kNoiseM + kSigmas * sigma ? std::optional(away) : std::nullopt;
}

void InertiaCheck::learn(const MotionModel& motion, const PlanarScan& scan, const Pose2& matched) {
  if (!isMeasured(motion, scan)) return;
  const double away = (motion.predict(scan, {}).translation() - matched.translation()).norm();
  usual_m_ += kGain * (std::min(away, kNoiseM + kSigmas * usual_m_) - usual_m_);
}

void InertiaCheck::follow(const MotionModel& motion) {
  alone_ = motion;
  scans_ = 1.0;
}

void InertiaCheck::goOn(const PlanarScan& scan) {
  const PredictionError error = alone_->errorAt(scan, {});
  alone_->carry(scan, {});
  alone_->remember(scan, {}, error);
  scans_ += 1.0;
}

}  // namespace kestrel
