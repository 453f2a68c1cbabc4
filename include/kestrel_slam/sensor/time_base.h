// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

namespace kestrel {

/// Repairs a time base: stamps in the order of the file in, strictly monotone times out.
///
/// Good stamps are returned unchanged. After a stamp that jumps back a little (it is late), stamps
/// are distrusted for a while: time goes on evenly and follows them slowly. A stamp that jumps far
/// back or an hour ahead goes on by a typical step; where the next one confirms the jump (a bag
/// that loops, a clock that was set), all times from there on are shifted so that no gap is left.
/// Deterministic, one stamp at a time.
class MonotoneTime {
 public:
  /// The repaired time of the next stamp, s.
  double repair(double stamp);
  /// Stamps so far that were not taken over as they are.
  std::size_t repaired() const { return repaired_; }

 private:
  bool continues(double time) const;
  double follow(double time, bool late);
  double jump(double stamp);
  double advance(double step);
  void learnStep(double step);

  bool started_ = false;
  double last_time_ = 0.0;
  double last_stamped_time_ = 0.0;        ///< what the last good stamp alone would give, s
  double offset_ = 0.0;                   ///< time minus stamp, s
  std::optional<double> pending_offset_;  ///< of a jump that the next stamp may confirm
  double typical_step_ = 0.1;
  int distrusted_ = 0;  ///< scans for which stamps are still only followed slowly
  std::size_t repaired_ = 0;
};

}  // namespace kestrel
