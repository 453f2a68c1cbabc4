// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

constexpr std::size_t kTumFields = 8;
using TumRow = std::array<double, kTumFields>;

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  const int length = std::snprintf(nullptr, 0, pattern, values...);
  std::string text(static_cast<std::size_t>(length) + 1, '\0');
  std::snprintf(text.data(), text.size(), pattern, values...);
  text.pop_back();
  return text;
}

/// The shortest text, with at least six decimals, that gives the same double when it is read.
std::string stampText(double stamp) {
  for (const int decimals : {6, 9, 12}) {
    const std::string text = format("%.*f", decimals, stamp);
    if (std::strtod(text.c_str(), nullptr) == stamp) return text;
  }
  return format("%.17g", stamp);
}

[[noreturn]] void failAt(const std::string& path, std::size_t line, const std::string& problem) {
  throw std::runtime_error(path + ", line " + std::to_string(line) + ": " + problem);
}

TumRow parseRow(const std::string& path, std::size_t line_number, const std::string& line) {
  std::istringstream fields(line);
  TumRow row{};
  std::size_t count = 0;
  for (std::string field; fields >> field; ++count) {
    if (count >= kTumFields) continue;
    if (!parseFinite(field, row[count])) {
      failAt(path, line_number, "'" + field + "' is not a finite number");
    }
  }
  if (count != kTumFields) {
    failAt(path, line_number,
           "expected 8 fields (stamp x y z qx qy qz qw), found " + std::to_string(count));
  }
  return row;
}

double yawOf(double qx, double qy, double qz, double qw) {
  return std::atan2(2.0 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz);
}

}  // namespace

std::optional<Pose2> poseAt(const Trajectory& trajectory, double stamp, double max_gap_s) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), stamp,
                       [](const StampedPose& pose, double t) { return pose.stamp < t; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->stamp == stamp) return after->pose;
  if (after == trajectory.begin()) return std::nullopt;
  const StampedPose &a = *std::prev(after), &b = *after;
  const double gap = b.stamp - a.stamp;
  if (gap > max_gap_s) return std::nullopt;
  return interpolate(a.pose, b.pose, (stamp - a.stamp) / gap);
}

std::string tumText(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& entry : trajectory) {
    const Pose2& pose = entry.pose;
    text += stampText(entry.stamp) + format(" %.6f %.6f 0 0 0 %.9f %.9f\n", pose.x, pose.y,
                                            std::sin(pose.yaw / 2.0), std::cos(pose.yaw / 2.0));
  }
  return text;
}

void writeTum(const std::string& path, const Trajectory& trajectory) {
  writeFileAtomically(path, tumText(trajectory));
}

Trajectory readTum(const std::string& path) {
  constexpr double kMinQuaternionNorm = 0.5;
  const std::unique_ptr<std::istream> stream = openText(path);
  Trajectory trajectory;
  std::size_t line_number = 0;
  for (std::string line; std::getline(*stream, line);) {
    ++line_number;
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos || line[begin] == '#') continue;
    const TumRow row = parseRow(path, line_number, line);
    const double qx = row[4], qy = row[5], qz = row[6], qw = row[7];
    if (std::hypot(std::hypot(qx, qy), std::hypot(qz, qw)) < kMinQuaternionNorm) {
      failAt(path, line_number, "the quaternion (fields 5 to 8) is not of unit length");
    }
    trajectory.push_back({row[0], Pose2(row[1], row[2], yawOf(qx, qy, qz, qw))});
  }
  if (trajectory.empty()) {
    throw std::runtime_error(path +
                             ": has no poses; use a trajectory in the TUM format, with a line "
                             "`stamp x y z qx qy qz qw` for each pose");
  }
  return trajectory;
}

}  // namespace kestrel
