// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/progress_bar.h"

#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

constexpr double kRedrawInterval_s = 0.1;
constexpr std::size_t kLines = 3;  // without a terminal
constexpr double kSecondsPerMinute = 60.0;

double shareOf(const OfflineProgress& progress) {
  if (progress.total == 0) return 1.0;
  return std::min(1.0, static_cast<double>(progress.done) / static_cast<double>(progress.total));
}

/// Minutes and seconds, "2:05".
std::string clockText(double seconds) {
  constexpr std::size_t kLength = 32;
  char buffer[kLength];
  const double whole = std::round(seconds);
  std::snprintf(buffer, sizeof buffer, "%.0f:%02.0f", std::floor(whole / kSecondsPerMinute),
                std::fmod(whole, kSecondsPerMinute));
  return buffer;
}

std::string barOf(double share) {
  constexpr double kCharacters = 24.0;
  const auto filled = static_cast<std::size_t>(share * kCharacters);
  return "[" + std::string(filled, '#') +
         std::string(static_cast<std::size_t>(kCharacters) - filled, '.') + "] ";
}

}  // namespace

ProgressBar::ProgressBar(std::FILE* stream, bool terminal) : stream_(stream), terminal_(terminal) {}

std::string ProgressBar::text(const OfflineProgress& progress, double elapsed_s) {
  const double share = shareOf(progress);
  const double speed = elapsed_s > 0.0 ? progress.recorded_s / elapsed_s : 0.0;
  const double left_s = share > 0.0 ? elapsed_s * (1.0 - share) / share : 0.0;
  constexpr std::size_t kLength = 128;
  constexpr double kPercent = 100.0;
  char buffer[kLength];
  std::snprintf(buffer, sizeof buffer, "%3.0f %%  %zu of %zu scans  %.0f x real time  %s left",
                std::floor(kPercent * share), progress.done, progress.total, speed,
                clockText(left_s).c_str());
  return buffer;
}

void ProgressBar::update(const OfflineProgress& progress) {
  const double elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
  const double share = shareOf(progress);
  if (terminal_) {
    if (share < 1.0 && elapsed_s - last_drawn_s_ < kRedrawInterval_s) return;
    last_drawn_s_ = elapsed_s;
    // Return to the start of the line; then clear the rest of an older, longer text.
    std::fprintf(stream_, "\r%s%s\033[K", barOf(share).c_str(), text(progress, elapsed_s).c_str());
    std::fflush(stream_);
    return;
  }
  const auto line = static_cast<std::size_t>(share * static_cast<double>(kLines));
  if (line <= last_line_) return;
  last_line_ = line;
  std::fprintf(stream_, "%s\n", text(progress, elapsed_s).c_str());
}

void ProgressBar::finish() {
  if (terminal_ && last_drawn_s_ >= 0.0) std::fputc('\n', stream_);
}

}  // namespace kestrel
