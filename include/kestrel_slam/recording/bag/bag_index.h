// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/recording/bag/bag_topics.h"

namespace kestrel {

/// What the index at the end of a bag says about it.
struct BagIndex {
  BagTopics topics;
  double begin = 0.0, end = 0.0;  ///< record times of the first and last message, s
};

/// Reads only the end of the file, so that it takes as long for a large bag as for a small one.
/// Damage before the index is not found. Throws std::runtime_error where there is no index of
/// format 2.0, or no message.
BagIndex readBagIndex(const std::string& path);

}  // namespace kestrel
