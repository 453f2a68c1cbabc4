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
/// ignored). Of a rosbag, with a `sensor_topic`, each of `topics` has the poses (PoseStamped and
/// the like) of one object, which are taken relative to the pose of the sensor; the objects are
/// numbered from 1. Without a `sensor_topic`, the one of `topics` has leg_tracker/Person (positions
/// in the frame of the sensor); none: the only topic of persons. Throws std::runtime_error with the
/// file and the error.
std::vector<TrueObject> readTrueObjects(const std::string& path,
                                        const std::vector<std::string>& topics,
                                        const std::string& sensor_topic);

}  // namespace kestrel
