# SPDX-License-Identifier: BSD-3-Clause
# The catkin commands that must come before the first target.
# catkin caches the environment of the tests now, and leaves out folders that do not exist yet. The
# Python modules of the messages would be missing in the tests of a fresh build folder.
file(MAKE_DIRECTORY ${CATKIN_DEVEL_PREFIX}/lib/python3/dist-packages)
find_package(catkin REQUIRED COMPONENTS
  diagnostic_updater dynamic_reconfigure geometry_msgs map_msgs message_filters message_generation nav_msgs nodelet pluginlib
  roscpp sensor_msgs std_msgs std_srvs tf2 tf2_msgs tf2_ros visualization_msgs)
find_package(rosbag_storage REQUIRED)  # separate, because the flight nodes do not link to it

file(GLOB MESSAGES RELATIVE ${PROJECT_SOURCE_DIR}/msg ${PROJECT_SOURCE_DIR}/msg/*.msg)
add_message_files(DIRECTORY msg FILES ${MESSAGES})
file(GLOB SERVICES RELATIVE ${PROJECT_SOURCE_DIR}/srv ${PROJECT_SOURCE_DIR}/srv/*.srv)
add_service_files(DIRECTORY srv FILES ${SERVICES})
generate_messages(DEPENDENCIES geometry_msgs nav_msgs std_msgs)

catkin_package(
  INCLUDE_DIRS include
  CATKIN_DEPENDS geometry_msgs map_msgs message_runtime nav_msgs nodelet roscpp sensor_msgs std_msgs std_srvs
    tf2_ros visualization_msgs
  DEPENDS EIGEN3
  CFG_EXTRAS kestrel_slam-extras.cmake)

set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION})
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_LIB_DESTINATION})
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_LIB_DESTINATION})
