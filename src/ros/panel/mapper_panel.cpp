// SPDX-License-Identifier: BSD-3-Clause
#include "mapper_panel.h"

#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <QFormLayout>
#include <QHBoxLayout>
#include <QMetaObject>
#include <QScrollArea>
#include <QVBoxLayout>
#include <pluginlib/class_list_macros.hpp>

#include "kestrel_slam/JoinVehicle.h"
#include "kestrel_slam/LoadSession.h"
#include "kestrel_slam/SaveMap.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/messages/conversions.h"

namespace kestrel {
namespace {

constexpr int kLookEvery = 1000;      // ms; for the services
constexpr double kSilentAfter = 2.0;  // s; without diagnostics, which come every second

QString colorOf(const std::string& state) {
  if (state == "ok") return "#1d8348";
  if (state == "degraded" || state == "stale") return "#b9770e";
  return state == "lost" ? "#c0392b" : "#5d6d7e";
}

/// Calls a service whose response is success and message. The check of the type is left out,
/// because the panel also calls services of other nodes and of later versions.
template <typename Request>
std::string answerOf(const std::string& name, const Request& request) {
  ros::ServiceClientOptions options(name, "*", false, ros::M_string());
  std_srvs::Trigger::Response response;
  if (!ros::NodeHandle().serviceClient(options).call(request, response, "*"))
    return name + " failed; see the log of the node";
  return (response.success ? "" : "refused: ") + response.message;
}

std::function<std::string(const std::string&)> trigger() {
  return [](const std::string& name) { return answerOf(name, std_srvs::Trigger::Request()); };
}

/// A service whose request is one text: a path, or a mode.
std::function<std::string(const std::string&)> withText(const std::string& text) {
  kestrel_slam::SaveMap::Request request;
  request.path = text;
  return [request](const std::string& name) { return answerOf(name, request); };
}

/// Where the map of a vehicle begins in world, "uav2 12.5 3 90": its name, m and degrees.
std::function<std::string(const std::string&)> joining(const QString& text) {
  const QStringList words = text.simplified().split(' ');
  bool is_number[] = {words.size() == 4, true, true};
  double pose[3] = {};
  for (int i = 0; i < 3 && is_number[0]; ++i) pose[i] = words[i + 1].toDouble(&is_number[i]);
  if (!is_number[0] || !is_number[1] || !is_number[2]) {
    return [](const std::string&) {
      return "write where the map of the vehicle begins: name x y yaw, in m and degrees";
    };
  }
  kestrel_slam::JoinVehicle::Request request;
  request.vehicle = words[0].toStdString();
  request.world_T_map = toMessage(Pose2(pose[0], pose[1], degToRad(pose[2])));
  return [request](const std::string& name) { return answerOf(name, request); };
}

/// All services that the master knows.
std::set<std::string> knownServices() {
  std::set<std::string> names;
  XmlRpc::XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, state, false)) return names;
  constexpr int kServices = 2;  // after publishers and subscribers
  if (state.getType() != XmlRpc::XmlRpcValue::TypeArray || state.size() <= kServices) return names;
  for (int i = 0; i < state[kServices].size(); ++i)
    names.insert(static_cast<std::string>(state[kServices][i][0]));
  return names;
}

bool isReady(const std::future<void>& work) {
  return !work.valid() || work.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

}  // namespace

MapperPanel::MapperPanel(QWidget* parent)
    : rviz::Panel(parent),
      node_(new QLineEdit),
      map_path_(new QLineEdit("map")),
      session_path_(new QLineEdit("session")),
      vehicle_(new QLineEdit),
      state_(new QLabel("no mapper")),
      numbers_(new QLabel),
      answer_(new QLabel) {
  node_->setPlaceholderText("any mapper");
  vehicle_->setPlaceholderText("uav2 12.5 3 90");
  vehicle_->setToolTip("Where the map of a vehicle begins in world: name, x, y (m), yaw (degrees)");
  vehicle_->setObjectName("vehicle");
  state_->setTextFormat(Qt::RichText);
  answer_->setObjectName("answer");
  answer_->hide();  // until there is one
  state_->setObjectName("state");
  for (QLabel* label : {state_, numbers_, answer_}) label->setWordWrap(true);
  addWidgets();
  for (QLineEdit* field : {node_, map_path_, session_path_})
    connect(field, &QLineEdit::editingFinished, this, &rviz::Panel::configChanged);
  subscriber_ = nh_.subscribe<diagnostic_msgs::DiagnosticArray>(
      "/diagnostics", 10, [this](const diagnostic_msgs::DiagnosticArray::ConstPtr& message) {
        onDiagnostics(*message);
      });
  connect(&timer_, &QTimer::timeout, this, [this] { lookForServices(); });
  timer_.start(kLookEvery);
  enableButtons();
}

void MapperPanel::addWidgets() {
  const auto rowOf = [](std::initializer_list<QWidget*> widgets) {
    auto* row = new QHBoxLayout;
    for (QWidget* widget : widgets) row->addWidget(widget);
    return row;
  };
  pause_ = addButton("Pause", "pause_mapping", [this]() -> Call {
    std_srvs::SetBool::Request request;
    request.data = summary_.state != "paused";
    return [request](const std::string& name) { return answerOf(name, request); };
  });
  mode_ = addButton("Localize only", "set_mode", [this] {
    return withText(summary_.mode == "localization" ? "mapping" : "localization");
  });
  const auto map_path = [this] { return withText(map_path_->text().toStdString()); };
  const auto session_path = [this] { return withText(session_path_->text().toStdString()); };
  const auto load_session = [this]() -> Call {
    kestrel_slam::LoadSession::Request request;
    request.path = session_path_->text().toStdString();
    return [request](const std::string& name) { return answerOf(name, request); };
  };
  auto* form = new QFormLayout;
  form->addRow("Node", node_);
  form->addRow("Map file", rowOf({map_path_, addButton("Save map", "save_map", map_path)}));
  form->addRow("Session", rowOf({session_path_, addButton("Save", "save_session", session_path),
                                 addButton("Load", "load_session", load_session)}));
  const auto join = [this] { return joining(vehicle_->text()); };
  form->addRow("Vehicle", rowOf({vehicle_, addButton("Join", "join", join)}));
  auto* layout = new QVBoxLayout(this);
  layout->addLayout(rowOf({pause_, mode_, addButton("Relocalize", "relocalize", trigger),
                           addButton("Reset map", "reset_map", trigger)}));
  layout->addLayout(form);
  layout->addWidget(textArea());
}

