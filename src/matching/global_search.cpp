// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/global_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <unordered_set>

#include "bound_images.h"
#include "hybrid_matcher.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/matching/thinned.h"
#include "point_bounds.h"
#include "sketch.h"

namespace kestrel {
namespace {

/// Number of points. Those in the same square of this side are one: a wall that is near has more
/// beams than one that is far away, but it does not say more.
constexpr std::size_t kPoints = 160;
constexpr double kSquareM = 0.1;
constexpr float kFarthestM = 60.0F;
/// Half of a yaw step moves the median point by this, and the farthest one at most by this, cells.
constexpr double kMedianReach = 1.0, kMostReach = 8.0;
constexpr std::size_t kMostNodes = 1'000'000;
constexpr double kTwoPi = 2.0 * kPi;
/// The score may rise by this from a pose of the grid to the optimum beside it.
constexpr double kDescentGain = 0.1;
/// Work of a row of a tile for four points, of a tile, of one look-up, and of one node in the heap.
constexpr std::int64_t kWorkPerRow = 12, kWorkPerTile = 2000, kWorkPerLookup = 6, kWorkPerNode = 60;
/// A descent costs so many look-ups for each point.
constexpr std::int64_t kSketchLookups = 40;
constexpr std::size_t kTogether = 4;
static_assert(kTogether * BoundImages::kMax <= 0xFF, "the sum of four fits into a byte");

Points spread(const Points& points) {
  std::unordered_set<std::int64_t> taken;
  Points result;
  for (const Eigen::Vector2f& p : points) {
    if (!(p.norm() <= kFarthestM)) continue;  // also if it is not finite
    const auto square = [](float x) {
      return static_cast<std::int64_t>(std::floor(static_cast<double>(x) / kSquareM));
    };
    if (taken.insert(square(p.x()) * (1LL << 32) + square(p.y())).second) result.push_back(p);
  }
  return sampled(result, kPoints);
}

/// A block of poses: 4 >> level cells from (x, y) on, and the yaw interval k of its level.
struct Node {
  std::int32_t sum;  ///< of the bounds of all points
  std::int32_t level, k, x, y;
};

bool isWorse(const Node& a, const Node& b) {
  return std::tie(a.sum, a.level, b.k, b.y, b.x) < std::tie(b.sum, b.level, a.k, a.y, a.x);
}

}  // namespace

GlobalMap::GlobalMap(const Submap& map) : map_(map), images_(std::make_unique<BoundImages>(map)) {}
GlobalMap::~GlobalMap() = default;
std::size_t GlobalMap::memoryBytes() const { return images_->memoryBytes(); }

struct GlobalSearch::State {
  State(const GlobalMap& m, const Points& all, const GlobalSearchConfig& c);

  bool run(WorkBudget& budget);
  bool bounds(WorkBudget& budget);
  void boundTile(const std::vector<RotatedPoint>& rotated, const BoundImages::Tile& tile);
  void expand(const Node& node);
  void look(const Node& node);
  void add(const Pose2& pose, double score);
  bool isKnown(const Pose2& pose) const;
  void push(const Node& node);
  void cut();

  Pose2 poseOf(const Node& node) const;
  const std::vector<RotatedPoint>& rotated(int level, int k);
  double scoreAt(const Pose2& pose) const;
  int sumFor(double score) const {
    return static_cast<int>(score * BoundImages::kMax * static_cast<double>(points.size()));
  }
  double scoreFor(double sum) const {
    return sum / (BoundImages::kMax * static_cast<double>(points.size()));
  }
  /// A lower score is of no interest.
  double leastScore() const {
    if (found.empty()) return config.min_score;
    const double worst = found.size() < config.most ? 0.0 : found.back().score;
    return std::max({config.min_score, found.front().score - config.margin, worst});
  }
  int least() const { return std::max(1, sumFor(leastScore())); }

