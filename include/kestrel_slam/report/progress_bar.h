// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdio>
#include <string>

#include "kestrel_slam/offline/offline_run.h"

namespace kestrel {

/// Shows the progress of a run: on a terminal as a bar that is updated in place, otherwise as
/// three lines.
class ProgressBar {
 public:
  /// `stream` must outlive the bar. `terminal`: the stream is a terminal.
  ProgressBar(std::FILE* stream, bool terminal);

  void update(const OfflineProgress& progress);
  /// Ends the line of the bar.
  void finish();

  /// The text for the progress of a run at `elapsed_s` (s) after its start.
  static std::string text(const OfflineProgress& progress, double elapsed_s);

 private:
  using Clock = std::chrono::steady_clock;

  std::FILE* stream_;
  bool terminal_;
  Clock::time_point start_ = Clock::now();
  double last_drawn_s_ = -1.0;
  std::size_t last_line_ = 0;
};

}  // namespace kestrel
