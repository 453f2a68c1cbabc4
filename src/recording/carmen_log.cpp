// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/carmen_log.h"

#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

const std::string kFrontLaser = "FLASER";
const std::string kRobotLaser = "ROBOTLASER1";
const std::string kBrokenLine = "broken line";
// Number of fields from the laser pose to the end: two poses, stamp, host, stamp; ROBOTLASER1 has
// five more.
constexpr std::size_t kFrontTrailingFields = 9;
constexpr std::size_t kRobotTrailingFields = 14;
constexpr std::size_t kPoseNumbers = 6;

/// The last fields of a line. Does not parse the ranges, which is faster.
std::vector<std::string> lastFields(const std::string& line, std::size_t count) {
  std::size_t begin = line.find_last_not_of(" \t\r");
  for (std::size_t i = 0; i < count && begin != std::string::npos; ++i) {
    begin = line.find_last_of(" \t", begin);
    if (begin != std::string::npos) begin = line.find_last_not_of(" \t", begin);
  }
  std::istringstream tail(begin == std::string::npos ? std::string() : line.substr(begin + 1));
  std::vector<std::string> fields;
  for (std::string field; tail >> field;) fields.push_back(field);
  return fields;
}

/// Reads the poses of laser and robot at the end of a laser line; false if they are not readable.
bool trailingPoses(const std::string& line, std::size_t field_count, Pose2& odom_T_laser,
                   Pose2& odom_T_base) {
  const std::vector<std::string> fields = lastFields(line, field_count);
  if (fields.size() != field_count) return false;
  std::array<double, kPoseNumbers> v{};
  for (std::size_t i = 0; i < kPoseNumbers; ++i) {
    if (!parseFinite(fields[i], v[i])) return false;
  }
  odom_T_laser = Pose2(v[0], v[1], v[2]);
  odom_T_base = Pose2(v[3], v[4], v[5]);
  return true;
}

bool isCarmenName(const std::string& name) {
  static const std::set<std::string> kNames = {"FLASER", "RLASER",  "ODOM",    "PARAM",
                                               "SYNC",   "TRUEPOS", "NMEAGGA", "NMEARMC"};
  const auto startsWith = [&](const char* start) { return name.rfind(start, 0) == 0; };
  return kNames.count(name) > 0 || startsWith("ROBOTLASER") || startsWith("RAWLASER");
}

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// Rounds to the six decimals of the log, so that a laser at the center is exactly at 0.
Pose2 roundPose(const Pose2& pose) {
  constexpr double kDecimals = 1e6;
  const auto rounded = [](double v) { return std::round(v * kDecimals) / kDecimals + 0.0; };
  return {rounded(pose.x), rounded(pose.y), rounded(pose.yaw)};
}

Eigen::Isometry3d toIsometry(const Pose2& pose) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.translation() = Eigen::Vector3d(pose.x, pose.y, 0.0);
  result.linear() = Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return result;
}

}  // namespace

bool looksLikeCarmenLog(const std::string& path) {
  const std::string head = readHead(path);
  if (head.find('\0') != std::string::npos) return false;
  std::istringstream lines(head);
  for (std::string line; std::getline(lines, line);) {
    if (isCarmenName(carmenMessageName(line))) return true;
  }
  return false;
}

/// Results of the first pass.
struct CarmenLog::Survey {
  std::map<std::string, std::size_t> counts;  ///< messages by name
  std::optional<Pose2> base_T_laser;          ///< from the first valid laser line
  bool constant = true;                       ///< all other lines give the same
};

CarmenLog::CarmenLog(const std::string& path) : path_(path) {
  survey();
  stream_ = openText(path_);
}

void CarmenLog::survey() {
  Survey survey;
  const std::unique_ptr<std::istream> stream = openText(path_);
  for (std::string line; readLine(*stream, line);) {
    const std::string name = carmenMessageName(line);
    if (!isCarmenName(name)) continue;
    ++survey.counts[name];
    if (name == "PARAM") surveyParameter(line);
    if (name == kFrontLaser || name == kRobotLaser) surveyMounting(line, survey);
  }
  laser_message_ = survey.counts.count(kFrontLaser) > 0 ? kFrontLaser : kRobotLaser;
  scan_count_ = survey.counts[laser_message_];
  if (scan_count_ == 0) {
    throw std::runtime_error(path_ + ": this CARMEN log has no laser; use a log with FLASER or " +
                             "ROBOTLASER1 lines");
  }
  chooseMounting(survey);
}

