// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/global_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "bound_images.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/matching/correlative.h"
#include "search_node.h"
#include "sketch.h"
#include "spread_points.h"
#include "strip_bounds.h"
#include "tile_bounds.h"

namespace kestrel {
namespace {

/// Half of a yaw step moves the median point by this, and the farthest one at most by this, cells.
constexpr double kMedianReach = 1.0, kMostReach = 8.0;
constexpr std::size_t kMostNodes = 1'000'000;
/// Nodes are divided in batches, which grow as the search goes on.
constexpr std::size_t kLeastBatch = 16, kMostBatch = 16384;
constexpr double kTwoPi = 2.0 * kPi;
/// The score may rise by this from a pose of the grid to the optimum beside it.
constexpr double kDescentGain = 0.1;
/// Work of a row of a tile for four points, of a tile, of one look-up, and of one node in the heap.
constexpr std::int64_t kWorkPerRow = 12, kWorkPerTile = 2000, kWorkPerLookup = 6, kWorkPerNode = 60;
/// A descent costs so many look-ups for each point.
constexpr std::int64_t kSketchLookups = 40;

}  // namespace

GlobalMap::GlobalMap(const Submap& map) : map_(map), images_(std::make_unique<BoundImages>(map)) {}
GlobalMap::~GlobalMap() = default;
std::size_t GlobalMap::memoryBytes() const { return images_->memoryBytes(); }

struct GlobalSearch::State {
  State(const GlobalMap& m, const Points& all, const GlobalSearchConfig& c);

  bool run(WorkBudget& budget);
  bool bounds(WorkBudget& budget);
  bool fillBatch();
  void boundTile(const std::vector<RotatedPoint>& turned, const BoundImages::Tile& tile);
  void expand(const SearchNode& node);
  void divide(const SearchNode& node, int k, int x, int y, int limit);
  void look(const SearchNode& node);
  void add(const Pose2& pose, double score);
  bool isKnown(const Pose2& pose) const;
  void push(const SearchNode& node);
  void cut();

