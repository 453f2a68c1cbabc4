// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <rviz/panel.h>

#include <QApplication>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QtTest/QTest>
#include <filesystem>
#include <pluginlib/class_loader.hpp>
#include <string>

#include "kestrel_slam/JoinVehicle.h"
#include "kestrel_slam/geometry/angles.h"
#include "mapper_client.h"
#include "patience.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// The panel as rviz loads it, on a screen that nobody sees, and a mapper that gets scans. Buttons
/// are pressed with the mouse.
class PanelTest : public testing::Test {
 protected:
  PanelTest() : loader_("rviz", "rviz::Panel"), client_("uav1"), flight_(laboratoryFlight(300)) {
    panel_.reset(loader_.createUnmanagedInstance("kestrel_slam/Mapper"));
    panel_->resize(420, 420);
    panel_->show();
  }

  /// Runs Qt and ROS, with 10 scans per second, until the condition holds.
  bool waitFor(const std::function<bool()>& condition, double timeout_s = kPatience) {
    Patience patience(timeout_s);
    while (!condition() && !patience.isOver()) {
      if (!scans_come_) {
        ros::spinOnce();
        QTest::qWait(5);
        continue;
      }
      const std::size_t count = flight_.scans.size(), lap = next_ / count;
      client_.publish(messageOf(flight_.scans[next_ % count].scan, "base_link",
                                60.0 * static_cast<double>(lap)));
      ++next_;
      const ros::WallTime pause = ros::WallTime::now() + ros::WallDuration(0.1);
      while (ros::WallTime::now() < pause) {
        ros::spinOnce();
        QTest::qWait(5);
      }
    }
    return condition();
  }

  QPushButton* button(const std::string& service) {
    return panel_->findChild<QPushButton*>(QString::fromStdString(service));
  }
  std::string label(const std::string& name) {
    return panel_->findChild<QLabel*>(QString::fromStdString(name))->text().toStdString();
  }
  bool says(const std::string& name, const std::string& part) {
    return waitFor([&] { return label(name).find(part) != std::string::npos; });
  }
  /// Writes into the field that has this text.
  void write(const std::string& before, const std::string& text) {
    for (QLineEdit* field : panel_->findChildren<QLineEdit*>()) {
      if (field->text().toStdString() == before) field->setText(QString::fromStdString(text));
    }
  }
  bool press(const std::string& service) {
    if (!waitFor([&] { return button(service)->isEnabled(); })) return false;
    QTest::mouseClick(button(service), Qt::LeftButton);
    return true;
  }

  pluginlib::ClassLoader<rviz::Panel> loader_;
  MapperClient client_;
  TestFlight flight_;
  std::size_t next_ = 0;
  bool scans_come_ = true;
  std::unique_ptr<rviz::Panel> panel_;
};

TEST_F(PanelTest, ButtonsCallTheServicesAndTheStateIsShown) {
  EXPECT_FALSE(button("save_map")->isEnabled()) << "before it knows of a mapper";
  ASSERT_TRUE(says("state", "ok")) << label("state");
  EXPECT_NE(label("state").find("fits"), std::string::npos) << "the reason";

  ASSERT_TRUE(press("pause_mapping"));
  EXPECT_TRUE(says("answer", "mapping is now paused")) << label("answer");
  EXPECT_TRUE(says("state", "paused"));
  EXPECT_EQ(button("pause_mapping")->text().toStdString(), "Continue");
  ASSERT_TRUE(press("pause_mapping"));
  EXPECT_TRUE(says("answer", "mapping is now running")) << label("answer");

  const TemporaryFolder folder;
  write("map", folder.file("saved"));
  ASSERT_TRUE(press("save_map"));
  EXPECT_TRUE(says("answer", "wrote " + folder.file("saved.pgm"))) << label("answer");
  EXPECT_TRUE(std::filesystem::exists(folder.file("saved.yaml")));

  ASSERT_TRUE(press("reset_map"));
  EXPECT_TRUE(says("answer", "the map was deleted")) << label("answer");
}

