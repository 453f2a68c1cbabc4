// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/carmen_line.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <vector>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kMaxBeams = 1e7;
constexpr double kFrontFanDeg = 180.0;

/// Walks through the blank-separated fields of a line.
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
      throw std::invalid_argument(std::string(what) + " is not a sensible count");
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
    return *position_ == '\0' ? "ends before the " + std::string(what)
                              : std::string(what) + " is not a number";
  }

  const char* position_;
};

/// The angles of a SICK LMS, which a FLASER line does not say.
///
/// 360 beams start at -90 degrees and lack the last one, they are not centerd (-89.75): with this
/// start, matched scans of fr079 on straight stretches move in the same direction as its relations
/// do (0.33 +- 0.02 and 0.31 degrees left of forward; centerd it would be 0.58). The wheels alone
/// cannot tell: lasers with known fans are mounted up to a degree off.
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

/// Volatile, because GCC 12 folds two neighboring conversions double -> float -> double to
/// nothing.
double roundToFloat(double value) {
  const volatile float rounded = static_cast<float>(value);
  return rounded;
}

/// The angles of a LaserScan message are floats: log and converted bag shall agree to the bit.
void roundAngles(LaserScan& scan) {
  scan.angle_min = roundToFloat(scan.angle_min);
  scan.angle_increment = roundToFloat(scan.angle_increment);
}

void readRanges(Fields& fields, std::size_t beams, double no_return_m, LaserScan& scan) {
  for (std::size_t i = 0; i < beams; ++i) {
    const double range = fields.number("ranges");
    scan.ranges.push_back(range >= no_return_m ? std::numeric_limits<float>::infinity()
                                               : static_cast<float>(range));
  }
  scan.range_max = roundToFloat(no_return_m);
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
