// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/lost_watch.h"

namespace kestrel {
namespace {

constexpr double kLost_s = 5.0;
constexpr int kLostScans = 20;

}  // namespace

bool LostWatch::add(const MapperResult& result, double time) {
  if (result.state != MatchState::kLost) {
    *this = LostWatch();
    return false;
  }
  if (!since_) since_ = time;
  if (!result.blank) ++scans_;
  if (result.blank || scans_ < kLostScans || time - *since_ < kLost_s) return false;
  *this = LostWatch();
  return true;
}

}  // namespace kestrel
