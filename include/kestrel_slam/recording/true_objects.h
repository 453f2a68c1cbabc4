// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace kestrel {

/// True position of an object that was annotated or measured by motion capture.
struct TrueObject {
  double stamp = 0.0;  ///< s
  long id = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< in the frame of the sensor, m
  /// False: the sensor cannot see it. A track on it is neither right nor wrong.
  bool visible = true;
};

/// Reads true positions, sorted by stamp.
///
/// A text file has lines `stamp,id,x,y` (x and y in the frame of the sensor; other columns are
/// ignored). Of a rosbag, `topic` is read: leg_tracker/Person (positions in the frame of the
/// sensor; the stamp is the time of recording), or a topic of poses (PoseStamped and the like) of
/// one object, which are taken relative to the pose of the sensor on `sensor_topic`. Empty: the
/// only topic of persons. Throws std::runtime_error with the file and the error.
std::vector<TrueObject> readTrueObjects(const std::string& path, const std::string& topic,
                                        const std::string& sensor_topic);

}  // namespace kestrel
