// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/carmen_log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "affixes.h"
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
constexpr std::size_t kPoseColumns = 6;
constexpr std::size_t kMaxNameLength = 20;  // of an unknown message, for the warning

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

/// The end of a laser line.
struct LineEnd {
  Pose2 odom_T_laser, odom_T_base;
  double clock_offset = 0.0;  ///< between its two stamps, s
};

/// False if a field is not readable.
bool parseEnd(const std::string& line, std::size_t field_count, LineEnd& end) {
  const std::vector<std::string> fields = lastFields(line, field_count);
  if (fields.size() != field_count) return false;
  std::array<double, kPoseColumns> v{};
  for (std::size_t i = 0; i < kPoseColumns; ++i) {
    if (!parseFinite(fields[i], v[i])) return false;
  }
  double stamp = 0.0, logged = 0.0;
  if (!parseFinite(fields[field_count - 3], stamp) || !parseFinite(fields.back(), logged)) {
    return false;
  }
  end = {Pose2(v[0], v[1], v[2]), Pose2(v[3], v[4], v[5]), stamp - logged};
  return true;
}

bool isSameMounting(const Pose2& a, const Pose2& b) {
  constexpr double kTolerance =
      0.002;  // m and rad; larger than rounding to six decimals, as fr079 needs
  const Pose2 change = a.inverse() * b;
  return change.distance() <= kTolerance && std::abs(change.yaw) <= kTolerance;
}

/// The fields before the ranges of a ROBOTLASER1 line: type, angles, limits and number of beams.
std::string geometryOf(const std::string& line) {
  constexpr int kFields = 9;
  std::size_t end = 0;
  for (int i = 0; i < kFields && end != std::string::npos; ++i) end = line.find(' ', end + 1);
  return line.substr(0, end);
}

/// Lines whose two stamps differ in another way than in the lines before and after.
std::size_t countWrongStamps(const std::vector<double>& offsets) {
  constexpr double kJump = 0.9, kSame = 0.1;  // s; some logs are written in bursts
  std::size_t count = 0;
  for (std::size_t i = 1; i + 1 < offsets.size(); ++i) {
    if (std::abs(offsets[i + 1] - offsets[i - 1]) < kSame &&
        std::abs(offsets[i] - offsets[i - 1]) > kJump) {
      ++count;
    }
  }
  return count;
}

bool isCarmenName(const std::string& name) {
  static const std::set<std::string> kNames = {"FLASER", "RLASER",  "ODOM",    "PARAM",
                                               "SYNC",   "TRUEPOS", "NMEAGGA", "NMEARMC"};
  const auto startsWith = [&](const char* start) { return name.rfind(start, 0) == 0; };
  return kNames.count(name) > 0 || startsWith("ROBOTLASER") || startsWith("RAWLASER");
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
  std::map<std::string, std::size_t> counts;   ///< messages by name
  std::map<std::string, std::size_t> unknown;  ///< the same, of names that CARMEN does not have
  std::vector<std::pair<Pose2, std::size_t>> mountings;  ///< base_T_laser with number of lines
  std::size_t poses = 0;                                 ///< lines with readable poses
  std::vector<double> clock_offsets;                     ///< s

  void addMounting(const Pose2& base_T_laser) {
    constexpr std::size_t kMaxMountings = 20;
    ++poses;
    for (auto& [mounting, count] : mountings) {
      if (isSameMounting(mounting, base_T_laser)) {
        ++count;
        return;
      }
    }
    if (mountings.size() < kMaxMountings) mountings.emplace_back(base_T_laser, 1);
  }

  /// The mounting of nearly all lines. The others have a damaged digit.
  std::optional<Pose2> mounting() const {
    for (const auto& [mounting, count] : mountings) {
      if (10 * count >= 9 * poses) return mounting;
    }
    return std::nullopt;
  }
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
    if (!isCarmenName(name)) {
      const bool is_text = line[0] == '#' || line.find_first_not_of(" \t\r") == std::string::npos;
      if (!is_text) ++survey.unknown[name.substr(0, kMaxNameLength)];
      continue;
    }
    ++survey.counts[name];
    if (name == "PARAM") surveyParameter(line);
    if (name == kFrontLaser || name == kRobotLaser) surveyLaser(line, survey);
    const bool swallows = line.find("LASER", name.size()) != std::string::npos;
    if (swallows) ++survey.unknown[name];  // a damaged end of line
  }
  laser_message_ = survey.counts.count(kFrontLaser) > 0 ? kFrontLaser : kRobotLaser;
  scan_count_ = survey.counts[laser_message_];
  if (scan_count_ == 0) {
    throw std::runtime_error(path_ + ": this CARMEN log has no laser; use a log with FLASER or " +
                             "ROBOTLASER1 lines");
  }
  chooseMounting(survey);
  reportDamage(survey);
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

