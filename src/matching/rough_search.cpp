// SPDX-License-Identifier: BSD-3-Clause
#include "rough_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>

#include "rough_grid.h"

namespace kestrel {
namespace {

/// The sizes of pixels, m: the small one where the whole window can be searched with it.
constexpr double kSearchPixelM = 0.2;
constexpr int kCoarser = 1;  // 2^kCoarser times as large
/// Only the best pose of a square of this size is a candidate.
constexpr double kBinM = 0.8;
/// Number of candidates and of hypotheses. Hypotheses are farther apart than this.
constexpr std::size_t kCandidates = 200, kHypotheses = 32;
constexpr double kApartM = 0.41, kApartSteps = 2.0;
/// The window is divided into parts of this many pixels.
constexpr int kPart = RoughPart::kSide;

struct Candidate {
  double score;
  int k, dx, dy;
};

bool isBetter(const Candidate& a, const Candidate& b) {
  return std::tie(b.score, a.k, a.dy, a.dx) < std::tie(a.score, b.k, b.dy, b.dx);
}

/// The best candidates so far.
class Ranking {
 public:
  explicit Ranking(std::size_t most) : most_(most) {}

  /// A candidate with this score, or a lower one, is not among the best.
  double threshold() const { return threshold_; }
  void add(const Candidate& candidate) {
    all_.push_back(candidate);
    if (all_.size() >= 4 * most_) cut();
  }
  const std::vector<Candidate>& sorted() {
    cut();
    std::sort(all_.begin(), all_.end(), isBetter);
    return all_;
  }

 private:
  void cut() {
    if (all_.size() < most_) return;
    const auto last = all_.begin() + static_cast<std::ptrdiff_t>(most_ - 1);
    std::nth_element(all_.begin(), last, all_.end(), isBetter);
    threshold_ = last->score;
    all_.resize(most_);
  }

  std::size_t most_;
  double threshold_ = 0.0;
  std::vector<Candidate> all_;
};

/// Searches in one size of pixels.
class Search {
 public:
  Search(const SurfelField& surface, const Points& points, const RoughWindow& window, int shift)
      : surface_(surface),
        window_(window),
        grid_(surface, points, window, shift),
        bin_(std::max(1, static_cast<int>(std::lround(kBinM / grid_.pixel())))),
        ranking_(kCandidates) {}

  /// The work for the whole window.
  std::int64_t work() const {
    std::int64_t work = grid_.imageWork();
    for (const RoughPart& part : allParts()) work += angles() * grid_.sumWork(part);
    return work + angles() * grid_.rotationWork();
  }

  /// Searches the part at the center, and as many others in turn as the budget allows.
  Hypotheses run(WorkBudget& budget) {
    Hypotheses result;
    const std::vector<RoughPart> parts = affordableParts(budget);
    result.complete = parts.size() == allParts().size();
    if (parts.empty() || grid_.score(1) <= 0.0) return result;
    const std::shared_ptr<const WallImage> image = imageOf();
    for (int k = -grid_.angularSteps(); k <= grid_.angularSteps(); ++k) {
      grid_.rotate(*image, k);
      for (const RoughPart& part : parts) rank(part, k);
    }
    result.poses = distinct();
    return result;
  }

 private:
  /// The image of another search for the same scan, if it shows all that the points can reach.
  std::shared_ptr<const WallImage> imageOf() const {
    if (window_.memory == nullptr) return grid_.imageOf(surface_);
    window_.memory->use(surface_);
    if (!grid_.isIn(window_.memory->image().get())) window_.memory->keep(grid_.imageOf(surface_));
    return window_.memory->image();
  }

  std::int64_t angles() const { return 2 * grid_.angularSteps() + 1; }

  RoughPart within(RoughPart part) const {
    const int steps = grid_.linearSteps();
    const int x1 = std::min(part.dx + part.columns, steps + 1);
    const int y1 = std::min(part.dy + part.rows, steps + 1);
    part.dx = std::clamp(part.dx, -steps, steps);
    part.dy = std::clamp(part.dy, -steps, steps);
    part.columns = std::max(x1 - part.dx, 0);
    part.rows = std::max(y1 - part.dy, 0);
    return part;
  }

  /// All parts of the window, nearest to the center first.
  std::vector<RoughPart> allParts() const {
    const int beside = std::max(0, grid_.linearSteps() + kPart / 2) / kPart;
    std::vector<std::tuple<int, int, int>> places;  // squared distance, row, column
    for (int row = -beside; row <= beside; ++row) {
      for (int column = -beside; column <= beside; ++column) {
        places.emplace_back(row * row + column * column, row, column);
      }
    }
    std::sort(places.begin(), places.end());
    std::vector<RoughPart> parts;
    for (const auto& [distance, row, column] : places) {
      const RoughPart part =
          within({column * kPart - kPart / 2, row * kPart - kPart / 2, kPart, kPart});
      if (part.rows > 0 && part.columns > 0) parts.push_back(part);
    }
    return parts;
  }

