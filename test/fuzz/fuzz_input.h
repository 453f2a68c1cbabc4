// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

namespace kestrel::fuzz {

/// Takes numbers from the bytes of a fuzzer, one after the other. At the end of the bytes all are
/// 0.
class FuzzInput {
 public:
  explicit FuzzInput(const std::string& bytes) : bytes_(bytes) {}

  bool atEnd() const { return position_ >= bytes_.size(); }
  std::uint8_t byte() { return atEnd() ? 0 : static_cast<std::uint8_t>(bytes_[position_++]); }
  bool flag() { return (byte() & 1U) != 0; }
  int below(int count) { return byte() % count; }

  template <typename T>
  T raw() {
    T value{};
    const std::size_t size =
        std::min(sizeof value, bytes_.size() - std::min(position_, bytes_.size()));
    if (size > 0) std::memcpy(&value, bytes_.data() + position_, size);
    position_ += size;
    return value;
  }

  double within(double min, double max) {
    return min + (max - min) * raw<std::uint16_t>() / std::numeric_limits<std::uint16_t>::max();
  }

  /// Mostly a plausible value, but one in eight is anything: NaN, infinite, huge.
  double any(double min, double max) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    constexpr int kKinds = 64, kPlausible = 56;
    const int kind = below(kKinds);
    if (kind < kPlausible) return within(min, max);
    const double special[] = {std::numeric_limits<double>::quiet_NaN(),
                              kInfinity,
                              -kInfinity,
                              0.0,
                              4294967296.0,
                              -1e300,
                              1e-310};
    return kind == kKinds - 1 ? raw<double>() : special[kind - kPlausible];
  }
  float anyFloat(double min, double max) { return static_cast<float>(any(min, max)); }

  Eigen::Vector3d anyVector(double size) {
    const double x = any(-size, size), y = any(-size, size);
    return {x, y, any(-size, size)};
  }
  Eigen::Quaterniond anyRotation() {
    const double w = any(-1, 1), x = any(-1, 1), y = any(-1, 1);
    Eigen::Quaterniond rotation(w, x, y, any(-1, 1));
    return flag() ? rotation.normalized() : rotation;
  }
  Eigen::Isometry3d anyMounting() {
    Eigen::Isometry3d mounting = Eigen::Isometry3d::Identity();
    if (flag()) return mounting;
    mounting.linear() = anyRotation().toRotationMatrix();
    mounting.translation() = anyVector(1.0);
    return mounting;
  }

 private:
  const std::string& bytes_;
  std::size_t position_ = 0;
};

}  // namespace kestrel::fuzz
