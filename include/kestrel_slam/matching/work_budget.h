// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace kestrel {

/// The work that the searches of one scan may do. It is counted, not timed, so that equal input
/// gives equal results. The unit is about one instruction (scripts/count_instructions).
class WorkBudget {
 public:
  explicit WorkBudget(std::int64_t limit) : limit_(limit) {}

  /// Counts `work` and returns true, or returns false if so much is not left.
  bool take(std::int64_t work) {
    if (work > limit_ - used_) return false;
    used_ += work;
    return true;
  }
  std::int64_t used() const { return used_; }
  std::int64_t left() const { return limit_ - used_; }

 private:
  std::int64_t limit_;
  std::int64_t used_ = 0;
};

}  // namespace kestrel
