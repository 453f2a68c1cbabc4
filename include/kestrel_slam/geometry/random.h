// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace kestrel {

/// Random numbers that are the same on every platform: the standard fixes the generator, but not
/// the distributions.
class Random {
 public:
  explicit Random(std::uint64_t seed) : random_(seed) {}

  /// Uniform in [0, 1).
  double uniform() {
    constexpr int kUnusedBits = 64 - std::numeric_limits<double>::digits;
    return std::ldexp(static_cast<double>(random_() >> kUnusedBits),
                      -std::numeric_limits<double>::digits);
  }

  double uniform(double from, double to) { return from + (to - from) * uniform(); }

  /// Normal with mean 0 and variance 1, up to six standard deviations: the sum of twelve uniform
  /// numbers, which needs no function that is rounded differently elsewhere.
  double gaussian() {
    constexpr int kTerms = 12;  // their variances of 1/12 add up to 1
    double sum = -kTerms / 2.0;
    for (int i = 0; i < kTerms; ++i) sum += uniform();
    return sum;
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace kestrel
