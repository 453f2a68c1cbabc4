// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace kestrel {

/// The share that the true one is below with 97.7 %, if `share` (0 to 1) was seen in `count` > 0
/// cases [Wilson 1927, two standard deviations]. It is large where few cases were seen.
inline double wilsonUpperBound(double share, double count) {
  constexpr double kSigmas2 = 4.0;
  const double deviation =
      std::sqrt(kSigmas2 * (share * (1.0 - share) + kSigmas2 / 4.0 / count) / count);
  return (share + kSigmas2 / 2.0 / count + deviation) / (1.0 + kSigmas2 / count);
}

}  // namespace kestrel
