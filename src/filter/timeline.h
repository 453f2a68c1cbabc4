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

/// The recent history of the filter: its state at every IMU step and the measurements between. A
/// late measurement is inserted at its time, and all later steps are repeated.
class Timeline {
 public:
  struct Node {
    InertialInput input;  ///< mean over the step that ends here
    bool is_gap = false;  ///< the IMU was silent during this step
    Eigen::Isometry3d odom_T_base = Eigen::Isometry3d::Identity();
    std::vector<Measurement> measurements;  ///< in this step, ascending stamps
    FilterState state;                      ///< at the end of the step
  };
  /// Called once for every measurement, when it is applied for the first time.
  using Judge = std::function<void(const Measurement&, const Verdict&)>;

  Timeline(const PoseFilterConfig& config, Judge judge);

  /// Clears everything and begins with `state`. Waiting measurements that are newer are kept.
  void begin(const FilterState& state, const Eigen::Isometry3d& odom_T_base);
  void clear();  ///< clears everything, including waiting measurements
  bool empty() const { return nodes_.empty(); }

  /// Adds a step to `stamp` (s). `gap`: adds the uncertainty of a gap.
  void step(double stamp, const InertialInput& input, bool gap);

  /// Inserts a measurement at its time. Returns an empty text, or the reason why it is rejected.
  std::string insert(const Measurement& measurement);

  Node& newest() { return nodes_.back(); }
  const Node& newest() const { return nodes_.back(); }
  const Node* lastNotAfter(double stamp) const;  ///< null if too old
  const Node* after(const Node& node) const;     ///< null if it is the newest

 private:
  std::string keepForLater(const Measurement& measurement);
  void compute(const FilterState& before, Node& node);

  PoseFilterConfig config_;
  Judge judge_;
  std::deque<Node> nodes_;
  std::vector<Measurement> waiting_;  ///< measurements newer than the newest node, ascending
};

}  // namespace kestrel
