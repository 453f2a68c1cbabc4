// SPDX-License-Identifier: BSD-3-Clause
#include "rough_search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "rough_grid.h"

namespace kestrel {
namespace {

/// The largest size of a pixel, m, and how much larger it is in the first search of a large window.
constexpr double kPixelM = 0.2;
constexpr int kCoarser = 1;  // 2^kCoarser
/// Only the best pose of this many poses in x and y is a candidate.
constexpr int kBin = 4;
/// Number of candidates of the first search, and of hypotheses.
constexpr std::size_t kCandidates = 160, kHypotheses = 24;
/// Hypotheses are farther apart than this many pixels and angular steps.
constexpr double kApart = 2.0;
/// The window is divided into parts of this many pixels. A search does this many of them in turn,
/// apart from the one at the center, and more if there is some budget left.
constexpr int kPart = RoughPart::kSide;
constexpr int kInTurn = 4;

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
    return all_;
  }

 private:
  void cut() {
    std::sort(all_.begin(), all_.end(), isBetter);
    if (all_.size() < most_) return;
    all_.resize(most_);
    threshold_ = all_.back().score;
  }

  std::size_t most_;
  double threshold_ = 0.0;
  std::vector<Candidate> all_;
};

/// Searches in one size of pixels.
class Search {
 public:
  Search(const SurfelField& surface, const Points& points, const RoughWindow& window, int shift,
         std::size_t most)
      : surface_(surface),
        window_(window),
        grid_(surface, points, window, shift),
        ranking_(most) {}

  const RoughGrid& grid() const { return grid_; }
  const std::vector<Candidate>& best() { return ranking_.sorted(); }

  /// Returns false if the budget did not suffice for the whole window.
  bool searchWindow(WorkBudget& budget) {
    if (!makeImage(budget)) return false;
    const std::vector<RoughPart> parts = affordableParts(budget);
    for (int k = -grid_.angularSteps(); k <= grid_.angularSteps(); ++k) {
      grid_.rotate(*image_, k);
      for (const RoughPart& part : parts) rank(part, k);
    }
    return parts.size() == allParts().size();
  }

  /// Searches near the candidates of a search with larger pixels.
  bool searchNear(const RoughGrid& coarse, const std::vector<Candidate>& candidates,
                  WorkBudget& budget) {
    if (!makeImage(budget)) return false;
    const double linear = coarse.pixel() / grid_.pixel();
    const double angular = coarse.angularStep() / grid_.angularStep();
    const int turns = static_cast<int>(std::ceil(0.5 * angular));
    for (const Candidate& candidate : candidates) {
      const RoughPart part = within({static_cast<int>(std::floor((candidate.dx - 0.5) * linear)),
                                     static_cast<int>(std::floor((candidate.dy - 0.5) * linear)),
                                     kBin, kBin});
      const int k = static_cast<int>(std::lround(candidate.k * angular));
      if (!budget.take((2 * turns + 1) * (grid_.rotationWork() + grid_.sumWork(part)))) return false;
      for (int turn = -turns; turn <= turns; ++turn) {
        if (std::abs(k + turn) > grid_.angularSteps()) continue;
        grid_.rotate(*image_, k + turn);
        rank(part, k + turn);
      }
    }
    return true;
  }

