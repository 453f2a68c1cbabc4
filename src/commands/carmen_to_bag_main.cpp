// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <string>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/recording/bag/bag_writer.h"
#include "kestrel_slam/recording/carmen_log.h"

namespace kestrel {
namespace {

struct Options {
  std::string log, bag;
  BagStamps stamps = BagStamps::kRecorded;
};

void run(const Options& options) {
  if (!looksLikeCarmenLog(options.log)) {
    throw std::runtime_error(
        options.log +
        ": is not a CARMEN log (plain, .bz2 or .gz) with FLASER or ROBOTLASER1 lines");
  }
  CarmenLog log(options.log);
  const BagSummary summary = writeBag(options.bag, log, options.stamps);
  for (const std::string& warning : log.warnings()) {
    std::fprintf(stderr, "warning: %s\n", warning.c_str());
  }
  for (const auto& [reason, count] : log.skipped()) {
    std::fprintf(stderr, "warning: %zu scans skipped: %s\n", count, reason.c_str());
  }
  if (summary.unwritable > 0) {
    std::fprintf(stderr, "warning: %zu scans skipped: ROS cannot represent their stamp\n",
                 summary.unwritable);
  }
  std::printf("%s: %zu scans from %s\n", options.bag.c_str(), summary.scans,
              log.description().c_str());
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Converts a CARMEN log to a rosbag with /scan, /odom, /tf and /tf_static.\n"
      "Exit code 0: done; 1: bad input; 2: wrong usage.");
  Options options;
  const std::map<std::string, BagStamps> choices = {{"recorded", BagStamps::kRecorded},
                                                    {"monotone", BagStamps::kMonotone}};
  app.add_option("log", options.log, "CARMEN log (plain, .bz2 or .gz)")->required();
  app.add_option("bag", options.bag, "bag to write")->required();
  app.add_option("--stamps", options.stamps,
                 "header stamps: recorded (as in the log, may jump back; default) or monotone "
                 "(corrected; for nodes that reject stamps that jump back)")
      ->transform(CLI::CheckedTransformer(choices, CLI::ignore_case));
  return runTool("carmen_to_bag", app, argc, argv, [&] { run(options); });
}
