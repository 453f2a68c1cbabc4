#include <cstdio>
#include <string>
#include <vector>

#include "kestrel_slam/tools/consistency.h"
#include "kestrel_slam/tools/filter_measurement.h"
#include "kestrel_slam/tools/run_tool.h"

namespace kestrel_slam {
namespace {

struct Options {
  std::string only;
  int seed = 1;
};

void report(const std::string& name, const FilterMeasurement& m) {
  std::printf("%s: xy %.4f (max %.3f) z %.4f v %.4f tilt %.3f yaw %.3f step %.2f (%.4f m) | mapper %.4f scans %zu lost %zu searched %zu iterations %.2f\n", name.c_str(),
              m.xy_rmse_m, m.xy_max_m, m.z_rmse_m, m.velocity_rmse, m.tilt_rmse_deg, m.yaw_rmse_deg, m.worst_step, m.largest_step_m,
              m.mapper_rmse_m, m.scans, m.lost, m.searched, m.iterations);
  Eigen::Vector<double, 5> blocks = Eigen::Vector<double, 5>::Zero();
  for (const auto& b : m.block_nees) blocks += b / static_cast<double>(m.block_nees.size());
  std::printf("   NEES %.2f blocks %.2f %.2f %.2f %.2f %.2f anchors %zu\n", meanOf(m.nees), blocks(0), blocks(1), blocks(2), blocks(3), blocks(4), m.status.anchors);
  for (std::size_t i = 0; i < kFilterSensors; ++i) {
    const SensorCounts& c = m.status.sensors[i];
    if (c.received == 0) continue;
    std::printf("   %s: %zu received %zu accepted", toString(static_cast<FilterSensor>(i)), c.received, c.accepted);
    for (const auto& [r, n] : c.rejected) std::printf(", %s %zu", r.c_str(), n);
    std::printf("\n");
  }
  for (const auto& [r, n] : m.status.resets) std::printf("   reset %s %zu\n", r.c_str(), n);
}

}  // namespace
}  // namespace kestrel_slam

int main(int argc, char** argv) {
  using namespace kestrel_slam;
  Options options;
  CLI::App app("Runs the pose filter on simulated flights and prints its errors against the truth.");
  app.add_option("--only", options.only, "place");
  app.add_option("--seed", options.seed, "seed");
  return runTool("measure_filter", app, argc, argv, [&] {
    FilterTrial trial;
    trial.flight = flightIn(options.only, options.only);
    trial.flight.seed = static_cast<std::uint64_t>(options.seed);
    for (const int mode : {0, 1, 2, 3}) {
      trial.coupling.attitude = (mode & 1) != 0;
      trial.coupling.prediction = (mode & 2) != 0;
      report(options.only + (mode & 1 ? " attitude" : "") + (mode & 2 ? " prediction" : ""), measureFilter(trial));
    }
  });
}