  const GlobalMap& map;
  const BoundImages& images;
  GlobalSearchConfig config;
  Points points;
  Points cells;  ///< the points in cells
  int yaws = 1;  ///< of the coarsest level
  int next_yaw = 0;
  std::size_t next_tile = 0;
  std::array<std::vector<std::vector<RotatedPoint>>, BoundImages::kLevels> rotations;
  std::vector<Node> nodes;       ///< a heap as soon as all bounds are known
  int dropped = 0;               ///< largest sum of the nodes that were left out
  PointBounds bounds_of_points;  ///< in the block that is being divided
  std::int64_t lookups = 0;      ///< that are not yet counted as work
  bool is_heap = false, done = false;
  std::vector<GlobalHypothesis> found;
};

GlobalSearch::State::State(const GlobalMap& m, const Points& all, const GlobalSearchConfig& c)
    : map(m), images(m.images()), config(c), points(spread(all)) {
  done = points.empty() || images.tiles().empty();
  if (done) return;
  std::vector<float> ranges;
  for (const Eigen::Vector2f& p : points) {
    cells.push_back(p / static_cast<float>(images.cell()));
    ranges.push_back(cells.back().norm());
  }
  std::sort(ranges.begin(), ranges.end());
  const auto median = static_cast<double>(ranges[ranges.size() / 2]);
  const auto farthest = static_cast<double>(ranges.back());
  const double step =
      2.0 * std::min(kMedianReach / std::max(median, 1.0), kMostReach / std::max(farthest, 1.0));
  yaws = std::max(1, static_cast<int>(std::ceil(kTwoPi / step)));
  for (int level = 0; level < BoundImages::kLevels; ++level)
    rotations[static_cast<std::size_t>(level)].resize(static_cast<std::size_t>(yaws) << level);
}

const std::vector<RotatedPoint>& GlobalSearch::State::rotated(int level, int k) {
  std::vector<RotatedPoint>& result =
      rotations[static_cast<std::size_t>(level)][static_cast<std::size_t>(k)];
  if (!result.empty()) return result;
  const double step = kTwoPi / (static_cast<double>(yaws) * (1 << level));
  const double yaw = (k + 0.5) * step;
  const double c = std::cos(yaw), s = std::sin(yaw);
  for (const Eigen::Vector2f& cell : cells) {
    const Eigen::Vector2d p = cell.cast<double>();
    const Eigen::Vector2d at(c * p.x() - s * p.y(), s * p.x() + c * p.y());
    const double reach = 0.5 * step * p.norm();
    const auto low = (at.array() - reach).floor().cast<int>().eval();
    const auto high = (at.array() + reach).floor().cast<int>().eval();
    const int side = (high - low).maxCoeff() + (4 >> level);
    result.push_back({low.x(), low.y(), BoundImages::imageFor(side)});
  }
  return result;
}

bool GlobalSearch::State::run(WorkBudget& budget) {
  if (done || !bounds(budget)) return done;
  if (!is_heap) {
    std::make_heap(nodes.begin(), nodes.end(), isWorse);
    is_heap = true;
  }
  while (!nodes.empty() && nodes.front().sum >= least()) {
    if (!budget.take(kWorkPerNode + kWorkPerLookup * lookups)) return false;
    lookups = 0;
    std::pop_heap(nodes.begin(), nodes.end(), isWorse);
    const Node node = nodes.back();
    nodes.pop_back();
    if (node.level + 1 == BoundImages::kLevels) {
      look(node);
    } else {
      expand(node);
    }
  }
  nodes.clear();
  nodes.shrink_to_fit();
  return done = true;
}

/// The bounds of all blocks of the coarsest level. Returns whether all are known.
bool GlobalSearch::State::bounds(WorkBudget& budget) {
  const auto additions = static_cast<std::int64_t>(points.size() / kTogether + kTogether);
  const std::int64_t work = kWorkPerTile + kWorkPerRow * additions * BoundImages::kTileBlocks;
  for (; next_yaw < yaws; ++next_yaw) {
    const std::vector<RotatedPoint>& turned = rotated(0, next_yaw);
    for (; next_tile < images.tiles().size(); ++next_tile) {
      if (!budget.take(work)) return false;
      boundTile(turned, images.tiles()[next_tile]);
    }
    next_tile = 0;
  }
  return true;
}

void GlobalSearch::State::boundTile(const std::vector<RotatedPoint>& turned,
                                    const BoundImages::Tile& tile) {
  constexpr int kSide = BoundImages::kTileBlocks, kCells = BoundImages::kTileCells;
  std::array<std::uint16_t, static_cast<std::size_t>(kSide * kSide)> sums{};
  std::vector<const std::uint8_t*> windows;
  windows.reserve(turned.size());
  for (const RotatedPoint& p : turned) {
    const int x = tile.x + p.x, y = tile.y + p.y;
    if (images.contains(x, y) && images.contains(x + kCells - 1, y + kCells - 1))
      windows.push_back(images.at(p.image, x, y));
  }
  const std::size_t outside = turned.size() - windows.size();
  sums.fill(static_cast<std::uint16_t>(outside * BoundImages::kUnknown));
  const std::ptrdiff_t step = 4 * static_cast<std::ptrdiff_t>(images.width());
  std::size_t n = 0;
  for (; n + kTogether <= windows.size(); n += kTogether) {
    const std::uint8_t *a = windows[n], *b = windows[n + 1], *c = windows[n + 2],
                       *d = windows[n + 3];
    std::uint16_t* sum = sums.data();
    for (int row = 0; row < kSide; ++row, sum += kSide) {
      for (int i = 0; i < kSide; ++i) {
        const auto four = static_cast<std::uint8_t>(a[i] + b[i] + c[i] + d[i]);
        sum[i] = static_cast<std::uint16_t>(sum[i] + four);
      }
      a += step, b += step, c += step, d += step;
    }
  }
  for (; n < windows.size(); ++n) {
    const std::uint8_t* a = windows[n];
    std::uint16_t* sum = sums.data();
    for (int row = 0; row < kSide; ++row, sum += kSide, a += step) {
      for (int i = 0; i < kSide; ++i) sum[i] = static_cast<std::uint16_t>(sum[i] + a[i]);
    }
  }
  const int limit = std::max(sumFor(config.min_score), dropped);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const int sum = sums[static_cast<std::size_t>(row * kSide + column)];
      const int x = tile.x + 4 * column, y = tile.y + 4 * row;
      if (sum >= limit && images.isFree(x, y)) push({sum, 0, next_yaw, x, y});
    }
  }
}

