// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <cstdint>
#include <optional>
#include <string>

namespace kestrel {

// ros::Time and ros::Duration throw if a result needs more than 32 bits of seconds. These functions
// never throw.

/// Time since the epoch in nanoseconds. Every ros::Time fits.
std::int64_t nanosecondsOf(const ros::Time& time);

/// Seconds from `from` to `to`.
double secondsBetween(const ros::Time& from, const ros::Time& to);

/// `time` plus `seconds`, limited to the range of ros::Time.
ros::Time shifted(const ros::Time& time, double seconds);

/// Decides whether the stamps of one source can be right. A single wrong stamp in a message must
/// not reach tf or the state of a node, because all later messages would then be too old.
///
/// A stamp that differs by more than a day from the one before is believed only if the next one
/// agrees with it. So a source whose clock was set loses one message.
class StampGate {
 public:
  /// Empty if the stamp can be right; otherwise the reason, for the sentence "it is refused: ...".
  /// Stamps of zero pass: the inputs have their own message for them. `now`: the first stamp is
  /// compared with it, if it is not zero.
  std::string refusal(const ros::Time& stamp, const ros::Time& now);

  static constexpr double kFarJump = 86400.0;  ///< s

 private:
  std::optional<ros::Time> last_;     ///< the newest stamp that was believed
  std::optional<ros::Time> suspect_;  ///< a stamp that no other one has confirmed yet
};

}  // namespace kestrel
