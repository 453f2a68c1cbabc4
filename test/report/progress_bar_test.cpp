// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/progress_bar.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "kestrel_slam/map/atomic_file.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// The output of a bar for a run of `scans` scans.
std::string outputOf(bool terminal, std::size_t scans) {
  const TemporaryFolder folder;
  std::FILE* file = std::fopen(folder.file("out").c_str(), "w");
  ProgressBar bar(file, terminal);
  for (std::size_t i = 1; i <= scans; ++i) bar.update({i, scans, 0.1 * static_cast<double>(i)});
  bar.finish();
  std::fclose(file);
  return readFile(folder.file("out"));
}

TEST(ProgressBarTest, ShowsProgressSpeedAndRemainingTime) {
  EXPECT_EQ(ProgressBar::text({500, 2000, 50.0}, 25.0),
            " 25 %  500 of 2000 scans  2 x real time  1:15 left");
  EXPECT_EQ(ProgressBar::text({2000, 2000, 200.0}, 4.0),
            "100 %  2000 of 2000 scans  50 x real time  0:00 left");
  EXPECT_EQ(ProgressBar::text({0, 0, 0.0}, 0.0), "100 %  0 of 0 scans  0 x real time  0:00 left");
}

TEST(ProgressBarTest, PrintsThreeLinesWithoutATerminal) {
  const std::string output = outputOf(false, 1000);
  EXPECT_EQ(std::count(output.begin(), output.end(), '\n'), 3);
  EXPECT_EQ(output.find('\r'), std::string::npos);
  EXPECT_EQ(output.rfind(" 33 %  334 of 1000 scans", 0), 0U);
  EXPECT_CONTAINS(output, "\n100 %  1000 of 1000 scans");
}

TEST(ProgressBarTest, UpdatesOneLineOnATerminal) {
  const std::string output = outputOf(true, 1000);
  EXPECT_EQ(std::count(output.begin(), output.end(), '\n'), 1);
  EXPECT_EQ(output[0], '\r');
  EXPECT_CONTAINS(output, "\r[########################] 100 %  1000 of 1000 scans");
}

}  // namespace
}  // namespace kestrel
