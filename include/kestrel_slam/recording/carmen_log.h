// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <istream>
#include <memory>
#include <set>
#include <string>

#include "kestrel_slam/recording/carmen_line.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/sensor/time_base.h"

namespace kestrel {

/// Reads a CARMEN log: plain text, .bz2 or .gz. Uses the FLASER lines; if there are none, the
/// ROBOTLASER1 lines. Scans are read in the order of the file, which is the true order even if
/// stamps jump back.
///
/// A first fast pass counts the scans and finds the mounting of the laser.
class CarmenLog : public Recording {
 public:
  /// Throws std::runtime_error if `path` cannot be read, is not a CARMEN log or has no laser.
  explicit CarmenLog(const std::string& path);

  bool next(RecordedScan& scan) override;
  std::size_t scanCount() const override { return scan_count_; }
  std::string description() const override;
  bool hasOdometry() const override { return has_odometry_; }

 private:
  struct Survey;

  void survey();
  void surveyParameter(const std::string& line);
  void surveyLaser(const std::string& line, Survey& survey);
  void chooseMounting(const Survey& survey);
  void reportDamage(const Survey& survey);
  bool hasDamagedGeometry(const std::string& line) const;
  bool nextLaserLine(std::string& line);
  void fill(const CarmenScan& source, RecordedScan& scan);
  void skipBrokenLine(const std::string& reason);
  void warnAboutFan(std::size_t beams);
  void reportEnd();

  std::string path_;
  std::unique_ptr<std::istream> stream_;
  std::size_t line_number_ = 0;
  std::string laser_message_;  ///< FLASER or ROBOTLASER1
  std::size_t scan_count_ = 0;
  bool has_odometry_ = false;
  double no_return_m_ = kCarmenDefaultMaxRange;
  std::optional<double> offset_parameter_;         ///< robot_frontlaser_offset, m
  std::optional<Pose2> logged_mounting_;           ///< as the poses of nearly all lines say
  std::map<std::string, std::size_t> geometries_;  ///< of ROBOTLASER1 lines, with their number
  Pose2 base_T_laser_;
  bool at_end_ = false;
  std::set<std::size_t> unknown_fans_;  ///< numbers of beams already warned about
  MonotoneTime monotone_time_;
};

/// True if the beginning of the (decompressed) file looks like a CARMEN log.
bool looksLikeCarmenLog(const std::string& path);

}  // namespace kestrel