  bool isInRegion(int x, int y, int side) const;
  Pose2 poseOf(const SearchNode& node) const;
  const RotatedPoints& rotated(int level, int k);
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
  Points cells;                          ///< the points in cells
  std::vector<BoundImages::Tile> tiles;  ///< with poses in the region
  int yaws = 1;                          ///< of the coarsest level
  int next_yaw = 0;
  std::size_t next_tile = 0;
  std::array<std::vector<RotatedPoints>, BoundImages::kLevels> rotations;
  std::vector<SearchNode> nodes;           ///< a heap as soon as all bounds are known
  std::vector<SearchNode> batch;           ///< the next ones, in reverse order
  std::size_t divided = 0;                 ///< nodes so far
  int dropped = 0;                         ///< largest sum of the nodes that were left out
  StripBounds strip;                       ///< that is being divided
  std::int64_t lookups = 0;                ///< that are not yet counted as work
  std::unordered_set<std::int64_t> tried;  ///< places from which there was a descent
  bool is_heap = false, done = false;
  std::vector<GlobalHypothesis> found;
};

GlobalSearch::State::State(const GlobalMap& m, const Points& all, const GlobalSearchConfig& c)
    : map(m), images(m.images()), config(c), points(spreadPoints(all, StripBounds::kTogether)) {
  for (const BoundImages::Tile& tile : images.tiles()) {
    if (isInRegion(tile.x, tile.y, BoundImages::kTileCells)) tiles.push_back(tile);
  }
  done = points.empty() || tiles.empty();
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

const RotatedPoints& GlobalSearch::State::rotated(int level, int k) {
  RotatedPoints& result = rotations[static_cast<std::size_t>(level)][static_cast<std::size_t>(k)];
  if (!result.empty()) return result;
  const double step = kTwoPi / (static_cast<double>(yaws) * (1 << level));
  const double yaw = (k + 0.5) * step;
  const double c = std::cos(yaw), s = std::sin(yaw);
  std::vector<RotatedPoint> turned;
  turned.reserve(cells.size());
  for (const Eigen::Vector2f& cell : cells) {
    const Eigen::Vector2d p = cell.cast<double>();
    const Eigen::Vector2d at(c * p.x() - s * p.y(), s * p.x() + c * p.y());
    const double reach = 0.5 * step * p.norm();
    const auto low = (at.array() - reach).floor().cast<int>().eval();
    const auto high = (at.array() + reach).floor().cast<int>().eval();
    const int side = (high - low).maxCoeff() + (4 >> level);
    turned.push_back({low.x(), low.y(), BoundImages::imageFor(side)});
  }
  return result = RotatedPoints(images, std::move(turned));
}

bool GlobalSearch::State::run(WorkBudget& budget) {
  if (done || !bounds(budget)) return done;
  if (!is_heap) {
    std::make_heap(nodes.begin(), nodes.end(), isWorse);
    is_heap = true;
  }
  while (fillBatch()) {
    const SearchNode node = batch.back();
    if (node.sum < least()) {
      batch.pop_back();
      continue;
    }
    if (!budget.take(kWorkPerNode + kWorkPerLookup * lookups)) return false;
    lookups = 0;
    batch.pop_back();
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

/// Takes the best nodes from the heap. So that what one needs is still in the cache for the next
/// one, they are sorted by place. Returns whether there are nodes of interest.
bool GlobalSearch::State::fillBatch() {
  if (!batch.empty()) return true;
  const std::size_t size = std::clamp(divided / 2, kLeastBatch, kMostBatch);
  while (batch.size() < size && !nodes.empty() && nodes.front().sum >= least()) {
    std::pop_heap(nodes.begin(), nodes.end(), isWorse);
    batch.push_back(nodes.back());
    nodes.pop_back();
  }
  divided += batch.size();
  // The last one is the first to be used.
  std::sort(batch.begin(), batch.end(), isAfter);
  return !batch.empty();
}

/// Whether the square of cells from (x, y) on may touch the region.
bool GlobalSearch::State::isInRegion(int x, int y, int side) const {
  if (!config.region) return true;
  const double half = 0.5 * side * images.cell();
  const Eigen::Vector2d middle =
      images.corner() + Eigen::Vector2d(x, y) * images.cell() + Eigen::Vector2d::Constant(half);
  return (middle - config.region->center).norm() <= config.region->radius_m + std::sqrt(2.0) * half;
}

/// The bounds of all blocks of the coarsest level. Returns whether all are known.
bool GlobalSearch::State::bounds(WorkBudget& budget) {
  const auto additions = static_cast<std::int64_t>(points.size() / 4 + 4);
  const std::int64_t work = kWorkPerTile + kWorkPerRow * additions * BoundImages::kTileBlocks;
  for (; next_yaw < yaws; ++next_yaw) {
    const std::vector<RotatedPoint>& turned = rotated(0, next_yaw).points();
    for (; next_tile < tiles.size(); ++next_tile) {
      if (!budget.take(work)) return false;
      boundTile(turned, tiles[next_tile]);
    }
    next_tile = 0;
  }
  return true;
}

void GlobalSearch::State::boundTile(const std::vector<RotatedPoint>& turned,
                                    const BoundImages::Tile& tile) {
  constexpr int kSide = BoundImages::kTileBlocks;
  const TileSums sums = boundsIn(images, turned, tile);
  const int limit = std::max(sumFor(config.min_score), dropped);
  for (int row = 0; row < kSide; ++row) {
    SearchNode node{0, next_yaw, tile.x, tile.y + 4 * row, 0, 0};
    for (int column = 0; column < kSide; ++column) {
      const int sum = sums[static_cast<std::size_t>(row * kSide + column)];
      const int x = tile.x + 4 * column;
      if (sum < limit || !images.isFree(x, node.y) || !isInRegion(x, node.y, 4)) continue;
      node.sum = std::max(node.sum, sum);
      node.lanes = static_cast<std::uint16_t>(node.lanes | 1U << column);
    }
    if (node.lanes != 0) push(node);
  }
}

void GlobalSearch::State::push(const SearchNode& node) {
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
                   [](const SearchNode& a, const SearchNode& b) { return isWorse(b, a); });
  dropped = std::max(dropped, half->sum);
  nodes.erase(half, nodes.end());
}

void GlobalSearch::State::expand(const SearchNode& node) {
  const int side = 2 >> node.level, limit = least();
  strip.set(images, rotated(node.level, node.k), node.x, node.y, node.lanes);
  for (int k = 2 * node.k; k < 2 * node.k + 2; ++k) {
    for (int y = node.y; y < node.y + 2 * side; y += side) {
      for (int x = node.x; x < node.x + 2 * side; x += side) divide(node, k, x, y, limit);
    }
  }
  lookups += strip.takeLookups();
}

/// The parts of a strip from (x, y) on.
void GlobalSearch::State::divide(const SearchNode& node, int k, int x, int y, int limit) {
  const int level = node.level + 1;
  const unsigned lanes = strip.within(images, rotated(level, k), x, y, limit);
  if (lanes == 0) return;
  SearchNode part{0, k, x, y, static_cast<std::uint16_t>(level), static_cast<std::uint16_t>(lanes)};
  for (int i = 0; i < StripBounds::kLanes; ++i) {
    if ((lanes >> i & 1U) == 0) continue;
    const int sum = std::min<int>(node.sum, strip.sums()[static_cast<std::size_t>(i)]);
    if (level + 1 == BoundImages::kLevels) push({sum, k, x + 4 * i, y, part.level, 1});
    part.sum = std::max(part.sum, sum);
  }
  if (level + 1 < BoundImages::kLevels) push(part);
}

Pose2 GlobalSearch::State::poseOf(const SearchNode& node) const {
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
void GlobalSearch::State::look(const SearchNode& node) {
  const Pose2 pose = poseOf(node);
  if (isKnown(pose)) return;
  const double score = scoreAt(pose);
  lookups += static_cast<std::int64_t>(points.size());
  if (score + kDescentGain < leastScore()) return;
  // From poses beside each other the descent ends at the same place. The best comes first.
  const int blocks = 2 * images.width();
  const std::int64_t place =
      (static_cast<std::int64_t>(node.k >> 2) * blocks + node.y / 4) * blocks + node.x / 4;
  if (score < leastScore() && !tried.insert(place).second) return;
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
  std::size_t bytes =
      sizeof(State) + (state_->nodes.capacity() + state_->batch.capacity()) * sizeof(SearchNode);
  // A node of the set is a pointer and the number; the allocator adds as much.
  bytes += state_->tried.bucket_count() * sizeof(void*) +
           state_->tried.size() * 2 * (sizeof(void*) + sizeof(std::int64_t));
  for (const auto& level : state_->rotations) {
    bytes += level.capacity() * sizeof(RotatedPoints);
    for (const RotatedPoints& points : level) bytes += points.memoryBytes();
  }
  return bytes;
}

}  // namespace kestrel
