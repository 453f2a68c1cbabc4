// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/cloud_joiner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kTurn = 2.0 * kPi;
constexpr double kNearlyAll = 0.9;       // share of a turn; a packet covers less
constexpr std::size_t kSectors = 720;    // of a turn
constexpr std::size_t kToDecide = 3;     // clouds
constexpr double kMaxPause_s = 0.5;      // between two packets of a turn
constexpr double kHalfTurn = kPi - 0.3;  // rad; with such steps the direction is not known

double stepBetween(const AzimuthArc& from, const AzimuthArc& to) {
  return std::remainder(to.center - from.center, kTurn);
}

/// True if `to` is about one packet farther than `from`.
bool follows(const AzimuthArc& from, const AzimuthArc& to) {
  const double width = 0.5 * (from.length + to.length);
  const double step = std::abs(stepBetween(from, to));
  return step > 0.5 * width && step < 1.5 * width;
}

std::array<bool, kSectors> occupiedSectors(const PointCloud& cloud) {
  std::array<bool, kSectors> occupied{};
  for (const PointCloud::Point& point : cloud.points) {
    const double azimuth = std::atan2(point.y, point.x);
    if (!std::isfinite(azimuth) || (point.x == 0.0F && point.y == 0.0F)) continue;
    const auto sector = static_cast<std::size_t>((azimuth + kPi) / kTurn * kSectors);
    occupied[std::min(sector, kSectors - 1)] = true;
  }
  return occupied;
}

}  // namespace

AzimuthArc azimuthArc(const PointCloud& cloud) {
  const std::array<bool, kSectors> occupied = occupiedSectors(cloud);
  // The largest gap without points, also across the ends of the array.
  std::size_t gap = 0, largest = 0, end_of_largest = 0;
  for (std::size_t i = 0; i < 2 * kSectors; ++i) {
    gap = occupied[i % kSectors] ? 0 : gap + 1;
    if (gap <= largest || gap > kSectors) continue;
    largest = gap;
    end_of_largest = i + 1;
  }
  const double sector = kTurn / kSectors;
  const double length = sector * static_cast<double>(kSectors - largest);
  const double start = sector * static_cast<double>(end_of_largest) - kPi;
  return {normalizeAngle(start + length / 2.0), length};
}

std::vector<PointCloud> CloudJoiner::add(PointCloud cloud) {
  std::vector<PointCloud> ready;
  if (kind_ == Kind::kWhole) {
    ready.push_back(std::move(cloud));
    return ready;
  }
  Packet packet{std::move(cloud), {}};
  packet.arc = azimuthArc(packet.cloud);
  if (kind_ == Kind::kPackets) {
    addPacket(std::move(packet), ready);
    return ready;
  }
  if (packet.arc.length > kNearlyAll * kTurn) kind_ = Kind::kWhole;
  waiting_.push_back(std::move(packet));
  if (kind_ == Kind::kUnknown && waiting_.size() == kToDecide) decide();
  if (kind_ == Kind::kUnknown) return ready;
  for (Packet& waiting : std::exchange(waiting_, {})) {
    if (kind_ == Kind::kPackets) {
      addPacket(std::move(waiting), ready);
    } else {
      ready.push_back(std::move(waiting.cloud));
    }
  }
  return ready;
}

void CloudJoiner::decide() {
  const double first = stepBetween(waiting_[0].arc, waiting_[1].arc);
  const double second = stepBetween(waiting_[1].arc, waiting_[2].arc);
  const bool same_direction =
      first * second > 0.0 || std::min(std::abs(first), std::abs(second)) > kHalfTurn;
  const bool moves =
      follows(waiting_[0].arc, waiting_[1].arc) && follows(waiting_[1].arc, waiting_[2].arc);
  kind_ = moves && same_direction ? Kind::kPackets : Kind::kWhole;
}

void CloudJoiner::addPacket(Packet packet, std::vector<PointCloud>& ready) {
  if (turn_) {
    turned_ += std::abs(stepBetween(last_, packet.arc));
    const double pause = packet.cloud.stamp - turn_->stamp;
    const bool full = turned_ > kTurn - packet.arc.length / 2.0;
    if (full || !(pause >= 0.0 && pause < kMaxPause_s)) release(ready);
  }
  last_ = packet.arc;
  if (!turn_) {
    turn_ = std::move(packet.cloud);
    turned_ = 0.0;
    return;
  }
  const auto later = static_cast<float>(packet.cloud.stamp - turn_->stamp);
  for (PointCloud::Point& point : packet.cloud.points) point.time += later;
  turn_->points.insert(turn_->points.end(), packet.cloud.points.begin(), packet.cloud.points.end());
}

std::vector<PointCloud> CloudJoiner::finish() {
  std::vector<PointCloud> ready;
  for (Packet& waiting : std::exchange(waiting_, {})) ready.push_back(std::move(waiting.cloud));
  if (turn_ && turned_ < kTurn / 2.0) {
    ++incomplete_;
    turn_.reset();
  }
  release(ready);
  return ready;
}

void CloudJoiner::release(std::vector<PointCloud>& clouds) {
  if (turn_) clouds.push_back(std::move(*turn_));
  turn_.reset();
}

}  // namespace kestrel
