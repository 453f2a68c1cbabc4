// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/scan_file.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "temporary_folder.h"

namespace kestrel {
namespace {

/// Scans along a straight line, one per second and per meter, and their reference.
class ScanFileTest : public ::testing::Test {
 protected:
  ScanFileTest() {
    constexpr int kScans = 40;
    for (int i = 0; i < kScans; ++i) {
      ScanRow scan;
      scan.stamp = i;
      scan.pose = Pose2(i, 0.0, 0.0);
      scan.state = MatchState::kOk;
      scans_.push_back(scan);
      reference_.push_back({scan.stamp, scan.pose});
    }
  }

  void shiftFrom(std::size_t first, double meters) {
    for (std::size_t i = first; i < scans_.size(); ++i) scans_[i].pose.y += meters;
  }

  std::size_t wrongAndOk() const { return evaluateStates(scans_, reference_).wrong_and_ok; }

  std::vector<ScanRow> scans_;
  Trajectory reference_;
};

TEST_F(ScanFileTest, ReadsWhatItWrote) {
  scans_.resize(2);
  ScanRow& full = scans_[1];
  full.stamp = 1234567890.125;
  full.pose = Pose2(-1.5, 2.25, 0.5);
  full.state = MatchState::kDegraded;
  full.score = 0.75;
  full.known = 0.5;
  full.constraint = 0.125;
  full.degenerate_direction = {0.0, 1.0};
  full.sigmas = {0.01, 0.02, 0.03};
  full.inserted = full.ambiguous = true;
  full.odom_T_base = Pose2(1.0, 2.0, 3.0);
  full.reason = "carried: new space";
  TemporaryFolder folder;
  const std::vector<ScanRow> read = readScans(folder.write("scans.csv", scansText(scans_)));
  ASSERT_EQ(read.size(), 2U);
  EXPECT_FALSE(read[0].odom_T_base);
  EXPECT_TRUE(read[0].degenerate_direction.isZero());
  EXPECT_EQ(read[0].state, MatchState::kOk);
  EXPECT_EQ(scansText(read), scansText(scans_));
  EXPECT_EQ(read[1].stamp, full.stamp);
  EXPECT_EQ(read[1].degenerate_direction, full.degenerate_direction);
  EXPECT_EQ(read[1].reason, full.reason);
  EXPECT_TRUE(read[1].inserted && read[1].ambiguous && !read[1].searched && !read[1].carried);
}

TEST_F(ScanFileTest, AFileWithoutReasonsCanBeRead) {
  scans_.resize(1);
  std::string text = scansText(scans_);
  text.replace(text.find(",reason\n"), 7, "");
  text.erase(text.rfind(','), 1);
  TemporaryFolder folder;
  EXPECT_EQ(readScans(folder.write("scans.csv", text)).at(0).reason, "");
}

TEST_F(ScanFileTest, NamesTheLineThatIsWrong) {
  TemporaryFolder folder;
  const auto errorOf = [&](const std::string& text) -> std::string {
    try {
      readScans(folder.write("scans.csv", text));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "none";
  };
  const std::string good = scansText({scans_[0]});
  EXPECT_EQ(errorOf(good), "none");
  EXPECT_NE(errorOf(good + "1,2\n").find("line 3: expected 21 fields, found 2"), std::string::npos);
  std::string bad_state = good;
  bad_state.replace(bad_state.find(",ok,"), 4, ",ko,");
  EXPECT_NE(errorOf(bad_state).find("'ko' is no state"), std::string::npos);
}

TEST_F(ScanFileTest, CountsStatesAndErrors) {
  scans_[3].state = MatchState::kDegraded;
  scans_[4].state = scans_[5].state = MatchState::kLost;
  for (ScanRow& scan : scans_) scan.odom_T_base = Pose2(0.5 * scan.pose.x, 0.0, 0.0);
  const StateEvaluation states = evaluateStates(scans_, reference_);
  EXPECT_EQ(states.ok, 37U);
  EXPECT_EQ(states.degraded, 1U);
  EXPECT_EQ(states.lost, 2U);
  EXPECT_EQ(states.wrong_and_ok, 0U);
  EXPECT_LT(states.ate.translation_m.max, 1e-9);
  ASSERT_TRUE(states.odometry_ate);
  EXPECT_NEAR(states.odometry_ate->translation_m.max, 0.25 * 39.0, 1e-6);  // half of the length
}

TEST_F(ScanFileTest, AJumpIsWrongUntilItIsTenScansOld) {
  shiftFrom(20, 1.5);
  EXPECT_EQ(wrongAndOk(), kMotionScans);
}

TEST_F(ScanFileTest, ASmallJumpIsNotWrong) {
  shiftFrom(20, 0.9);
  EXPECT_EQ(wrongAndOk(), 0U);
}

TEST_F(ScanFileTest, AJumpThatIsSaidIsNotCounted) {
  shiftFrom(20, 1.5);
  for (std::size_t i = 20; i < 30; ++i) scans_[i].state = MatchState::kDegraded;
  EXPECT_EQ(wrongAndOk(), 0U);
}

TEST_F(ScanFileTest, AfterBeingLostTheBaseIsTheLastPoseThatWasKnown) {
  for (std::size_t i = 10; i < 25; ++i) {
    scans_[i].state = MatchState::kLost;
    scans_[i].pose = scans_[9].pose;
  }
  EXPECT_EQ(wrongAndOk(), 0U) << "found at the right place";
  shiftFrom(25, 1.5);
  EXPECT_EQ(wrongAndOk(), kMotionScans) << "found at a wrong place";
}

TEST_F(ScanFileTest, ScansWithoutAReferenceAreIgnored) {
  shiftFrom(20, 1.5);
  reference_.erase(reference_.begin(), reference_.begin() + 5);
  EXPECT_EQ(wrongAndOk(), kMotionScans);
}

}  // namespace
}  // namespace kestrel
