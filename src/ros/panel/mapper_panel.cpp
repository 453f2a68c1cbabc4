// SPDX-License-Identifier: BSD-3-Clause
#include "mapper_panel.h"

#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <QFormLayout>
#include <QHBoxLayout>
#include <QMetaObject>
#include <QVBoxLayout>
#include <pluginlib/class_list_macros.hpp>

#include "kestrel_slam/SaveMap.h"

namespace kestrel {
namespace {

QString colorOf(const std::string& state) {
  if (state == "ok") return "#1d8348";
  if (state == "degraded") return "#b9770e";
  return state == "lost" ? "#c0392b" : "#5d6d7e";
}

/// Calls a service whose response has success and message.
template <typename Service>
std::string answerOf(const std::string& name, Service service) {
  if (!ros::service::exists(name, false)) return name + " does not exist: is the mapper running?";
  if (!ros::service::call(name, service)) return name + " failed";
  return (service.response.success ? "" : "refused: ") + service.response.message;
}

}  // namespace

MapperPanel::MapperPanel(QWidget* parent)
    : rviz::Panel(parent),
      node_(new QLineEdit),
      path_(new QLineEdit("map")),
      state_(new QLabel("no mapper")),
      numbers_(new QLabel),
      answer_(new QLabel),
      pause_(new QPushButton("Pause")) {
  node_->setPlaceholderText("any mapper");
  state_->setTextFormat(Qt::RichText);
  for (QLabel* label : {state_, numbers_, answer_}) label->setWordWrap(true);
  auto* form = new QFormLayout;
  form->addRow("Node", node_);
  form->addRow("Map file", path_);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(state_);
  layout->addWidget(numbers_);
  layout->addLayout(form);
  addButtons();
  layout->addWidget(answer_);
  layout->addStretch();
  connect(node_, &QLineEdit::editingFinished, this, &rviz::Panel::configChanged);
  connect(path_, &QLineEdit::editingFinished, this, &rviz::Panel::configChanged);
  subscriber_ = nh_.subscribe<diagnostic_msgs::DiagnosticArray>(
      "/diagnostics", 10, [this](const diagnostic_msgs::DiagnosticArray::ConstPtr& message) {
        onDiagnostics(*message);
      });
}

void MapperPanel::addButtons() {
  auto* row = new QHBoxLayout;
  auto* reset = new QPushButton("Reset map");
  auto* save = new QPushButton("Save map");
  for (QPushButton* button : {pause_, save, reset}) row->addWidget(button);
  static_cast<QVBoxLayout*>(layout())->addLayout(row);
  connect(pause_, &QPushButton::clicked, this, [this] { pause(); });
  connect(save, &QPushButton::clicked, this, [this] { saveMap(); });
  connect(reset, &QPushButton::clicked, this, [this] { this->reset(); });
}

void MapperPanel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString text;
  if (config.mapGetString("Node", &text)) node_->setText(text);
  if (config.mapGetString("Map file", &text)) path_->setText(text);
}

void MapperPanel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue("Node", node_->text());
  config.mapSetValue("Map file", path_->text());
}

std::string MapperPanel::nodeName() const { return node_->text().trimmed().toStdString(); }

/// rviz calls the callbacks of ROS on the thread of its windows.
void MapperPanel::onDiagnostics(const diagnostic_msgs::DiagnosticArray& message) {
  const double before = summary_.used;
  if (!takeOver(message, nodeName(), summary_)) return;
  const ros::WallTime now = ros::WallTime::now();
  const double seconds = (now - last_).toSec();
  if (!last_.isZero() && seconds > 0.0)
    scans_per_s_ = std::max(0.0, summary_.used - before) / seconds;
  last_ = now;
  show();
}

void MapperPanel::show() {
  const std::string state = summary_.state.empty() ? "no scan yet" : summary_.state;
  QString text = QString("<b style='font-size:large; color:%1'>%2</b>")
                     .arg(colorOf(summary_.state), QString::fromStdString(state).toHtmlEscaped());
  for (const std::string& line : {summary_.reason, summary_.problem}) {
    if (!line.empty()) text += "<br>" + QString::fromStdString(line).toHtmlEscaped();
  }
  state_->setText(text);
  QString numbers = QString("%1 scans/s, %2 ms each, %3 of %4 used\nmap %5")
                        .arg(scans_per_s_, 0, 'f', 1)
                        .arg(summary_.ms, 0, 'f', 1)
                        .arg(summary_.used, 0, 'f', 0)
                        .arg(summary_.received, 0, 'f', 0)
                        .arg(QString::fromStdString(summary_.map));
  for (const auto& [reason, count] : summary_.dropped) {
    numbers += QString("\ndropped: %1 %2")
                   .arg(QString::fromStdString(count), QString::fromStdString(reason));
  }
  numbers_->setText(numbers);
  pause_->setText(summary_.state == "paused" ? "Continue" : "Pause");
}

/// The services are in the namespace of the mapper.
std::string MapperPanel::serviceName(const std::string& name) const {
  const std::string node = summary_.node.empty() ? nodeName() : summary_.node;
  return node.substr(0, node.rfind('/') + 1) + name;
}

void MapperPanel::call(const std::function<std::string()>& service) {
  answer_->setText("...");
  running_ = std::async(std::launch::async, [this, service] {
    const QString answer = QString::fromStdString(service());
    QMetaObject::invokeMethod(answer_, [this, answer] { answer_->setText(answer); });
  });
}

void MapperPanel::reset() {
  call([name = serviceName("reset_map")] { return answerOf(name, std_srvs::Trigger()); });
}

void MapperPanel::pause() {
  std_srvs::SetBool service;
  service.request.data = summary_.state != "paused";
  call([name = serviceName("pause_mapping"), service] { return answerOf(name, service); });
}

void MapperPanel::saveMap() {
  kestrel_slam::SaveMap service;
  service.request.path = path_->text().toStdString();
  call([name = serviceName("save_map"), service] { return answerOf(name, service); });
}

}  // namespace kestrel

PLUGINLIB_EXPORT_CLASS(kestrel::MapperPanel, rviz::Panel)
