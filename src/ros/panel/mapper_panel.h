// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/ros.h>
#include <rviz/panel.h>

#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <functional>
#include <future>
#include <string>

#include "kestrel_slam/ros/panel/mapper_summary.h"

namespace kestrel {

/// A panel of rviz: the state of the mapper with its reason, and buttons for its services.
class MapperPanel : public rviz::Panel {
  Q_OBJECT

 public:
  explicit MapperPanel(QWidget* parent = nullptr);

  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private:
  void onDiagnostics(const diagnostic_msgs::DiagnosticArray& message);
  void show();
  void addButtons();
  std::string nodeName() const;
  /// Calls a service on another thread, so that rviz does not stand still, and shows the answer.
  void call(const std::function<std::string()>& service);
  std::string serviceName(const std::string& name) const;
  void reset();
  void pause();
  void saveMap();

  ros::NodeHandle nh_;
  ros::Subscriber subscriber_;
  MapperSummary summary_;
  double scans_per_s_ = 0.0;
  ros::WallTime last_;
  QLineEdit* node_;
  QLineEdit* path_;
  QLabel* state_;
  QLabel* numbers_;
  QLabel* answer_;
  QPushButton* pause_;
  std::future<void> running_;
};

}  // namespace kestrel
