// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// The part of a turn about the z axis in which a cloud has points.
struct AzimuthArc {
  double center = 0.0;  ///< rad
  double length = 0.0;  ///< rad
};
AzimuthArc azimuthArc(const PointCloud& cloud);

/// Joins the packets of a turn, for lidars that send each turn in several clouds: each packet is
/// about one packet width farther around the z axis than the one before. Clouds that see a full
/// turn, or always the same part of it, pass through unchanged.
///
/// The first clouds may have to wait for the third one, which decides what they are. One object for
/// each lidar (frame).
class CloudJoiner {
 public:
  /// Returns the clouds that are complete now, in order; often none or one.
  std::vector<PointCloud> add(PointCloud cloud);
  /// Returns what is still waiting. A turn of which less than half was received is left out.
  std::vector<PointCloud> finish();

  /// True after packets were recognized.
  bool joins() const { return kind_ == Kind::kPackets; }
  /// Turns that finish() left out.
  std::size_t incomplete() const { return incomplete_; }

 private:
  enum class Kind { kUnknown, kPackets, kWhole };
  struct Packet {
    PointCloud cloud;
    AzimuthArc arc;
  };

  void decide();
  void addPacket(Packet packet, std::vector<PointCloud>& ready);
  void release(std::vector<PointCloud>& clouds);

  Kind kind_ = Kind::kUnknown;
  std::vector<Packet> waiting_;  ///< the first clouds, until it is known what they are
  std::optional<PointCloud> turn_;
  AzimuthArc last_;
  double turned_ = 0.0;  ///< since the beginning of the turn, rad
  std::size_t incomplete_ = 0;
};

}  // namespace kestrel
