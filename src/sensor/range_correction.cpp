// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/range_correction.h"

#include <cmath>
#include <stdexcept>

#include "pair_list.h"

namespace kestrel {

RangeCorrection::RangeCorrection(const std::string& text) {
  const auto pairs = parsePairs(text);
  bool valid = pairs.has_value();
  if (valid && !pairs->empty()) knots_.emplace_back(0.0F, 0.0F);
  for (std::size_t i = 0; valid && i < pairs->size(); ++i) {
    const auto& [range, correction] = (*pairs)[i];
    valid = std::isfinite(range) && std::isfinite(correction) && range > knots_.back().first &&
            range + correction > 0.0;
    knots_.emplace_back(static_cast<float>(range), static_cast<float>(correction));
  }
  if (valid) return;
  throw std::invalid_argument("'" + text +
                              "' is not a list of corrections: write range:correction, "
                              "range:correction in meters, with ascending ranges above 0, for "
                              "example 4:0.14, 5.5:0.2");
}

float RangeCorrection::corrected(float range) const {
  if (knots_.empty() || !(range > 0.0F) || !std::isfinite(range)) return range;
  for (std::size_t i = 1; i < knots_.size(); ++i) {
    const auto& [from, at_from] = knots_[i - 1];
    const auto& [to, at_to] = knots_[i];
    if (range < to) return range + at_from + (range - from) / (to - from) * (at_to - at_from);
  }
  return range + knots_.back().second;
}

}  // namespace kestrel
