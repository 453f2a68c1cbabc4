// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/carmen_line.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kMaxBeams = 1e7;
constexpr double kFrontFanDeg = 180.0;

/// Parses the blank-separated fields of a line one by one.
class Fields {
 public:
  explicit Fields(const std::string& line) : position_(line.c_str()) { word("message name"); }

  double number(const char* what) {
    char* end = nullptr;
    const double value = std::strtod(position_, &end);
    if (end == position_) throw std::invalid_argument(missing(what));
    if (!std::isfinite(value) || !atBlank(end)) {
      throw std::invalid_argument(std::string(what) + " is not a finite number");
    }
    position_ = end;
    return value;
  }

  std::size_t count(const char* what) {
    const double value = number(what);
    if (value < 0.0 || value > kMaxBeams || value != std::floor(value)) {
      throw std::invalid_argument(std::string(what) + " is not a valid count");
    }
    return static_cast<std::size_t>(value);
  }

  Pose2 pose(const char* what) {
    const double x = number(what), y = number(what), yaw = number(what);
    return {x, y, yaw};
  }

  void skipNumbers(std::size_t count, const char* what) {
    for (std::size_t i = 0; i < count; ++i) number(what);
  }

  void word(const char* what) {
    skipBlanks();
    if (*position_ == '\0') throw std::invalid_argument(missing(what));
    while (!atBlank(position_)) ++position_;
  }

  void end() {
    skipBlanks();
    if (*position_ != '\0') throw std::invalid_argument("more fields than the format has");
  }

 private:
  static bool atBlank(const char* p) {
    return *p == '\0' || std::isspace(static_cast<unsigned char>(*p)) != 0;
  }
  void skipBlanks() {
    while (*position_ != '\0' && atBlank(position_)) ++position_;
  }
  std::string missing(const char* what) {
    skipBlanks();
    return *position_ == '\0' ? "the line ends before the " + std::string(what)
                              : std::string(what) + " is not a number";
  }

  const char* position_;
};

/// Sets the angles of a SICK LMS, because a FLASER line does not contain them.
///
/// 360 beams start at -90 degrees and omit the beam at +90 degrees. They are not centered (start at
/// -89.75 degrees). This was checked with fr079 on straight drives: matched scans and the relations
/// of the data set then agree on the driving direction in the laser frame. Odometry cannot decide
/// this, because lasers are mounted with yaw errors of up to a degree.
void setFrontFan(CarmenScan& result, std::size_t beams) {
  double step_deg = 0.0;
  if (beams == 180 || beams == 181) {
    step_deg = 1.0;
  } else if (beams == 360 || beams == 361) {
    step_deg = 0.5;
  } else {
    step_deg = beams > 1 ? kFrontFanDeg / static_cast<double>(beams - 1) : kFrontFanDeg;
    result.known_fan = false;
  }
  result.scan.angle_min = degToRad(-kFrontFanDeg / 2.0);
  result.scan.angle_increment = degToRad(step_deg);
}

/// Uses volatile because GCC 12 removes the conversion double -> float -> double.
double roundToFloat(double value) {
  const volatile float rounded = static_cast<float>(value);
  return rounded;
}

/// Rounds the angles to float, as in a LaserScan message, so that a log and a bag that was
/// converted from it give identical scans.
void roundAngles(LaserScan& scan) {
  scan.angle_min = roundToFloat(scan.angle_min);
  scan.angle_increment = roundToFloat(scan.angle_increment);
}

void readRanges(Fields& fields, std::size_t beams, double no_return_m, LaserScan& scan) {
  std::vector<float> recorded;
  scan.range_max = roundToFloat(no_return_m);
  for (std::size_t i = 0; i < beams; ++i) {
    const double range = fields.number("ranges");
    recorded.push_back(static_cast<float>(range));
    scan.ranges.push_back(range >= no_return_m ? std::numeric_limits<float>::infinity()
                                               : static_cast<float>(range));
  }
  // If no beam has a return although they differ, the projector finds whether they are millimeters.
  const auto is_return = [](float range) { return std::isfinite(range); };
  const bool differ =
      std::adjacent_find(recorded.begin(), recorded.end(), std::not_equal_to<>()) != recorded.end();
  if (!differ || std::any_of(scan.ranges.begin(), scan.ranges.end(), is_return)) return;
  std::copy(recorded.begin(), recorded.end(), scan.ranges.begin());
}

void readStamp(Fields& fields, LaserScan& scan) {
  scan.stamp = fields.number("IPC stamp");
  fields.word("host name");
  fields.number("logger stamp");
  fields.end();
  roundAngles(scan);
}

// FLASER n r_1 ... r_n laser_pose robot_pose ipc_stamp host logger_stamp
CarmenScan parseFrontLaser(Fields& fields, double no_return_m) {
  CarmenScan result;
  const std::size_t beams = fields.count("number of beams");
  setFrontFan(result, beams);
  readRanges(fields, beams, no_return_m, result.scan);
  result.odom_T_laser = fields.pose("laser pose");
  result.odom_T_base = fields.pose("robot pose");
  readStamp(fields, result.scan);
  return result;
}

// ROBOTLASER1 type start fov step max_range accuracy remission_mode n r_1 ... r_n m s_1 ... s_m
//   laser_pose robot_pose tv rv forward_safety side_safety turn_axis ipc_stamp host logger_stamp
CarmenScan parseRobotLaser(Fields& fields, double no_return_m) {
  constexpr std::size_t kSafetyFields = 5;
  CarmenScan result;
  fields.number("laser type");
  result.scan.angle_min = fields.number("start angle");
  fields.number("field of view");
  result.scan.angle_increment = fields.number("angular resolution");
  const double max_range = fields.number("maximum range");
  fields.skipNumbers(2, "accuracy and remission mode");
  const std::size_t beams = fields.count("number of beams");
  readRanges(fields, beams, max_range > 0.0 ? std::min(max_range, no_return_m) : no_return_m,
             result.scan);
  fields.skipNumbers(fields.count("number of remissions"), "remissions");
  result.odom_T_laser = fields.pose("laser pose");
  result.odom_T_base = fields.pose("robot pose");
  fields.skipNumbers(kSafetyFields, "velocities and safety distances");
  readStamp(fields, result.scan);
  return result;
}

}  // namespace

std::string carmenMessageName(const std::string& line) {
  return line.substr(0, line.find_first_of(" \t\r"));
}

CarmenScan parseCarmenScan(const std::string& line, double no_return_m) {
  Fields fields(line);
  return carmenMessageName(line) == "FLASER" ? parseFrontLaser(fields, no_return_m)
                                             : parseRobotLaser(fields, no_return_m);
}

}  // namespace kestrel
