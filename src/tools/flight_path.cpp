#include "kestrel_slam/tools/flight_path.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel_slam {
namespace {

constexpr double kHoverTime = 1.0;       // s, before and after
constexpr double kRampTime = 2.0;        // s, from hover to full speed and back
constexpr int kSamplesPerSegment = 256;  // of the table of arc lengths

/// Weights of four neighbouring control points at `u` in [0, 1] of their segment.
Eigen::Vector4d weights(double u) {
  const double u2 = u * u, u3 = u2 * u, v = 1.0 - u;
  return Eigen::Vector4d(v * v * v, 3.0 * u3 - 6.0 * u2 + 4.0, -3.0 * u3 + 3.0 * u2 + 3.0 * u + 1.0,
                         u3) /
         6.0;
}

Eigen::Vector4d weightDerivatives(double u) {
  const double u2 = u * u, v = 1.0 - u;
  return Eigen::Vector4d(-v * v, 3.0 * u2 - 4.0 * u, -3.0 * u2 + 2.0 * u + 1.0, u2) / 2.0;
}

Eigen::Vector2d combine(const std::vector<Eigen::Vector2d>& corners, double parameter,
                        Eigen::Vector4d (*weights_of)(double)) {
  const double segment = std::floor(parameter);
  const Eigen::Vector4d w = weights_of(parameter - segment);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    sum += w[static_cast<Eigen::Index>(i)] *
           corners[(static_cast<std::size_t>(segment) + i) % corners.size()];
  }
  return sum;
}

/// Distance covered `time` after a start from rest, with a speed that rises as half a cosine wave.
double rampDistance(double time, double speed) {
  const double t = std::clamp(time, 0.0, kRampTime);
  const double ramped = speed / 2.0 * (t - kRampTime / kPi * std::sin(kPi * t / kRampTime));
  return ramped + speed * std::max(0.0, time - kRampTime);
}

}  // namespace

FlightPath::FlightPath(const std::vector<Eigen::Vector2d>& corners, double speed_m_s)
    : corners_(corners), speed_m_s_(speed_m_s) {
  if (corners.size() < 3) throw std::invalid_argument("a flight needs at least three corners");
  if (!(speed_m_s > 0.0)) throw std::invalid_argument("the speed of a flight must be positive");
  const std::size_t samples = corners.size() * kSamplesPerSegment;
  arc_length_.reserve(samples + 1);
  arc_length_.push_back(0.0);
  Eigen::Vector2d last = combine(corners_, 0.0, weights);
  for (std::size_t i = 1; i <= samples; ++i) {
    const Eigen::Vector2d next =
        combine(corners_, static_cast<double>(i) / kSamplesPerSegment, weights);
    arc_length_.push_back(arc_length_.back() + (next - last).norm());
    last = next;
  }
}

double FlightPath::duration() const {
  // The two ramps cover together what full speed covers in the time of one.
  return 2.0 * kHoverTime + kRampTime + length() / speed_m_s_;
}

double FlightPath::travelledAt(double time) const {
  const double from_start = time - kHoverTime;
  const double from_end = duration() - kHoverTime - time;
  const double travelled = from_start < from_end ? rampDistance(from_start, speed_m_s_)
                                                 : length() - rampDistance(from_end, speed_m_s_);
  return std::clamp(travelled, 0.0, length());
}

double FlightPath::parameterAt(double travelled) const {
  const auto next = std::upper_bound(arc_length_.begin() + 1, arc_length_.end() - 1, travelled);
  const double before = *(next - 1);
  const double fraction = (travelled - before) / (*next - before);
  return (static_cast<double>(next - 1 - arc_length_.begin()) + fraction) / kSamplesPerSegment;
}

Pose2 FlightPath::at(double time) const {
  const double parameter = parameterAt(travelledAt(time));
  const Eigen::Vector2d position = combine(corners_, parameter, weights);
  const Eigen::Vector2d forward = combine(corners_, parameter, weightDerivatives);
  return {position.x(), position.y(), std::atan2(forward.y(), forward.x())};
}

}  // namespace kestrel_slam
