// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/tracks_page.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "report/page_data.h"

namespace kestrel {
namespace {

Track shownTrack(long id, double x) {
  Track track;
  track.id = id;
  track.state = TrackState::kConfirmed;
  track.moved = true;
  track.position = {x, 0.0};
  track.velocity = {0.6, 0.8};
  return track;
}

TracksPage pageOf(const std::string& title) {
  TracksPage page;
  page.title = title;
  for (int i = 0; i < 5; ++i) {
    const double stamp = 100.0 + 0.1 * i;
    TrackFrame frame;
    frame.stamp = stamp;
    frame.tracks = {shownTrack(3, 0.1 * i), Track()};  // the second one does not move
    page.frames.push_back(frame);
    page.odom_path.push_back({stamp, Pose2(0.1 * i, 0.0, 0.0)});
    page.map_path.push_back({stamp, Pose2(1.0 + 0.1 * i, 2.0, 0.0)});
  }
  return page;
}

TEST(TracksPage, ShowsTheObjectsThatMovedInTheMap) {
  const nlohmann::json data = dataOf(tracksHtml(pageOf("a.bag")));
  ASSERT_EQ(data["tracks"].size(), 1U);
  const nlohmann::json& track = data["tracks"][0];
  EXPECT_EQ(track["id"], 3);
  ASSERT_EQ(track["t"].size(), 5U);
  EXPECT_NEAR(track["x"][4].get<double>(), 1.4, 1e-3);
  EXPECT_NEAR(track["y"][4].get<double>(), 2.0, 1e-3);
  EXPECT_NEAR(track["v"][0].get<double>(), 1.0, 1e-3);
  EXPECT_NEAR(data["vehicle"]["x"][4].get<double>(), 1.4, 1e-3);
}

TEST(TracksPage, NamesCannotEndTheScript) {
  EXPECT_EQ(dataOf(tracksHtml(pageOf("</script>")))["title"], "</script>");
}

TEST(TracksPage, NeedsNoOtherFileAndNoTracks) {
  const std::string html = tracksHtml(TracksPage());
  EXPECT_EQ(html.find("http"), std::string::npos);
  EXPECT_TRUE(dataOf(html)["tracks"].empty());
}

}  // namespace
}  // namespace kestrel
