// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/compact_scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "varint.h"

namespace kestrel {
namespace {

/// A position in steps.
using Steps = Eigen::Vector2i;

constexpr std::int32_t kMaxSteps =
    static_cast<std::int32_t>(CompactScan::kMaxCoordinateM / CompactScan::kStepM);

Steps stepsOf(const Eigen::Vector2f& position) {
  constexpr float kStepsPerM = 1.0F / CompactScan::kStepM;
  return {static_cast<int>(std::lround(position.x() * kStepsPerM)),
          static_cast<int>(std::lround(position.y() * kStepsPerM))};
}

Eigen::Vector2f positionOf(const Steps& steps) { return steps.cast<float>() * CompactScan::kStepM; }

/// The flags of a ray in four bits.
enum Kind : unsigned { kHit = 1, kNoReturn = 2, kPresumed = 4, kKnown = 8 };
constexpr unsigned kKindBits = 4, kKindMask = 15;

unsigned kindOf(const PlanarRay& ray) {
  return (ray.hit ? kHit : 0U) | (ray.no_return ? kNoReturn : 0U) |
         (ray.presumed ? kPresumed : 0U) | (ray.known ? kKnown : 0U);
}

PlanarRay rayOf(unsigned kind, const Eigen::Vector2f& end) {
  return {{0.0F, 0.0F},
          end,
          (kind & kHit) != 0U,
          (kind & kKnown) != 0U,
          (kind & kNoReturn) != 0U,
          (kind & kPresumed) != 0U};
}

bool fits(const PlanarRay& ray) {
  // The comparison is false for NaN.
  const auto isSmall = [](float v) { return std::abs(v) <= CompactScan::kMaxCoordinateM; };
  return isSmall(ray.origin.x()) && isSmall(ray.origin.y()) && isSmall(ray.end.x()) &&
         isSmall(ray.end.y());
}

/// The latest end of each kind. Hits follow hits along a wall, clears follow clears along the limit
/// of the slice. Whether a hit is known makes no difference.
class LatestEnds {
 public:
  Steps& of(unsigned kind) { return ends_[kind & ~kKnown]; }

 private:
  std::array<Steps, kKnown> ends_ = [] {
    std::array<Steps, kKnown> ends;
    ends.fill(Steps::Zero());
    return ends;
  }();
};

class Encoder {
 public:
  explicit Encoder(const std::vector<PlanarRay>& rays) {
    rays_.reserve(rays.size());
    for (const PlanarRay& ray : rays) {
      if (fits(ray)) rays_.push_back({kindOf(ray), stepsOf(ray.origin), stepsOf(ray.end)});
    }
  }

  std::string encode() {
    out_.add(static_cast<std::uint32_t>(rays_.size()));
    for (std::size_t i = 0; i < rays_.size();) i += addKinds(i);
    LatestEnds latest;
    for (const Ray& ray : rays_) addDifference(ray.end, latest.of(ray.kind));
    Steps origin = Steps::Zero();
    for (std::size_t i = 0; i < rays_.size();) i += addOrigin(i, origin);
    return out_.bytes();
  }

 private:
  struct Ray {
    unsigned kind;
    Steps origin, end;
  };

  /// A run in which two kinds take turns: beams without a return give two rays each.
  std::size_t addKinds(std::size_t first) {
    const unsigned kinds[] = {rays_[first].kind, rays_[std::min(first + 1, rays_.size() - 1)].kind};
    std::size_t count = 1;
    while (first + count < rays_.size() && rays_[first + count].kind == kinds[count % 2]) ++count;
    out_.add(kinds[0] | kinds[1] << kKindBits);
    out_.add(static_cast<std::uint32_t>(count));
    return count;
  }

  std::size_t addOrigin(std::size_t first, Steps& previous) {
    std::size_t count = 1;
    while (first + count < rays_.size() && rays_[first + count].origin == rays_[first].origin) {
      ++count;
    }
    out_.add(static_cast<std::uint32_t>(count));
    addDifference(rays_[first].origin, previous);
    return count;
  }