void CarmenLog::surveyLaser(const std::string& line, Survey& survey) {
  const bool front = carmenMessageName(line) == kFrontLaser;
  if (!front) ++geometries_[geometryOf(line)];
  LineEnd end;
  if (!parseEnd(line, front ? kFrontTrailingFields : kRobotTrailingFields, end)) return;
  has_odometry_ = has_odometry_ || !(end.odom_T_base == Pose2());
  survey.addMounting(end.odom_T_base.inverse() * end.odom_T_laser);
  survey.clock_offsets.push_back(end.clock_offset);
}

void CarmenLog::chooseMounting(const Survey& survey) {
  logged_mounting_ = survey.mounting();
  if (offset_parameter_) {
    base_T_laser_ = Pose2(*offset_parameter_, 0.0, 0.0);
  } else if (logged_mounting_) {
    base_T_laser_ = roundPose(*logged_mounting_);
  } else if (survey.poses > 0) {
    warnings_.push_back(
        "the log does not give the mounting of the laser (it has no PARAM robot_frontlaser_offset, "
        "and the laser pose is not constant in the robot frame): the laser is assumed to be at "
        "the center of the robot");
  }
}

/// A plain log has no checksums, but some of its fields contradict each other if one is damaged.
void CarmenLog::reportDamage(const Survey& survey) {
  std::size_t unknown = 0, wrong_poses = survey.poses;
  std::map<std::string, std::size_t> names = survey.unknown;
  for (const auto& [name, count] : survey.counts) {
    const bool is_laser = name.find("LASER") != std::string::npos && name != laser_message_;
    if (is_laser && count == 1 && scan_count_ > 1) names[name] = 1;  // a damaged digit
  }
  for (const auto& [name, count] : names) unknown += count;
  if (unknown > 0) {
    warnings_.push_back(std::to_string(unknown) +
                        " lines with damaged message names or ends skipped, " + "among them '" +
                        names.begin()->first + "'");
  }
  for (const auto& [mounting, count] : survey.mountings) {
    if (logged_mounting_ && mounting == *logged_mounting_) wrong_poses -= count;
  }
  if (logged_mounting_ && wrong_poses > 0) {
    warnings_.push_back("in " + std::to_string(wrong_poses) + " of " +
                        std::to_string(survey.poses) + " lines the poses of laser and robot " +
                        "contradict the mounting (damaged?): their odometry is not used");
  }
  const std::size_t wrong_stamps = countWrongStamps(survey.clock_offsets);
  if (wrong_stamps > 0) {
    warnings_.push_back("in " + std::to_string(wrong_stamps) +
                        " lines the stamps of IPC and logger contradict each other (damaged?)");
  }
}

/// True if nearly all lines have another geometry and no second line has this one.
bool CarmenLog::hasDamagedGeometry(const std::string& line) const {
  const auto geometry = geometries_.find(geometryOf(line));
  if (geometry == geometries_.end() || geometry->second > 1) return false;
  return std::any_of(geometries_.begin(), geometries_.end(), [this](const auto& entry) {
    return entry.second > 1 && 10 * entry.second >= 9 * scan_count_;
  });
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
      const CarmenScan source = parseCarmenScan(line, no_return_m_);
      if (hasDamagedGeometry(line)) throw std::invalid_argument("no other line has these angles");
      fill(source, scan);
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
  const bool contradicts =
      logged_mounting_ &&
      !isSameMounting(*logged_mounting_, source.odom_T_base.inverse() * source.odom_T_laser);
  if (has_odometry_ && !contradicts) scan.odom_T_base = source.odom_T_base;
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
