// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <iterator>
#include <map>

namespace kestrel {

/// A set of numbers, stored as ranges.
class NumberSet {
 public:
  using Number = std::uint64_t;

  void insert(Number number) { insert(number, number); }

  /// Adds first, ..., last.
  void insert(Number first, Number last) {
    if (last < first) return;
    auto at = ranges_.upper_bound(first);
    if (at != ranges_.begin() && std::prev(at)->second + 1 >= first) {
      --at;
      first = at->first;
    }
    while (at != ranges_.end() && at->first <= last + 1) {
      if (at->second > last) last = at->second;
      at = ranges_.erase(at);
    }
    ranges_[first] = last;
  }

  bool contains(Number number) const {
    const auto next = ranges_.upper_bound(number);
    return next != ranges_.begin() && std::prev(next)->second >= number;
  }

  /// The largest number up to `number` that is not in the set; 0 if there is none above it.
  Number highestMissing(Number number) const {
    while (number > 0) {
      const auto next = ranges_.upper_bound(number);
      if (next == ranges_.begin() || std::prev(next)->second < number) return number;
      number = std::prev(next)->first - 1;
    }
    return 0;
  }

  /// First and last number of each range, ascending.
  const std::map<Number, Number>& ranges() const { return ranges_; }
  bool empty() const { return ranges_.empty(); }

 private:
  std::map<Number, Number> ranges_;
};

}  // namespace kestrel
