// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace kestrel {

/// Log odds of a probability, as the cells of a grid store it: in steps of 1/1000, fine enough for
/// any update, and ±32 in range.
std::int16_t logOddsOf(double probability);

/// The probability of every stored value, from the lowest to the highest, pointing at that of zero:
/// matchers read millions of cells, and an exponential costs more than all the rest of it.
const double* probabilityTable();

/// Adds `miss`, down to `min`, to those of the 32 values of a row whose bit is set. The sum is
/// never 0, which would mean unknown.
void addMisses(std::uint32_t bits, std::int16_t miss, std::int16_t min, std::int16_t* values);

}  // namespace kestrel