void CarmenLog::surveyParameter(const std::string& line) {
  std::istringstream fields(line);
  std::string message, name, text;
  fields >> message >> name >> text;
  double value = 0.0;
  if (!parseFinite(text, value)) return;
  if (name == "robot_frontlaser_offset") offset_parameter_ = value;
  if (endsWith(name, "front_laser_max") && value > 0.0) no_return_m_ = value;
}

void CarmenLog::surveyMounting(const std::string& line, Survey& survey) {
  constexpr double kTolerance =
      0.002;  // m and rad; larger than rounding to six decimals, as fr079 needs
  const bool front = carmenMessageName(line) == kFrontLaser;
  Pose2 odom_T_laser, odom_T_base;
  if (!trailingPoses(line, front ? kFrontTrailingFields : kRobotTrailingFields, odom_T_laser,
                     odom_T_base)) {
    return;
  }
  has_odometry_ = has_odometry_ || !(odom_T_base == Pose2());
  const Pose2 base_T_laser = odom_T_base.inverse() * odom_T_laser;
  if (!survey.base_T_laser) survey.base_T_laser = base_T_laser;
  const Pose2 change = survey.base_T_laser->inverse() * base_T_laser;
  if (change.distance() > kTolerance || std::abs(change.yaw) > kTolerance) {
    survey.constant = false;
  }
}

void CarmenLog::chooseMounting(const Survey& survey) {
  if (offset_parameter_) {
    base_T_laser_ = Pose2(*offset_parameter_, 0.0, 0.0);
  } else if (survey.base_T_laser && survey.constant) {
    base_T_laser_ = roundPose(*survey.base_T_laser);
  } else if (survey.base_T_laser) {
    warnings_.push_back(
        "the log does not give the mounting of the laser (it has no PARAM robot_frontlaser_offset, "
        "and the laser pose is not constant in the robot frame): the laser is assumed to be at "
        "the center of the robot");
  }
}

bool CarmenLog::nextLaserLine(std::string& line) {
  while (readLine(*stream_, line)) {
    ++line_number_;
    if (carmenMessageName(line) == laser_message_) return true;
  }
  return false;
}

bool CarmenLog::next(RecordedScan& scan) {
  std::string line;
  while (nextLaserLine(line)) {
    try {
      fill(parseCarmenScan(line, no_return_m_), scan);
      return true;
    } catch (const std::invalid_argument& error) {
      skipBrokenLine(error.what());
    }
  }
  reportEnd();
  return false;
}

void CarmenLog::fill(const CarmenScan& source, RecordedScan& scan) {
  if (!source.known_fan) warnAboutFan(source.scan.ranges.size());
  scan.scan = source.scan;
  scan.time = monotone_time_.repair(source.scan.stamp);
  scan.base_T_laser = toIsometry(base_T_laser_);
  scan.odom_T_base.reset();
  if (has_odometry_) scan.odom_T_base = source.odom_T_base;
}

void CarmenLog::skipBrokenLine(const std::string& reason) {
  if (++skipped_[kBrokenLine] > 1) return;
  warnings_.push_back("line " + std::to_string(line_number_) + ": broken " + laser_message_ +
                      " line skipped: " + reason);
}

void CarmenLog::warnAboutFan(std::size_t beams) {
  if (!unknown_fans_.insert(beams).second) return;
  warnings_.push_back("line " + std::to_string(line_number_) + ": FLASER with " +
                      std::to_string(beams) +
                      " beams does not give its field of view: 180 degrees are assumed");
}

void CarmenLog::reportEnd() {
  if (at_end_) return;
  at_end_ = true;
  if (stream_->bad()) {
    warnings_.push_back(cutOffText(line_number_));
  }
}

std::string CarmenLog::description() const {
  std::ostringstream text;
  text << "CARMEN log, " << scan_count_ << ' ' << laser_message_ << " scans, laser at x "
       << base_T_laser_.x << " m, y " << base_T_laser_.y << " m, "
       << (has_odometry_ ? "with" : "without") << " odometry";
  return text.str();
}

}  // namespace kestrel
