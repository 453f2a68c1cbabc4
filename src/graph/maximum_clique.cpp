// SPDX-License-Identifier: BSD-3-Clause
#include "maximum_clique.h"

#include <algorithm>
#include <numeric>

namespace kestrel {
namespace {

/// The bits of a word that are set, and the position of the lowest one.
std::size_t bitCount(std::uint64_t word) {
  return static_cast<std::size_t>(__builtin_popcountll(word));
}
std::size_t lowestBit(std::uint64_t word) {
  return static_cast<std::size_t>(__builtin_ctzll(word));
}

class CliqueSearch {
 public:
  /// The vertices are numbered anew: those with most neighbors first.
  CliqueSearch(const std::vector<BitSet>& neighbors, std::size_t max_work)
      : order_(neighbors.size()), max_work_(max_work) {
    std::vector<std::size_t> degrees;
    for (const BitSet& row : neighbors) degrees.push_back(row.count());
    std::iota(order_.begin(), order_.end(), 0U);
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::size_t a, std::size_t b) { return degrees[a] > degrees[b]; });
    std::vector<std::size_t> places(order_.size());
    for (std::size_t i = 0; i < order_.size(); ++i) places[order_[i]] = i;
    for (const std::size_t old : order_) {
      BitSet row(order_.size());
      for (std::size_t j = neighbors[old].next(0); j != BitSet::kNone;
           j = neighbors[old].next(j + 1))
        row.insert(places[j]);
      rows_.push_back(std::move(row));
    }
  }

  Clique run() {
    for (std::size_t seed = 0; seed < rows_.size() && work_ < max_work_ / kGreedyShare; ++seed) {
      extendGreedily(seed);
    }
    BitSet all(rows_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i) all.insert(i);
    expand(std::move(all));
    Clique result;
    for (const std::size_t i : best_) result.members.push_back(order_[i]);
    std::sort(result.members.begin(), result.members.end());
    result.exact = work_ < max_work_;
    return result;
  }

 private:
  static constexpr std::size_t kGreedyShare = 4;  // of the work: at most a quarter

  struct Colored {
    std::size_t vertex, color;
  };

  /// From one vertex on, always takes the candidate with most neighbors.
  void extendGreedily(std::size_t seed) {
    std::vector<std::size_t> clique = {seed};
    BitSet candidates = rows_[seed];
    for (std::size_t i = candidates.next(0); i != BitSet::kNone; i = candidates.next(i)) {
      clique.push_back(i);
      candidates &= rows_[i];
      work_ += candidates.words();
    }
    if (clique.size() > best_.size()) best_ = std::move(clique);
  }

  /// Gives each candidate a color that none of its neighbors among them has: a clique needs as many
  /// colors as it has members. Returns those with colors above `skip`, in ascending order of
  /// colors.
  std::vector<Colored> color(BitSet uncolored, std::size_t skip) {
    std::vector<Colored> colored;
    for (std::size_t color = 1; !uncolored.empty(); ++color) {
      BitSet independent = uncolored;
      for (std::size_t i = independent.next(0); i != BitSet::kNone; i = independent.next(i + 1)) {
        independent -= rows_[i];
        uncolored.erase(i);
        work_ += independent.words();
        if (color > skip) colored.push_back({i, color});
      }
    }
    return colored;
  }

  void expand(BitSet candidates) {
    const std::size_t missing = best_.size() - std::min(best_.size(), clique_.size());
    const std::vector<Colored> colored = color(candidates, missing);
    for (auto next = colored.rbegin(); next != colored.rend(); ++next) {
      if (clique_.size() + next->color <= best_.size() || work_ >= max_work_) return;
      clique_.push_back(next->vertex);
      BitSet rest = candidates;
      rest &= rows_[next->vertex];
      if (clique_.size() > best_.size()) best_ = clique_;
      if (!rest.empty()) expand(std::move(rest));
      clique_.pop_back();
      candidates.erase(next->vertex);
    }
  }

  std::vector<std::size_t> order_;  // the vertex that each number stands for
  std::vector<BitSet> rows_;
  std::vector<std::size_t> clique_, best_;
  std::size_t max_work_, work_ = 0;
};

}  // namespace

std::size_t BitSet::count() const {
  std::size_t sum = 0;
  for (const std::uint64_t word : words_) sum += bitCount(word);
  return sum;
}

bool BitSet::empty() const {
  return std::all_of(words_.begin(), words_.end(), [](std::uint64_t word) { return word == 0; });
}

std::size_t BitSet::next(std::size_t from) const {
  for (std::size_t i = from / 64; i < words_.size(); ++i) {
    std::uint64_t word = words_[i];
    if (i == from / 64) word &= ~std::uint64_t{0} << (from % 64);
    if (word != 0) return 64 * i + lowestBit(word);
  }
  return kNone;
}

BitSet& BitSet::operator&=(const BitSet& other) {
  for (std::size_t i = 0; i < words_.size(); ++i) {
    words_[i] &= i < other.words_.size() ? other.words_[i] : 0;
  }
  return *this;
}

BitSet& BitSet::operator-=(const BitSet& other) {
  const std::size_t common = std::min(words_.size(), other.words_.size());
  for (std::size_t i = 0; i < common; ++i) words_[i] &= ~other.words_[i];
  return *this;
}

Clique maximumClique(const std::vector<BitSet>& neighbors, std::size_t max_work) {
  return CliqueSearch(neighbors, max_work).run();
}

}  // namespace kestrel