 private:
  bool makeImage(WorkBudget& budget) {
    if (!budget.take(WallImage::workFor(grid_.box(), grid_.shift()))) return false;
    image_.emplace(surface_, grid_.box(), grid_.shift());
    return true;
  }

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
      const RoughPart part = within(
          {column * kPart - kPart / 2, row * kPart - kPart / 2, kPart, kPart});
      if (part.rows > 0 && part.columns > 0) parts.push_back(part);
    }
    return parts;
  }

  /// The part at the center, and as many others in turn as the budget allows.
  std::vector<RoughPart> affordableParts(WorkBudget& budget) const {
    const std::vector<RoughPart> all = allParts();
    const std::int64_t angles = 2 * grid_.angularSteps() + 1;
    std::vector<RoughPart> parts;
    if (!budget.take(angles * (grid_.rotationWork() + grid_.sumWork(all.front())))) return parts;
    parts.push_back(all.front());
    const std::size_t others = all.size() - 1;
    const std::size_t first = static_cast<std::size_t>(window_.turn) * kInTurn;
    for (std::size_t i = 0; i < others; ++i) {
      const RoughPart& part = all[1 + (first + i) % others];
      if (!budget.take(angles * grid_.sumWork(part))) break;
      parts.push_back(part);
    }
    return parts;
  }

  void rank(const RoughPart& part, int k) {
    grid_.sum(part, sums_);
    for (int y = 0; y < part.rows; y += kBin) {
      for (int x = 0; x < part.columns; x += kBin) rankBin(part, k, x, y);
    }
  }

  /// Adds the best pose of a square of poses to the ranking.
  void rankBin(const RoughPart& part, int k, int x, int y) {
    int best = -1, best_x = 0, best_y = 0;
    for (int row = y; row < std::min(y + kBin, part.rows); ++row) {
      for (int column = x; column < std::min(x + kBin, part.columns); ++column) {
        const int sum = sums_[static_cast<std::size_t>(row * kPart + column)];
        if (sum > best) best = sum, best_x = part.dx + column, best_y = part.dy + row;
      }
    }
    const double penalty =
        window_.preferences.linear_preference * grid_.pixel() * std::hypot(best_x, best_y) +
        window_.preferences.angular_preference * std::abs(k) * grid_.angularStep();
    const double score = grid_.score(best) - penalty;
    if (score <= ranking_.threshold()) return;
    if (isNear(window_.excluded, grid_.pose(k, best_x, best_y))) return;
    ranking_.add({score, k, best_x, best_y});
  }

  const SurfelField& surface_;
  RoughWindow window_;
  RoughGrid grid_;
  Ranking ranking_;
  std::optional<WallImage> image_;
  RoughGrid::Sums sums_{};
};

/// The best candidates that are not near a better one.
std::vector<Pose2> distinct(const RoughGrid& grid, const std::vector<Candidate>& candidates) {
  std::vector<Pose2> poses;
  for (const Candidate& candidate : candidates) {
    const Pose2 pose = grid.pose(candidate.k, candidate.dx, candidate.dy);
    const auto isSame = [&](const Pose2& other) {
      return (pose.translation() - other.translation()).norm() <= kApart * grid.pixel() &&
             std::abs(normalizeAngle(pose.yaw - other.yaw)) <= kApart * grid.angularStep();
    };
    if (std::any_of(poses.begin(), poses.end(), isSame)) continue;
    poses.push_back(pose);
    if (poses.size() == kHypotheses) break;
  }
  return poses;
}

/// The largest pixels that are not larger than kPixelM.
int pixelShift(double cell_m) {
  int shift = 0;
  while (shift + 1 < kTileShift && cell_m * (2 << shift) <= kPixelM * (1.0 + 1e-6)) ++shift;
  return shift;
}

}  // namespace

Hypotheses searchRoughly(const SurfelField& surface, const Points& points,
                         const RoughWindow& window, WorkBudget& budget) {
  const int shift = pixelShift(static_cast<double>(surface.resolution()));
  Hypotheses result;
  Search fine(surface, points, window, shift, 4 * kCandidates);
  if (fine.grid().linearSteps() < kPart / 2) {
    result.complete = fine.searchWindow(budget);
  } else {
    Search coarse(surface, points, window, shift + kCoarser, kCandidates);
    result.complete = coarse.searchWindow(budget);
    result.complete &= fine.searchNear(coarse.grid(), coarse.best(), budget);
  }
  result.poses = distinct(fine.grid(), fine.best());
  return result;
}

}  // namespace kestrel