TEST_F(PanelTest, SaysSoonThatNoScanArrives) {
  ASSERT_TRUE(says("state", "ok")) << label("state");
  scans_come_ = false;
  const ros::WallTime silent = ros::WallTime::now();
  ASSERT_TRUE(says("state", "stale")) << label("state");
  EXPECT_LT((ros::WallTime::now() - silent).toSec(), 2.0);
  EXPECT_TRUE(says("state", "no scan on ")) << label("state");
  scans_come_ = true;
  EXPECT_TRUE(says("state", "ok")) << label("state");
}

TEST_F(PanelTest, ASessionIsSavedAndLoadedAndLocalizedIn) {
  ASSERT_TRUE(says("state", "ok")) << label("state");
  const TemporaryFolder folder;
  write("session", folder.file("day.session"));
  ASSERT_TRUE(press("save_session"));
  EXPECT_TRUE(says("answer", "keyframes to " + folder.file("day.session"))) << label("answer");
  ASSERT_TRUE(press("load_session"));
  EXPECT_TRUE(says("answer", "keyframes from " + folder.file("day.session"))) << label("answer");

  ASSERT_TRUE(press("relocalize"));
  EXPECT_TRUE(says("answer", "refused: it maps")) << label("answer");
  ASSERT_TRUE(press("set_mode"));
  EXPECT_TRUE(says("answer", "the vehicle is localized")) << label("answer");
  EXPECT_TRUE(says("state", "(localization)")) << label("state");
  EXPECT_EQ(button("set_mode")->text().toStdString(), "Map again");
  ASSERT_TRUE(press("relocalize"));
  EXPECT_TRUE(says("answer", "searched for in the whole map")) << label("answer");
  EXPECT_TRUE(waitFor([&] {  // refused until it is found
    if (label("answer") == "the map grows" || label("answer") == "the mode was already mapping")
      return true;
    QTest::mouseClick(button("set_mode"), Qt::LeftButton);
    return false;
  })) << label("answer");
  EXPECT_TRUE(says("state", "(mapping)")) << label("state");
}

/// Functions that this mapper does not have may be services of another node.
TEST_F(PanelTest, AServiceInTheRootIsUsedAndItsRefusalShown) {
  using Join = kestrel_slam::JoinVehicle;
  std::vector<Join::Request> calls;
  const boost::function<bool(Join::Request&, Join::Response&)> refuse =
      [&](Join::Request& request, Join::Response& response) {
        calls.push_back(request);
        response.success = false;
        response.message = "the maps do not overlap";
        return true;
      };
  const ros::ServiceServer server =
      ros::NodeHandle().advertiseService<Join::Request, Join::Response>("/join", refuse);
  ASSERT_TRUE(says("state", "ok"));
  ASSERT_TRUE(press("join"));
  EXPECT_TRUE(says("answer", "name x y yaw")) << label("answer");
  EXPECT_TRUE(calls.empty());
  panel_->findChild<QLineEdit*>("vehicle")->setText("uav2 12.5 -3 90");
  ASSERT_TRUE(press("join"));
  EXPECT_TRUE(says("answer", "refused: the maps do not overlap")) << label("answer");
  ASSERT_EQ(calls.size(), 1U);
  EXPECT_EQ(calls[0].vehicle, "uav2");
  const Pose2 world_T_map = poseOf(calls[0].world_T_map);
  EXPECT_EQ(world_T_map.x, 12.5);
  EXPECT_EQ(world_T_map.y, -3.0);
  EXPECT_NEAR(world_T_map.yaw, 0.5 * kPi, 1e-9);
}

TEST_F(PanelTest, WithoutAMapperEveryButtonIsGrayAndSaysWhy) {
  panel_->findChildren<QLineEdit*>().front()->setText("/nobody/mapper");
  EXPECT_TRUE(waitFor([&] {
    const auto buttons = panel_->findChildren<QPushButton*>();
    return std::all_of(buttons.begin(), buttons.end(),
                       [](const QPushButton* b) { return !b->isEnabled(); });
  }));
  const std::string tip = button("save_session")->toolTip().toStdString();
  EXPECT_NE(tip.find("save_session does not exist"), std::string::npos) << tip;
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "panel_test");
  const ros::NodeHandle keeps_the_node_alive;
  setenv("QT_QPA_PLATFORM", "offscreen", 1);
  const QApplication application(argc, argv);
  return RUN_ALL_TESTS();
}
