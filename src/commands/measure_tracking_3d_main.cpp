// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/experiments/lidar_measurement.h"

namespace kestrel {
namespace {

struct Options {
  int frames = 200;
  std::string only, lidar;
  double height = 0.0;
};

constexpr double kPercent = 100.0, kMegabyte = 1e6;

void printErrors(const char* name, const PoseErrors& errors) {
  static const char* const kColumns[] = {"roll, rad", "pitch, rad", "yaw, rad",
                                         "x, m",      "y, m",       "z, m"};
  for (int i = 0; i < 6; ++i) {
    std::printf("| %s %s | %.4f | %+.2e | %.2e |\n", name, kColumns[i], errors.max(i),
                errors.mean()(i), errors.sigma()(i));
  }
}

void printMot(const char* name, const ClearMot& m) {
  std::printf("| %s | %zu | %.1f | %.2f | %zu | %zu | %zu |\n", name, m.truths, kPercent * m.mota(),
              m.motp(), m.misses, m.false_tracks, m.switches);
}

void runScene(TrafficScene scene, const Options& options) {
  scene.frames = options.frames;
  for (const LidarModel& lidar : lidarModels()) {
    if (lidar.name == options.lidar) scene.lidar = lidar;
  }
  if (options.height > 0.0) scene.lidar_height_m = options.height;
  const LidarMeasurement m = measureScene(scene, CloudTrackerConfig());
  std::printf("\n### %s, %s, %d frames of %.0f points\n\n", scene.name.c_str(),
              scene.lidar.name.c_str(), scene.frames, m.mean_points);
  std::printf("| error | largest | mean | sigma |\n|---|---|---|---|\n");
  printErrors("change of", m.change);
  printErrors("pose", m.pose);
  std::printf("\nlargest error of a change of pose: %.4f m, %.4f deg; maps: %.0f MB\n\n",
              m.largest_step_m, m.largest_turn_deg, static_cast<double>(m.memory) / kMegabyte);
  std::printf("| objects | number | MOTA, %% | MOTP, m | misses | false | switches |\n");
  std::printf("|---|---|---|---|---|---|---|\n");
  printMot("all", m.objects);
  printMot("vehicles", m.vehicles);
  printMot("pedestrians and cyclists", m.pedestrians);
  std::printf("\nmoving points: IoU %.1f %% (%zu right, %zu missed, %zu wrong)\n",
              kPercent * m.points.iou(), m.points.right, m.points.missed, m.points.wrong);
  std::fflush(stdout);
}

void run(const Options& options) {
  if (options.only.empty() || options.only == "crossing") runScene(crossingScene(), options);
  if (options.only.empty() || options.only == "street") runScene(streetScene(), options);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  Options options;
  CLI::App app(
      "Measures localization and tracking with a 3D lidar: prints rows of doc/results.md.");
  app.add_option("--frames", options.frames, "frames of each simulated scene")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--only", options.only, "only this scene")
      ->check(CLI::IsMember({"crossing", "street"}));
  app.add_option("--lidar", options.lidar, "another lidar than that of the scene")
      ->check(CLI::IsMember({"vlp16", "hdl32e", "hdl64e"}));
  app.add_option("--height", options.height, "M: another height of the lidar above the ground")
      ->check(CLI::PositiveNumber);
  return runTool("measure_tracking_3d", app, argc, argv, [&] { run(options); });
}
