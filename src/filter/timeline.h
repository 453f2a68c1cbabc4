// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "filter_state.h"
#include "measurement.h"

namespace kestrel {

/// The last moments of the filter: its state at every IMU sample, and what was measured in between.
/// A measurement that comes late is put into its place, and everything since then is repeated.
class Timeline {
 public:
  struct Node {
    ImuInput input;       ///< mean over the step that ends here
    bool is_gap = false;  ///< the IMU was silent during that
    Eigen::Isometry3d odom_T_base = Eigen::Isometry3d::Identity();
    std::vector<Measurement> measurements;  ///< of the step that ends here, ascending
    FilterState state;                      ///< after all of that
  };
  /// Hears of every measurement once, when it is applied for the first time.
  using Judge = std::function<void(const Measurement&, const Verdict&)>;

  Timeline(const PoseFilterConfig& config, Judge judge);

  /// Forgets everything, and begins with `state`; measurements that wait and are newer stay.
  void begin(const FilterState& state, const Eigen::Isometry3d& odom_T_base);
  void clear();  ///< forgets everything, also what waits
  bool empty() const { return nodes_.empty(); }

  /// One step to `stamp`. A step over a gap is uncertain.
  void step(double stamp, const ImuInput& input, bool gap);

  /// Puts a measurement into its place. Empty, or why it cannot be used.
  std::string insert(const Measurement& measurement);

  Node& newest() { return nodes_.back(); }
  const Node& newest() const { return nodes_.back(); }
  const Node* lastNotAfter(double stamp) const;  ///< null: too old
  const Node* after(const Node& node) const;     ///< null: it is the newest

 private:
  std::string keepForLater(const Measurement& measurement);
  void compute(const FilterState& before, Node& node);

  PoseFilterConfig config_;
  Judge judge_;
  std::deque<Node> nodes_;
  std::vector<Measurement> waiting_;  ///< newer than the newest node, ascending
};

}  // namespace kestrel