  void addDifference(const Steps& position, Steps& previous) {
    out_.addSigned(position.x() - previous.x());
    out_.addSigned(position.y() - previous.y());
    previous = position;
  }

  std::vector<Ray> rays_;
  VarintWriter out_;
};

/// Reads the sections one after the other. Throws std::invalid_argument if they are no scan.
class Decoder {
 public:
  explicit Decoder(const std::string& bytes) : in_(bytes), count_(in_.next()) {
    // Each end has two bytes at least: a wrong number reserves no memory.
    if (count_ > in_.left() / 2) throw std::invalid_argument("it has fewer rays than it says");
    readKinds();
  }

  std::size_t count() const { return count_; }

  /// Calls `use(kind, end)` for every ray.
  template <typename Use>
  void readEnds(Use use) {
    LatestEnds latest;
    for (const unsigned char kind : kinds_) use(kind, next(latest.of(kind)));
  }

  void readOrigins(std::vector<PlanarRay>& rays) {
    Steps latest = Steps::Zero();
    for (std::size_t i = 0; i < count_;) {
      const std::size_t run = nextRun(i);
      const Eigen::Vector2f origin = next(latest);
      for (const std::size_t end = i + run; i < end; ++i) rays[i].origin = origin;
    }
    if (in_.left() > 0) throw std::invalid_argument("bytes follow its last ray");
  }

 private:
  void readKinds() {
    kinds_.resize(count_);
    for (std::size_t i = 0; i < count_;) {
      const std::uint32_t pair = in_.next();
      if (pair >> 2 * kKindBits != 0U) throw std::invalid_argument("a ray has an unknown kind");
      const std::size_t run = nextRun(i);
      for (std::size_t k = 0; k < run; ++k, ++i) {
        kinds_[i] = static_cast<unsigned char>(pair >> (k % 2) * kKindBits & kKindMask);
      }
    }
  }

  std::size_t nextRun(std::size_t done) {
    const std::size_t run = in_.next();
    if (run > 0 && run <= count_ - done) return run;
    throw std::invalid_argument("a run has a wrong length");
  }

  Eigen::Vector2f next(Steps& latest) {
    // Sums of 64 bits: differences of any bytes may overflow.
    const std::int64_t x = std::int64_t{latest.x()} + in_.nextSigned();
    const std::int64_t y = std::int64_t{latest.y()} + in_.nextSigned();
    if (std::abs(x) > kMaxSteps || std::abs(y) > kMaxSteps) {
      throw std::invalid_argument("a position is too far away");
    }
    latest = {static_cast<int>(x), static_cast<int>(y)};
    return positionOf(latest);
  }

  VarintReader in_;
  std::size_t count_;
  std::vector<unsigned char> kinds_;
};

std::vector<PlanarRay> decode(const std::string& bytes) {
  Decoder decoder(bytes);
  std::vector<PlanarRay> rays;
  rays.reserve(decoder.count());
  decoder.readEnds(
      [&rays](unsigned kind, const Eigen::Vector2f& end) { rays.push_back(rayOf(kind, end)); });
  decoder.readOrigins(rays);
  return rays;
}

}  // namespace

CompactScan::CompactScan(const std::vector<PlanarRay>& rays)
    : CompactScan(Encoder(rays).encode()) {}

CompactScan::CompactScan(std::string bytes) : bytes_(std::move(bytes)) {
  const std::vector<PlanarRay> decoded = decode(bytes_);
  ray_count_ = decoded.size();
  for (const PlanarRay& ray : decoded) hit_count_ += ray.hit ? 1U : 0U;
  bytes_.shrink_to_fit();
}

CompactScan CompactScan::fromBytes(std::string bytes) { return CompactScan(std::move(bytes)); }

std::vector<PlanarRay> CompactScan::rays() const { return decode(bytes_); }

Points CompactScan::hits() const {
  Points points;
  points.reserve(hit_count_);
  Decoder(bytes_).readEnds([&points](unsigned kind, const Eigen::Vector2f& end) {
    if ((kind & kHit) != 0U) points.push_back(end);
  });
  return points;
}

}  // namespace kestrel
