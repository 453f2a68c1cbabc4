// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kestrel {

/// A set of small numbers.
class BitSet {
 public:
  explicit BitSet(std::size_t size = 0) : words_((size + 63) / 64) {}

  void grow(std::size_t size) { words_.resize((size + 63) / 64); }
  void insert(std::size_t i) { words_[i / 64] |= bit(i); }
  void erase(std::size_t i) { words_[i / 64] &= ~bit(i); }
  bool contains(std::size_t i) const {
    return i / 64 < words_.size() && (words_[i / 64] & bit(i)) != 0;
  }
  std::size_t words() const { return words_.size(); }
  std::size_t count() const;
  bool empty() const;

  /// The smallest member that is not less than `from`; kNone if there is none.
  std::size_t next(std::size_t from) const;
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  BitSet& operator&=(const BitSet& other);
  /// Removes the members of `other`.
  BitSet& operator-=(const BitSet& other);

 private:
  static std::uint64_t bit(std::size_t i) { return std::uint64_t{1} << (i % 64); }

  std::vector<std::uint64_t> words_;
};

struct Clique {
  std::vector<std::size_t> members;  ///< in ascending order
  bool exact = true;                 ///< no larger one exists; otherwise the work limit was reached
};

/// The largest set of vertices that are all neighbors of each other: branch and bound with a bound
/// by greedy coloring [San Segundo 2011], from a greedy start. neighbors[i] is the set of neighbors
/// of i, without i itself, and symmetric. The work is counted in operations on words of 64 bits;
/// when `max_work` is reached, the best clique so far is returned. Of several largest ones it is
/// always the same.
Clique maximumClique(const std::vector<BitSet>& neighbors, std::size_t max_work);

}  // namespace kestrel
