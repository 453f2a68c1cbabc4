// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_flight_writer.h"

#include <rosbag/bag.h>

#include <boost/make_shared.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "kestrel_slam/recording/bag/bag_flight_messages.h"

namespace kestrel {
namespace {

const char* topicOf(const LaserScan&) { return "/scan"; }
const char* topicOf(const PointCloud&) { return "/points"; }
const char* topicOf(const ImuSample&) { return "/imu/data"; }
const char* topicOf(const HeightSample&) { return "/height"; }
const char* topicOf(const Barometer&) { return "/pressure_height"; }
const char* topicOf(const TruePose&) { return "/ground_truth"; }
const char* topicOf(const TrueWalkers&) { return "/people"; }

/// The connection header that makes rosbag play latch the static transforms. It must be complete,
/// because rosbag does not add fields to a given header.
boost::shared_ptr<ros::M_string> latchedHeader() {
  namespace traits = ros::message_traits;
  auto header = boost::make_shared<ros::M_string>();
  (*header)["type"] = traits::datatype<tf2_msgs::TFMessage>();
  (*header)["md5sum"] = traits::md5sum<tf2_msgs::TFMessage>();
  (*header)["message_definition"] = traits::definition<tf2_msgs::TFMessage>();
  (*header)["callerid"] = "/simulate_flight";
  (*header)["latching"] = "1";
  return header;
}

bool isScan(const FlightMessage& message, const VehicleModel& vehicle) {
  return vehicle.laser ? std::holds_alternative<LaserScan>(message)
                       : std::holds_alternative<PointCloud>(message);
}

FlightBagSummary writeMessages(rosbag::Bag& bag, FlightSimulator& flight,
                               const VehicleModel& vehicle) {
  FlightBagSummary summary;
  const ros::Time start(kFlightStart);
  bag.write("/tf_static", start, mountings(vehicle, start), latchedHeader());
  ++summary.messages;
  FlightEvent event;
  while (flight.next(event)) {
    std::visit(
        [&](const auto& message) {
          bag.write(topicOf(message), ros::Time(event.arrival),
                    toMessage(message, ros::Time(event.stamp), vehicle));
        },
        event.message);
    ++summary.messages;
    if (isScan(event.message, vehicle)) summary.scan_stamps.push_back(event.stamp);
  }
  return summary;
}

}  // namespace

FlightBagSummary writeFlightBag(const std::string& path, FlightSimulator& flight,
                                const VehicleModel& vehicle) {
  const std::string unfinished = path + ".part";
  FlightBagSummary summary;
  try {
    rosbag::Bag bag(unfinished, rosbag::bagmode::Write);
    summary = writeMessages(bag, flight, vehicle);
    bag.close();
  } catch (const rosbag::BagException& error) {
    std::remove(unfinished.c_str());
    throw std::runtime_error(path + ": cannot write the bag (" + error.what() +
                             "); check that the folder exists and is writable");
  }
  if (std::rename(unfinished.c_str(), path.c_str()) != 0) {
    const std::string reason = std::strerror(errno);
    std::remove(unfinished.c_str());
    throw std::runtime_error(path + ": cannot write the bag (" + reason + "); choose another name");
  }
  return summary;
}

}  // namespace kestrel
