// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>

namespace kestrel {

/// Repairs time stamps: takes stamps in the order of the file and returns strictly increasing
/// times.
///
/// Good stamps are returned unchanged. After a stamp that goes back slightly (a late one), the
/// times of the next scans are evenly spaced and follow the stamps slowly. A stamp that jumps far
/// back or ahead is replaced by a typical step. If the next stamp confirms the jump (a bag that is
/// played again, a clock that was set), all later times are shifted, so that no gap remains.
/// Deterministic, one stamp at a time.
class MonotoneTime {
 public:
  /// `offset_s`: time minus stamp at the beginning.
  explicit MonotoneTime(double offset_s = 0.0) : offset_(offset_s) {}

  /// The repaired time of the next stamp, both in s.
  double repair(double stamp);
  /// Number of stamps so far that were changed.
  std::size_t repaired() const { return repaired_; }
  double offset() const { return offset_; }  ///< time minus stamp, s

 private:
  bool continues(double time) const;
  double follow(double time, bool late);
  double jump(double stamp);
  double advance(double step);
  void learnStep(double step);

  bool started_ = false;
  double last_time_ = 0.0;
  double last_stamped_time_ = 0.0;  ///< last stamp plus offset, s
  double offset_;                   ///< time minus stamp, s
  /// Offset after a jump that the next stamp may confirm, s.
  std::optional<double> pending_offset_;
  double typical_step_ = 0.1;
  int distrusted_ = 0;  ///< number of scans for which the stamps are only followed slowly
  std::size_t repaired_ = 0;
};

/// The time base of several sources (lasers). Each source has its own MonotoneTime, because the
/// stamps of one laser say nothing about those of another. Two lasers may have equal stamps, and
/// the scan of a slow laser arrives after newer scans of a fast one: this is no error of a stamp.
class TimeBase {
 public:
  /// The repaired time of the next stamp of `source`, both in s. It increases strictly for each
  /// source, but not over all sources.
  double repair(const std::string& source, double stamp);
  /// Number of stamps so far that were changed.
  std::size_t repaired() const;

 private:
  MonotoneTime& timeOf(const std::string& source);

  std::map<std::string, MonotoneTime> sources_;
  double offset_ = 0.0;  ///< of the source of the last stamp, s
};

}  // namespace kestrel
