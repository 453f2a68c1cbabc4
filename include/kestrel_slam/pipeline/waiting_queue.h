// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <set>
#include <type_traits>
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

  /// Calls `handle` for the sweeps and removes those for which it returns true. A waiting sweep
  /// delays the later sweeps of the same laser (`sourceOf` is equal), but not those of another one.
  template <typename Handle, typename SourceOf>
  void process(const Handle& handle, const SourceOf& sourceOf) {
    std::set<std::decay_t<decltype(sourceOf(sweeps_.front()))>> waiting;
    for (auto sweep = sweeps_.begin(); sweep != sweeps_.end();) {
      const bool is_next = waiting.count(sourceOf(*sweep)) == 0;
      if (is_next && handle(std::as_const(*sweep))) {
        sweep = sweeps_.erase(sweep);
      } else {
        waiting.insert(sourceOf(*sweep));
        ++sweep;
      }
    }
  }

  std::size_t size() const { return sweeps_.size(); }
  void clear() { sweeps_.clear(); }

 private:
  std::size_t capacity_;
  std::deque<Sweep> sweeps_;
};

}  // namespace kestrel
