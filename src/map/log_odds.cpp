// SPDX-License-Identifier: BSD-3-Clause
#include "log_odds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace kestrel {
namespace {

constexpr double kLogOddsScale = 1000.0;
constexpr int kMin = std::numeric_limits<std::int16_t>::min();
constexpr int kMax = std::numeric_limits<std::int16_t>::max();

/// For every byte, eight 16-bit masks of its bits. They expand a row of bits to vector lanes, so
/// that the compiler can add eight values at a time.
using Lanes = std::array<std::int16_t, 8>;
const std::array<Lanes, 256>& laneMasks() {
  static const std::array<Lanes, 256> masks = [] {
    std::array<Lanes, 256> table{};
    for (unsigned byte = 0; byte < table.size(); ++byte) {
      for (unsigned bit = 0; bit < 8; ++bit) {
        table[byte][bit] = static_cast<std::int16_t>((byte >> bit & 1U) != 0U ? -1 : 0);
      }
    }
    return table;
  }();
  return masks;
}

}  // namespace

std::int16_t logOddsOf(double probability) {
  return static_cast<std::int16_t>(
      std::lround(kLogOddsScale * std::log(probability / (1.0 - probability))));
}

const double* probabilityTable() {
  static const std::vector<double> table = [] {
    std::vector<double> values;
    values.reserve(kMax - kMin + 1);
    for (int log_odds = kMin; log_odds <= kMax; ++log_odds) {
      values.push_back(1.0 / (1.0 + std::exp(-static_cast<double>(log_odds) / kLogOddsScale)));
    }
    return values;
  }();
  return table.data() - kMin;
}

const std::int8_t* percentTable() {
  static const std::vector<std::int8_t> table = [] {
    std::vector<std::int8_t> values;
    values.reserve(kMax - kMin + 1);
    for (int log_odds = kMin; log_odds <= kMax; ++log_odds) {
      const auto percent = std::lround(100.0 * probabilityTable()[log_odds]);
      const auto other = log_odds > 0 ? 51 : 49;
      values.push_back(static_cast<std::int8_t>(percent == 50 ? other : percent));
    }
    return values;
  }();
  return table.data() - kMin;
}

// The values are copied to local variables. Members could not stay in vector registers, because any
// write could change them.
void addMisses(std::uint32_t bits, std::int16_t miss, std::int16_t min, std::int16_t* values) {
  const std::array<Lanes, 256>& masks = laneMasks();
  for (; bits != 0U; bits >>= 8U, values += 8) {
    const std::uint32_t byte = bits & 0xFFU;
    if (byte == 0U) continue;
    const Lanes mask = masks[byte];
    Lanes sums;
    for (std::size_t lane = 0; lane < 8; ++lane) {
      const auto value = static_cast<std::int16_t>(values[lane] + (mask[lane] & miss));
      const std::int16_t clamped = std::max(value, min);
      // A sum of 0 would mean unknown. It is replaced by -1 (all bits set), the weakest evidence
      // for free.
      const auto zero = static_cast<std::int16_t>(clamped == 0 ? -1 : 0);
      sums[lane] = static_cast<std::int16_t>(clamped | (zero & mask[lane]));
    }
    std::copy(sums.begin(), sums.end(), values);
  }
}

}  // namespace kestrel
