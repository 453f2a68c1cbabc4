// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/matching/likelihood_surface.h"
#include "likelihood_image.h"
#include "search_grid.h"

namespace kestrel {

/// The likelihood surface around `center`, ± the given steps. The image must cover it.
LikelihoodSurface sampleAround(const SearchGrid& grid, const LikelihoodImage& image,
                               const GridPose& center, int linear_steps, int angular_steps);

}  // namespace kestrel
