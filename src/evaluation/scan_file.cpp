// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/scan_file.h"

#include <iomanip>
#include <map>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

constexpr const char* kColumns =
    "stamp,x,y,yaw,state,score,known,constraint,degenerate_x,degenerate_y,sigma_x,sigma_y,"
    "sigma_yaw,inserted,searched,carried,ambiguous,odom_x,odom_y,odom_yaw,reason";
constexpr int kScanStampDecimals = 6, kPoseDecimals = 6, kScanDigits = 6;

std::string poseText(const std::optional<Pose2>& pose) {
  if (!pose) return ",,";
  std::ostringstream out;
  out << std::fixed << std::setprecision(kPoseDecimals) << pose->x << ',' << pose->y << ','
      << pose->yaw;
  return out.str();
}

void write(std::ostream& out, const ScanRow& scan) {
  out << std::fixed << std::setprecision(kScanStampDecimals) << scan.stamp << std::defaultfloat
      << std::setprecision(kScanDigits) << ',' << poseText(scan.pose) << ',' << toString(scan.state)
      << ',' << scan.score << ',' << scan.known << ',' << scan.constraint << ',';
  const Eigen::Vector2d& direction = scan.degenerate_direction;
  if (direction.isZero()) {
    out << ',';
  } else {
    out << direction.x() << ',' << direction.y();
  }
  out << ',' << scan.sigmas.x() << ',' << scan.sigmas.y() << ',' << scan.sigmas.z() << ','
      << scan.inserted << ',' << scan.searched << ',' << scan.carried << ',' << scan.ambiguous
      << ',' << poseText(scan.odom_T_base) << ',' << scan.reason << '\n';
}

std::vector<std::string> fieldsOf(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line + ",");
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

/// The fields of one line by the names of their columns.
class Line {
 public:
  Line(const std::vector<std::string>& columns, const std::string& line) {
    const std::vector<std::string> fields = fieldsOf(line);
    if (fields.size() != columns.size()) {
      throw std::runtime_error("expected " + std::to_string(columns.size()) + " fields, found " +
                               std::to_string(fields.size()));
    }
    for (std::size_t i = 0; i < fields.size(); ++i) fields_[columns[i]] = fields[i];
  }

  bool has(const std::string& column) const { return fields_.count(column) > 0; }

  const std::string& text(const std::string& column) const {
    const auto found = fields_.find(column);
    if (found == fields_.end()) throw std::runtime_error("there is no column '" + column + "'");
    return found->second;
  }

  double number(const std::string& column) const {
    double value = 0.0;
    if (parseFinite(text(column), value)) return value;
    throw std::runtime_error("'" + text(column) + "' in column '" + column +
                             "' is not a finite number");
  }

  bool flag(const std::string& column) const { return number(column) != 0.0; }

  std::optional<Pose2> pose(const std::string& prefix) const {
    if (text(prefix + "x").empty()) return std::nullopt;
    return Pose2(number(prefix + "x"), number(prefix + "y"), number(prefix + "yaw"));
  }

  MatchState state() const {
    for (const MatchState state : {MatchState::kOk, MatchState::kDegraded, MatchState::kLost}) {
      if (text("state") == toString(state)) return state;
    }
    throw std::runtime_error("'" + text("state") + "' is no state");
  }

 private:
  std::map<std::string, std::string> fields_;
};

ScanRow parse(const Line& line) {
  ScanRow scan;
  scan.stamp = line.number("stamp");
  scan.pose = Pose2(line.number("x"), line.number("y"), line.number("yaw"));
  scan.state = line.state();
  scan.score = line.number("score");
  scan.known = line.number("known");
  scan.constraint = line.number("constraint");
  if (!line.text("degenerate_x").empty()) {
    scan.degenerate_direction = {line.number("degenerate_x"), line.number("degenerate_y")};
  }
  scan.sigmas = {line.number("sigma_x"), line.number("sigma_y"), line.number("sigma_yaw")};
  scan.inserted = line.flag("inserted");
  scan.searched = line.flag("searched");
  scan.carried = line.flag("carried");
  scan.ambiguous = line.flag("ambiguous");
  scan.odom_T_base = line.pose("odom_");
  if (line.has("reason")) scan.reason = line.text("reason");
  return scan;
}

/// Index of the base pose for the motion of scan `i` (see StateEvaluation), if there is one.
std::optional<std::size_t> baseOf(const std::vector<ScanRow>& scans, std::size_t i) {
  for (std::size_t back = kMotionScans; back <= i; ++back) {
    if (scans[i - back].state != MatchState::kLost) return i - back;
  }
  return std::nullopt;
}

/// `reference[i]` belongs to `scans[i]`.
std::size_t countWrongAndOk(const std::vector<ScanRow>& scans, const Trajectory& reference) {
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const std::optional<std::size_t> base = baseOf(scans, i);
    if (scans[i].state != MatchState::kOk || !base) continue;
    const Pose2 found = scans[*base].pose.between(scans[i].pose);
    const Pose2 expected = reference[*base].pose.between(reference[i].pose);
    if (expected.between(found).distance() > kWrongMotion) ++wrong;
  }
  return wrong;
}

Trajectory odometryOf(const std::vector<ScanRow>& scans) {
  Trajectory result;
  for (const ScanRow& scan : scans) {
    if (scan.odom_T_base) result.push_back({scan.stamp, *scan.odom_T_base});
  }
  return result;
}

}  // namespace

std::string scansText(const std::vector<ScanRow>& scans) {
  std::ostringstream out;
  out << kColumns << '\n';
  for (const ScanRow& scan : scans) write(out, scan);
  return out.str();
}

std::vector<ScanRow> readScans(const std::string& path) {
  const std::unique_ptr<std::istream> stream = openText(path);
  std::string line;
  std::getline(*stream, line);
  const std::vector<std::string> columns = fieldsOf(line);
  std::vector<ScanRow> scans;
  for (std::size_t number = 2; std::getline(*stream, line); ++number) {
    try {
      scans.push_back(parse(Line(columns, line)));
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(path + ", line " + std::to_string(number) + ": " + error.what() +
                               "; use the scans.csv of map_recording");
    }
  }
  return scans;
}

StateEvaluation evaluateStates(const std::vector<ScanRow>& scans, const Trajectory& reference) {
  StateEvaluation result;
  std::vector<ScanRow> matched;
  Trajectory trajectory;
  for (const ScanRow& scan : scans) {
    result.ok += scan.state == MatchState::kOk ? 1U : 0U;
    result.degraded += scan.state == MatchState::kDegraded ? 1U : 0U;
    result.lost += scan.state == MatchState::kLost ? 1U : 0U;
    trajectory.push_back({scan.stamp, scan.pose});
  }
  const ReferenceEvaluation poses = evaluateReference(trajectory, reference);
  result.ate = poses.ate_statistics;
  // `aligned` has the scans with a reference, in the same order.
  std::size_t next = 0;
  for (const ScanRow& scan : scans) {
    if (next == poses.aligned.size() || poses.aligned[next].stamp != scan.stamp) continue;
    matched.push_back(scan);
    ++next;
  }
  result.wrong_and_ok = countWrongAndOk(matched, poses.reference);
  const Trajectory odometry = odometryOf(scans);
  if (!odometry.empty()) {
    result.odometry_ate = evaluateReference(odometry, reference).ate_statistics;
  }
  return result;
}

}  // namespace kestrel
