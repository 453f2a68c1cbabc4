// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

namespace kestrel {

/// Sweeps that wait for their attitude, in the order of arrival. Not thread-safe.
template <typename Sweep>
class WaitingQueue {
 public:
  explicit WaitingQueue(std::size_t capacity) : capacity_(capacity) {}

  /// Adds a sweep. If the queue was full, returns the oldest sweep, which was removed.
  std::optional<Sweep> push(Sweep sweep) {
    std::optional<Sweep> removed;
    if (sweeps_.size() >= capacity_ && !sweeps_.empty()) {
      removed = std::move(sweeps_.front());
      sweeps_.pop_front();
    }
    sweeps_.push_back(std::move(sweep));
    return removed;
  }

  /// Calls `handle` for every sweep and removes those for which it returns true. A waiting sweep
  /// does not delay later sweeps, because they may come from another laser.
  template <typename Handle>
  void process(const Handle& handle) {
    for (auto sweep = sweeps_.begin(); sweep != sweeps_.end();) {
      sweep = handle(std::as_const(*sweep)) ? sweeps_.erase(sweep) : sweep + 1;
    }
  }

  std::size_t size() const { return sweeps_.size(); }
  void clear() { sweeps_.clear(); }

 private:
  std::size_t capacity_;
  std::deque<Sweep> sweeps_;
};

}  // namespace kestrel
