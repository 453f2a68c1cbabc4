// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/ros.h>
#include <rviz/panel.h>

#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTimer>
#include <functional>
#include <future>
#include <set>
#include <string>
#include <vector>

#include "kestrel_slam/ros/panel/mapper_summary.h"

namespace kestrel {

/// A panel of rviz: the state of the mapper with its reason, and buttons for its services. A button
/// whose service does not exist is gray, and its tool tip says why.
class MapperPanel : public rviz::Panel {
  Q_OBJECT

 public:
  explicit MapperPanel(QWidget* parent = nullptr);

  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private:
  /// A button and the service that it calls.
  struct Action {
    QPushButton* button;
    std::string service;
  };
  using Call = std::function<std::string(const std::string& service)>;

  void addWidgets();
  QWidget* textArea() const;
  QPushButton* addButton(const std::string& text, const std::string& service,
                         const std::function<Call()>& call);
  void onDiagnostics(const diagnostic_msgs::DiagnosticArray& message);
  void show();
  QString numbersText() const;
  std::string nodeName() const;
  std::string serviceName(const std::string& name) const;
  /// Calls the service on another thread, so that rviz does not stand still, and shows the answer.
  void call(const std::string& service, const Call& call);
  void lookForServices();
  void enableButtons();

  ros::NodeHandle nh_;
  ros::Subscriber subscriber_;
  MapperSummary summary_;
  double scans_per_s_ = 0.0;
  ros::WallTime last_;
  QLineEdit* node_;
  QLineEdit* map_path_;
  QLineEdit* session_path_;
  QLineEdit* vehicle_;
  QLabel* state_;
  QLabel* numbers_;
  QLabel* answer_;
  QPushButton* pause_ = nullptr;
  QPushButton* mode_ = nullptr;
  std::vector<Action> actions_;
  std::set<std::string> services_;  ///< all that the master knows
  QTimer timer_;
  std::future<void> call_, search_;
};

}  // namespace kestrel