void GlobalSearch::State::push(const Node& node) {
  nodes.push_back(node);
  if (is_heap) {
    std::push_heap(nodes.begin(), nodes.end(), isWorse);
  } else if (nodes.size() >= kMostNodes) {
    cut();
  }
}

/// Only the better half of the nodes is kept.
void GlobalSearch::State::cut() {
  const auto half = nodes.begin() + static_cast<std::ptrdiff_t>(nodes.size() / 2);
  std::nth_element(nodes.begin(), half, nodes.end(),
                   [](const Node& a, const Node& b) { return isWorse(b, a); });
  dropped = std::max(dropped, half->sum);
  nodes.erase(half, nodes.end());
}

void GlobalSearch::State::expand(const Node& node) {
  const int level = node.level + 1, side = 4 >> level, limit = least();
  bounds_of_points.set(images, rotated(node.level, node.k), node.x, node.y);
  for (int half = 0; half < 2; ++half) {
    const int k = 2 * node.k + half;
    const std::vector<RotatedPoint>& turned = rotated(level, k);
    for (int y = node.y; y < node.y + 2 * side; y += side) {
      for (int x = node.x; x < node.x + 2 * side; x += side) {
        const int sum = std::min(node.sum, bounds_of_points.within(images, turned, x, y, limit));
        if (sum >= limit) push({sum, level, k, x, y});
      }
    }
  }
  lookups += bounds_of_points.takeLookups();
}

Pose2 GlobalSearch::State::poseOf(const Node& node) const {
  const double step = kTwoPi / (static_cast<double>(yaws) * (1 << node.level));
  return {images.corner().x() + node.x * images.cell(),
          images.corner().y() + node.y * images.cell(), normalizeAngle((node.k + 0.5) * step)};
}

double GlobalSearch::State::scoreAt(const Pose2& pose) const {
  int sum = 0;
  for (const Eigen::Vector2f& p : points) {
    const Eigen::Vector2d at =
        ((pose * p.cast<double>()) - images.corner()).array() / images.cell();
    sum += images.likelihood(static_cast<int>(std::floor(at.x())),
                             static_cast<int>(std::floor(at.y())));
  }
  return scoreFor(sum);
}

bool GlobalSearch::State::isKnown(const Pose2& pose) const {
  return std::any_of(found.begin(), found.end(), [&](const GlobalHypothesis& other) {
    return isNear({other.pose, config.same_m, config.same_rad}, pose);
  });
}

/// A single pose of the grid: the optimum beside it may be an explanation.
void GlobalSearch::State::look(const Node& node) {
  const Pose2 pose = poseOf(node);
  if (isKnown(pose)) return;
  const double score = scoreAt(pose);
  lookups += static_cast<std::int64_t>(points.size());
  if (score + kDescentGain < leastScore()) return;
  lookups += kSketchLookups * static_cast<std::int64_t>(points.size());
  const Pose2 better = sketch(map.map().surface(), points, pose);
  const double improved = scoreAt(better);
  add(improved > score ? better : pose, std::max(score, improved));
}

void GlobalSearch::State::add(const Pose2& pose, double score) {
  if (score < leastScore()) return;
  const auto same = std::find_if(found.begin(), found.end(), [&](const GlobalHypothesis& other) {
    return isNear({other.pose, config.same_m, config.same_rad}, pose);
  });
  if (same == found.end()) {
    found.push_back({pose, score});
  } else if (score > same->score) {
    *same = {pose, score};
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.score > b.score; });
  if (found.size() > config.most) found.pop_back();
  while (found.back().score < leastScore()) found.pop_back();
}

GlobalSearch::GlobalSearch(const GlobalMap& map, const Points& points,
                           const GlobalSearchConfig& config)
    : state_(std::make_unique<State>(map, points, config)) {}
GlobalSearch::~GlobalSearch() = default;
GlobalSearch::GlobalSearch(GlobalSearch&&) noexcept = default;
GlobalSearch& GlobalSearch::operator=(GlobalSearch&&) noexcept = default;

bool GlobalSearch::run(WorkBudget& budget) { return state_->run(budget); }
bool GlobalSearch::isDone() const { return state_->done; }
bool GlobalSearch::isComplete() const { return state_->done && state_->dropped <= state_->least(); }
const std::vector<GlobalHypothesis>& GlobalSearch::hypotheses() const { return state_->found; }

std::size_t GlobalSearch::memoryBytes() const {
  std::size_t bytes = sizeof(State) + state_->nodes.capacity() * sizeof(Node);
  for (const auto& level : state_->rotations) {
    for (const auto& points : level) bytes += points.capacity() * sizeof(RotatedPoint);
  }
  return bytes;
}

}  // namespace kestrel
