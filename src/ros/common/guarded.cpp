// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/guarded.h"

#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {
namespace {

constexpr double kComplainEvery = 5.0;  // s

}  // namespace

void reportException(const std::string& where, const char* what) noexcept {
  try {
    KESTREL_ERROR_THROTTLE(kComplainEvery, "Internal error in %s: %s", where.c_str(), what);
  } catch (...) {  // logging must not end the node either
  }
}

void logRefusal(const std::string& topic, const std::string& reason) {
  KESTREL_WARN_THROTTLE(kComplainEvery, "A message on %s is refused: %s.", topic.c_str(),
                        reason.c_str());
}

}  // namespace kestrel