  /// The part at the center, and as many others in turn as the budget allows.
  std::vector<RoughPart> affordableParts(WorkBudget& budget) const {
    const std::vector<RoughPart> all = allParts();
    std::vector<RoughPart> result;
    const std::int64_t center = grid_.rotationWork() + grid_.sumWork(all.front());
    if (!budget.take(grid_.imageWork() + angles() * center)) return result;
    result.push_back(all.front());
    const std::size_t others = all.size() - 1;
    // So many parts are certain to fit into the budget: the next search goes on after them.
    const std::int64_t in_turn =
        std::max<std::int64_t>(1, budget.left() / (angles() * grid_.sumWork({0, 0, kPart, kPart})));
    const std::size_t first = static_cast<std::size_t>(window_.turn * in_turn);
    for (std::size_t i = 0; i < others; ++i) {
      const RoughPart& part = all[1 + (first + i) % others];
      if (!budget.take(angles() * grid_.sumWork(part))) break;
      result.push_back(part);
    }
    return result;
  }

  void rank(const RoughPart& part, int k) {
    grid_.sum(part, sums_);
    // Most parts, and most squares of the others, have no pose that can be among the best.
    const MostOfColumns of_part = mostOfColumns(0, part.rows);
    if (*std::max_element(of_part.begin(), of_part.end()) <= leastSum()) return;
    for (int y = 0; y < part.rows; y += bin_) {
      const MostOfColumns most = mostOfColumns(y, std::min(y + bin_, part.rows));
      for (int x = 0; x < part.columns; x += bin_) {
        const auto first = most.begin() + x;
        const auto last = most.begin() + std::min(x + bin_, part.columns);
        const int best = *std::max_element(first, last);
        if (best > leastSum()) add(part, k, x, y, best);
      }
    }
  }

  /// The largest sum of each column in the rows [first, last).
  using MostOfColumns = std::array<std::int16_t, kPart>;
  MostOfColumns mostOfColumns(int first, int last) const {
    MostOfColumns most{};
    const std::int16_t* sum = sums_.data() + first * kPart;
    for (int row = first; row < last; ++row, sum += kPart) {
      for (std::size_t i = 0; i < kPart; ++i) most[i] = std::max(most[i], sum[i]);
    }
    return most;
  }

  /// A pose with this sum, or a lower one, is not among the best.
  int leastSum() const { return static_cast<int>(ranking_.threshold() / grid_.score(1)); }

  /// Adds the best pose of the square of poses that begins at (x, y) to the ranking: the first one
  /// with the sum `best`.
  void add(const RoughPart& part, int k, int x, int y, int best) {
    int column = x, row = y;
    const int end = std::min(x + bin_, part.columns);
    while (sums_[static_cast<std::size_t>(row * kPart + column)] != best) {
      if (++column == end) column = x, ++row;
    }
    const int best_x = part.dx + column, best_y = part.dy + row;
    const double penalty =
        window_.preferences.linear_preference * grid_.pixel() * std::hypot(best_x, best_y) +
        window_.preferences.angular_preference * std::abs(k) * grid_.angularStep();
    const double score = grid_.score(best) - penalty;
    if (score <= ranking_.threshold()) return;
    if (isNear(window_.excluded, grid_.pose(k, best_x, best_y))) return;
    ranking_.add({score, k, best_x, best_y});
  }

  /// The best candidates that are not near a better one.
  std::vector<Pose2> distinct() {
    std::vector<Pose2> poses;
    for (const Candidate& candidate : ranking_.sorted()) {
      const Pose2 pose = grid_.pose(candidate.k, candidate.dx, candidate.dy);
      const auto isSame = [&](const Pose2& other) {
        // Most are too far apart in one direction.
        return std::abs(pose.x - other.x) <= kApartM && std::abs(pose.y - other.y) <= kApartM &&
               (pose.translation() - other.translation()).norm() <= kApartM &&
               std::abs(normalizeAngle(pose.yaw - other.yaw)) <= kApartSteps * grid_.angularStep();
      };
      if (std::any_of(poses.begin(), poses.end(), isSame)) continue;
      poses.push_back(pose);
      if (poses.size() == kHypotheses) break;
    }
    return poses;
  }

  const SurfelField& surface_;
  RoughWindow window_;
  RoughGrid grid_;
  int bin_;  ///< in pixels
  Ranking ranking_;
  RoughGrid::Sums sums_{};
};

/// The largest pixels that are not larger than kSearchPixelM.
int pixelShift(double cell_m) {
  int shift = 0;
  while (shift + 1 + kCoarser < kTileShift && cell_m * (2 << shift) <= kSearchPixelM * (1.0 + 1e-6))
    ++shift;
  return shift;
}

}  // namespace

Hypotheses searchRoughly(const SurfelField& surface, const Points& points,
                         const RoughWindow& window, WorkBudget& budget) {
  const int shift = pixelShift(static_cast<double>(surface.resolution()));
  Search fine(surface, points, window, shift);
  if (fine.work() <= budget.left() / 4) return fine.run(budget);
  return Search(surface, points, window, shift + kCoarser).run(budget);
}

}  // namespace kestrel
