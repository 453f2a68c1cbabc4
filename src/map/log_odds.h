// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace kestrel {

/// Log odds of a probability in the fixed-point format of the grid: steps of 1/1000, range ±32.
std::int16_t logOddsOf(double probability);

/// Table of the probability for every fixed-point value. The pointer is to the entry for 0;
/// negative indices are valid. Matchers read millions of cells, and an exponential would dominate
/// their time.
const double* probabilityTable();

/// The same for the probability in %, rounded; never 50, which would be neither free nor occupied.
const std::int8_t* percentTable();

/// Adds `miss` to those of the 32 values of a row whose bit is set; the results are at least `min`.
/// A result is never 0, which would mean unknown.
void addMisses(std::uint32_t bits, std::int16_t miss, std::int16_t min, std::int16_t* values);

}  // namespace kestrel