/// The texts, below the buttons and in an area that scrolls, so that no button moves away from the
/// pointer when a text gets longer.
QWidget* MapperPanel::textArea() const {
  constexpr int kLines = 9;
  auto* texts = new QWidget;
  auto* layout = new QVBoxLayout(texts);
  layout->setContentsMargins(0, 0, 0, 0);
  for (QLabel* label : {answer_, state_, numbers_}) layout->addWidget(label);
  layout->addStretch();
  auto* area = new QScrollArea;
  area->setWidget(texts);
  area->setWidgetResizable(true);
  area->setFrameShape(QFrame::NoFrame);
  area->setMinimumHeight(kLines * fontMetrics().lineSpacing());
  return area;
}

/// `call`: what to do with the service; asked for when the button is pressed.
QPushButton* MapperPanel::addButton(const std::string& text, const std::string& service,
                                    const std::function<Call()>& call) {
  auto* button = new QPushButton(QString::fromStdString(text));
  button->setObjectName(QString::fromStdString(service));
  connect(button, &QPushButton::clicked, this,
          [this, service, call] { this->call(serviceName(service), call()); });
  actions_.push_back({button, service});
  return button;
}

void MapperPanel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString text;
  if (config.mapGetString("Node", &text)) node_->setText(text);
  if (config.mapGetString("Map file", &text)) map_path_->setText(text);
  if (config.mapGetString("Session", &text)) session_path_->setText(text);
}

void MapperPanel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue("Node", node_->text());
  config.mapSetValue("Map file", map_path_->text());
  config.mapSetValue("Session", session_path_->text());
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
  if (!summary_.mode.empty()) text += " (" + QString::fromStdString(summary_.mode) + ")";
  for (const std::string& line : {summary_.reason, summary_.problem}) {
    if (!line.empty()) text += "<br>" + QString::fromStdString(line).toHtmlEscaped();
  }
  state_->setText(text);
  numbers_->setText(numbersText());
  pause_->setText(summary_.state == "paused" ? "Continue" : "Pause");
  mode_->setText(summary_.mode == "localization" ? "Map again" : "Localize only");
}

QString MapperPanel::numbersText() const {
  QString text = QString("%1 scans/s, %2 ms each, %3 of %4 used\nmap %5")
                     .arg(scans_per_s_, 0, 'f', 1)
                     .arg(summary_.ms, 0, 'f', 1)
                     .arg(summary_.used, 0, 'f', 0)
                     .arg(summary_.received, 0, 'f', 0)
                     .arg(QString::fromStdString(summary_.map));
  const std::pair<const char*, std::string> optional[] = {{"loops: ", summary_.loops},
                                                          {"tracks: ", summary_.tracks}};
  for (const auto& [name, value] : optional) {
    if (!value.empty()) text += "\n" + QString(name) + QString::fromStdString(value);
  }
  for (const auto& [reason, count] : summary_.dropped) {
    text += QString("\ndropped: %1 %2")
                .arg(QString::fromStdString(count), QString::fromStdString(reason));
  }
  return text;
}

/// The services are in the namespace of the mapper, or in the root if only that has them.
std::string MapperPanel::serviceName(const std::string& name) const {
  const std::string node = summary_.node.empty() ? nodeName() : summary_.node;
  const std::string own = node.substr(0, node.rfind('/') + 1) + name;
  const std::string root = "/" + name;
  return services_.count(own) == 0 && services_.count(root) > 0 ? root : own;
}

void MapperPanel::call(const std::string& service, const Call& call) {
  answer_->show();
  if (!isReady(call_)) return answer_->setText("The last call has not ended yet.");
  answer_->setText("...");
  call_ = std::async(std::launch::async, [this, service, call] {
    const QString answer = QString::fromStdString(call(service));
    QMetaObject::invokeMethod(answer_, [this, answer] { answer_->setText(answer); });
  });
}

void MapperPanel::lookForServices() {
  if (!last_.isZero() && (ros::WallTime::now() - last_).toSec() > kSilentAfter)
    state_->setText("no news from " + QString::fromStdString(summary_.node));
  if (!isReady(search_)) return;
  search_ = std::async(std::launch::async, [this] {
    QMetaObject::invokeMethod(this, [this, found = knownServices()] {
      services_ = found;
      enableButtons();
    });
  });
}

void MapperPanel::enableButtons() {
  for (const Action& action : actions_) {
    const std::string name = serviceName(action.service);
    const bool exists = services_.count(name) > 0;
    action.button->setEnabled(exists);
    const std::string why = " does not exist: the mapper does not run, or has no such function.";
    action.button->setToolTip(
        QString::fromStdString(exists ? "Calls " + name : "The service " + name + why));
  }
}

}  // namespace kestrel

PLUGINLIB_EXPORT_CLASS(kestrel::MapperPanel, rviz::Panel)
