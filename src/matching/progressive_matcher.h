// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/matching/progressive.h"

namespace kestrel {

/// Sampled candidates of the motion model vote on 20, 10 and 5 cm [Xie 2010]. If the fit is poor,
/// the other initial guesses and then wider samples are tried. The paper does not need this,
/// because its vehicle drives on roads.
class ProgressiveMatcher : public Matcher {
 public:
  explicit ProgressiveMatcher(const MatcherConfig& config)
      : config_(config), refiner_(config.progressive) {}
  MatchResult match(const Submap& map, const MatchRequest& request) const override;

 private:
  struct Candidate {
    Refinement refinement;
    Pose2 pose;
    Fit fit;
  };

  Candidate refine(const Submap& map, const MatchRequest& request,
                   const Pose2& initial_guess) const;
  void search(const Submap& map, const MatchRequest& request, MatchResult& result,
              Candidate& best) const;

  MatcherConfig config_;
  ProgressiveRefiner refiner_;
};

}  // namespace kestrel
