#include "kestrel_slam/sensor/level_surfaces.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel_slam {
namespace {

constexpr double kLookEvery = 0.09;  // s
constexpr double kMemory = 1.0;      // s, of lines
constexpr double kMoment = 0.3;      // s, for which a height over the base is remembered

constexpr double kMinTilt = degToRad(2.0);  // flatter, and floor and ceiling are too far away
constexpr std::size_t kOutliers = 2;        // stray returns beyond the surface
constexpr std::size_t kMinReturns = 10;     // of a line
constexpr float kHalfThickness = 0.04F;     // m

constexpr std::size_t kMinLines = 4;
constexpr double kMinTiltChange = degToRad(2.0);
constexpr double kMaxHeightChange = 0.1;  // m; a vehicle climbs a little meanwhile
constexpr double kMinRatio = 5.0;         // the distance changes that much more

}  // namespace

std::optional<LevelLine> outermostLine(std::vector<Eigen::Vector3f> returns,
                                       const Eigen::Quaterniond& stabilized_R_base, int sign) {
  const double tilt = tiltOf(stabilized_R_base);
  if (tilt < kMinTilt || returns.size() < kMinReturns + kOutliers) return std::nullopt;
  const auto up = static_cast<float>(sign);
  const auto outer = [up](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    return up * a.z() > up * b.z();
  };
  const auto edge = returns.begin() + kOutliers;
  std::nth_element(returns.begin(), edge, returns.end(), outer);
  const float level = edge->z() - up * kHalfThickness;

  // The base's z axis leans to where the sweep goes down.
  const Eigen::Vector3d axis = stabilized_R_base * Eigen::Vector3d::UnitZ();
  const Eigen::Vector2f outwards = -up * axis.head<2>().normalized().cast<float>();
  std::size_t count = 0;
  double height = 0.0, distance = 0.0;
  for (const Eigen::Vector3f& p : returns) {
    if (std::abs(p.z() - level) > kHalfThickness) continue;
    ++count;
    height += p.z();
    distance += p.head<2>().dot(outwards);
  }
  if (count < kMinReturns || height * sign <= 0.0) return std::nullopt;
  const auto n = static_cast<double>(count);
  return LevelLine{height / n, distance / n, tilt};
}

std::optional<double> LevelSurface::add(double time, const std::optional<LevelLine>& line) {
  const auto stale = [time](const Entry& entry) { return std::abs(time - entry.time) > kMemory; };
  entries_.erase(std::remove_if(entries_.begin(), entries_.end(), stale), entries_.end());
  if (!line) return std::nullopt;
  entries_.push_back({time, *line});
  if (entries_.size() < kMinLines) return std::nullopt;

  const auto extentOf = [this](double LevelLine::*member) {
    double min = entries_.front().line.*member, max = min;
    for (const Entry& entry : entries_) {
      min = std::min(min, entry.line.*member);
      max = std::max(max, entry.line.*member);
    }
    return max - min;
  };
  const double height_change = extentOf(&LevelLine::height_m);
  const bool is_level = extentOf(&LevelLine::tilt_rad) > kMinTiltChange &&
                        height_change < kMaxHeightChange &&
                        extentOf(&LevelLine::distance_m) > kMinRatio * height_change;
  return is_level ? std::optional(line->height_m) : std::nullopt;
}

bool LevelSurfaces::isDue(double time) const {
  return !last_look_ || std::abs(time - *last_look_) > kLookEvery;
}

void LevelSurfaces::observe(double time, const std::vector<Eigen::Vector3f>& returns,
                            const Eigen::Quaterniond& stabilized_R_base,
                            const std::optional<double>& height_m) {
  last_look_ = time;
  const auto floor = floor_.add(time, outermostLine(returns, stabilized_R_base, -1));
  if (floor) floor_over_base_ = Seen{time, *floor};
  const auto ceiling = ceiling_.add(time, outermostLine(returns, stabilized_R_base, +1));
  if (!ceiling) return;
  ceiling_over_base_ = Seen{time, *ceiling};
  const std::optional<double> height = height_m ? height_m : floorHeight(time);
  if (height) ceiling_over_floor_ = *height + *ceiling;
}

std::optional<double> LevelSurfaces::floorHeight(double time) const {
  if (!floor_over_base_ || std::abs(time - floor_over_base_->time) > kMoment) return std::nullopt;
  return -floor_over_base_->height_m;
}

std::optional<double> LevelSurfaces::ceilingHeight(double time,
                                                   const std::optional<double>& height_m) const {
  if (height_m && ceiling_over_floor_) return *ceiling_over_floor_ - *height_m;
  if (!ceiling_over_base_ || std::abs(time - ceiling_over_base_->time) > kMoment) {
    return std::nullopt;
  }
  return ceiling_over_base_->height_m;
}

}  // namespace kestrel_slam
