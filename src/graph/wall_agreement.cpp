// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/wall_agreement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_set>

#include "kestrel_slam/geometry/wilson_bound.h"
#include "kestrel_slam/matching/unknown_score.h"
#include "wall_comparison.h"

namespace kestrel {
namespace {

constexpr float kSquareM = 0.1F;
constexpr double kPieceM = 0.5;
/// A hit is on a wall up to this distance from it.
constexpr float kOnWallM = 0.1F;
/// A beam passes through a wall if it goes on for so long behind it, m.
constexpr float kBehindM = 0.5F;
/// A wall has so many hits in a cell. A beam passes through it if the square of the sine of the
/// angle between them is larger than this: a small error of the pose explains beams along a wall.
constexpr float kWallHits = 3.0F, kAcross = 0.15F;
/// So far to both sides the wall goes on where it is crossed, cells.
constexpr float kGoesOnCells = 2.0F;

using Squares = std::unordered_set<std::int64_t>;

std::int64_t squareOf(const Eigen::Vector2f& point) {
  const auto number = [](float x) { return static_cast<std::int64_t>(std::floor(x / kSquareM)); };
  return number(point.x()) * (1LL << 32) + number(point.y());
}

float squaredDistance(const Surfel& wall, const Eigen::Vector2f& point) {
  const Eigen::Vector2f e = point - wall.on_wall;
  return wall.a11 * e.x() * e.x() + 2.0F * wall.a12 * e.x() * e.y() + wall.a22 * e.y() * e.y();
}

bool isAcross(const Surfel& wall, const Eigen::Vector2f& along) {
  return isPoint(wall) || along.x() * (wall.a11 * along.x() + 2.0F * wall.a12 * along.y()) +
                                  along.y() * wall.a22 * along.y() >
                              kAcross;
}

/// The direction of the wall. A surfel without one is taken across the beam.
Eigen::Vector2f directionOf(const Surfel& wall, const Eigen::Vector2f& along) {
  if (isPoint(wall)) return {-along.y(), along.x()};
  const Eigen::Vector2f normal = normalOf(wall);
  return {-normal.y(), normal.x()};
}

class Comparison {
 public:
  Comparison(const Submap& map, CrossedWalls crossed)
      : map_(map),
        between_ends_(crossed == CrossedWalls::kBetweenEnds),
        cell_m_(map.surface().resolution()) {}

  void add(const Eigen::Vector2f& origin, const Eigen::Vector2f& end) {
    addHit(end);
    addCrossed(origin, end);
  }

  WallAgreement result() {
    for (const std::int64_t square : seen_) crossed_.erase(square);
    result_.hits = hits_.size();
    result_.crossed = crossed_.size();
    return result_;
  }

 private:
  /// The first hit in a square stands for all of them.
  void addHit(const Eigen::Vector2f& end) {
    const Surfel* wall = map_.surface().nearest(end);
    const bool on_wall = wall != nullptr && squaredDistance(*wall, end) < kOnWallM * kOnWallM;
    if (on_wall) seen_.insert(squareOf(wall->mean));
    if (!hits_.insert(squareOf(end)).second) return;
    if (on_wall) ++result_.matched;
    if (on_wall || map_.grid().isKnownOrPresumed(map_.grid().cellAt(end))) ++result_.known;
  }

  void addCrossed(const Eigen::Vector2f& origin, const Eigen::Vector2f& end) {
    const float length = (end - origin).norm();
    const Eigen::Vector2f along = (end - origin) / std::max(length, cell_m_);
    for (float at = 0.0F; at < length - kBehindM; at += cell_m_) {
      const Eigen::Vector2f point = origin + along * at;
      const Surfel* wall = map_.surface().nearest(point);
      if (wall == nullptr || wall->count < kWallHits || !isAcross(*wall, along)) continue;
      if (isNear(*wall, point) && (!between_ends_ || goesOn(*wall, along)))
        crossed_.insert(squareOf(wall->mean));
    }
  }

  bool isNear(const Surfel& wall, const Eigen::Vector2f& point) const {
    return (point - wall.mean).squaredNorm() <= cell_m_ * cell_m_;
  }

  /// Whether there is wall on both sides of the beam.
  bool goesOn(const Surfel& wall, const Eigen::Vector2f& along) const {
    const Eigen::Vector2f step = kGoesOnCells * cell_m_ * directionOf(wall, along);
    const auto isWallAt = [&](const Eigen::Vector2f& point) {
      const Surfel* other = map_.surface().nearest(point);
      return other != nullptr && isNear(*other, point);
    };
    return isWallAt(wall.mean + step) && isWallAt(wall.mean - step);
  }

  const Submap& map_;
  bool between_ends_;
  float cell_m_;
  Squares hits_, seen_, crossed_;
  WallAgreement result_;
};

double shareOf(double part, std::size_t whole) {
  return whole == 0 ? 0.0 : part / static_cast<double>(whole);
}

/// Pieces of wall fit or fail as a whole.
double piecesOf(std::size_t squares) {
  return std::max(1.0, static_cast<double>(squares) * static_cast<double>(kSquareM) / kPieceM);
}

double varianceOf(double share, std::size_t squares) {
  return share * (1.0 - share) / piecesOf(squares);
}

}  // namespace

double WallAgreement::contradiction() const {
  return shareOf(static_cast<double>(known - matched + crossed), known + crossed);
}

double WallAgreement::possibleContradiction() const {
  return contradiction() + std::sqrt(varianceOf(contradiction(), known + crossed));
}

double WallAgreement::contradictionBound() const {
  return wilsonUpperBound(contradiction(), piecesOf(known + crossed));
}

double WallAgreement::score() const {
  const double unknown = kUnknownScore * static_cast<double>(hits - known);
  return shareOf(static_cast<double>(matched) + unknown, hits + crossed);
}

double WallAgreement::variance() const { return varianceOf(score(), hits + crossed); }

WallAgreement compareWalls(const Submap& map, const std::vector<ScanInMap>& scans,
                           std::size_t most_beams) {
  return compareWalls(map, scans, most_beams, CrossedWalls::kAll);
}

WallAgreement compareWalls(const Submap& map, const std::vector<ScanInMap>& scans,
                           std::size_t most_beams, CrossedWalls crossed) {
  std::size_t beams = 0, number = 0;
  for (const ScanInMap& placed : scans) beams += placed.scan->rays.size();
  const std::size_t each = std::max<std::size_t>(1, (beams + most_beams - 1) / most_beams);
  Comparison comparison(map, crossed);
  for (const ScanInMap& placed : scans) {
    const auto inMap = [&](const Eigen::Vector2f& p) -> Eigen::Vector2f {
      return (placed.map_T_scan * p.cast<double>().eval()).cast<float>();
    };
    for (const PlanarRay& ray : placed.scan->rays) {
      if (number++ % each == 0 && ray.hit) comparison.add(inMap(ray.origin), inMap(ray.end));
    }
  }
  return comparison.result();
}

}  // namespace kestrel
