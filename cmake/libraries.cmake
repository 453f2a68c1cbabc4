# SPDX-License-Identifier: BSD-3-Clause
# One static library for each folder of src/. They are sorted by dependency: a folder may
# include only folders above it in this file (scripts/check_includes checks this).
set(KESTREL_LIBRARIES)

# Half of the time of a build without ccache is reading these.
set(COMMON_HEADERS <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU>
  <algorithm> <array> <cmath> <filesystem> <functional> <map> <memory> <optional> <set> <sstream>
  <stdexcept> <string> <unordered_map> <vector>)
# All who read the file of the headers must define the same as Boost::iostreams.
if(KESTREL_PRECOMPILE_HEADERS)
  add_compile_definitions(BOOST_ALL_NO_LIB)
endif()
set(ROS_HEADERS <diagnostic_msgs/DiagnosticArray.h> <geometry_msgs/PoseWithCovarianceStamped.h>
  <nav_msgs/OccupancyGrid.h> <nav_msgs/Odometry.h> <ros/ros.h> <sensor_msgs/Imu.h> <sensor_msgs/LaserScan.h>
  <sensor_msgs/PointCloud2.h> <sensor_msgs/Range.h> <tf2_msgs/TFMessage.h>)
# precompile(TARGET FIRST HEADER...): FIRST compiles the headers, the other targets read its file.
function(precompile target first)
  if(NOT KESTREL_PRECOMPILE_HEADERS)
    return()
  endif()
  if(target STREQUAL first)
    target_precompile_headers(${target} PRIVATE ${COMMON_HEADERS} ${ARGN})
  else()
    target_precompile_headers(${target} REUSE_FROM ${first})
  endif()
endfunction()

# unite(TARGET): the files of a folder share what they include and the templates that they use.
function(unite target)
  if(KESTREL_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    # GCC warns of types of an unnamed namespace in a file that another one includes.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()

# kestrel_library(FOLDER SOURCES glob... LINKS library... PRIVATE library...)
function(kestrel_library folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE" ${ARGN})
  if(NOT ARG_SOURCES)
    set(ARG_SOURCES src/${folder}/*.cpp)
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${ARG_SOURCES})
  list(FILTER sources EXCLUDE REGEX "_main\\.cpp$|/nodelets\\.cpp$")
  string(REPLACE "/" "_" name kestrel_${folder})
  add_library(${name} STATIC ${sources})
  target_link_libraries(${name} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE})
  # Set as compile options, because kestrel_warnings is not exported and cannot be linked here.
  target_compile_options(${name} PRIVATE $<TARGET_PROPERTY:kestrel_warnings,INTERFACE_COMPILE_OPTIONS>)
  if(name STREQUAL "kestrel_commands")
    precompile(${name} ${name} <CLI/CLI.hpp>)
  elseif(KESTREL_WITH_ROS AND name MATCHES "^kestrel_(messages|recording|ros)")
    precompile(${name} kestrel_messages ${ROS_HEADERS})
  else()
    precompile(${name} kestrel_geometry)
  endif()
  if(NOT name MATCHES "^kestrel_ros")  # the files of nodes have the same names for their own constants
    unite(${name})
  endif()
  string(REPLACE "/" "_" export_name ${folder})
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${export_name})
  add_library(kestrel_slam::${export_name} ALIAS ${name})
  set(KESTREL_LIBRARIES ${KESTREL_LIBRARIES} ${name} PARENT_SCOPE)
endfunction()

# ---- core: no ROS; third-party libraries are only Eigen, nanoflann for nearest points, Ceres for the graph,
# and protobuf, zlib and xxhash for session files
kestrel_library(geometry LINKS Eigen3::Eigen PRIVATE $<BUILD_INTERFACE:nanoflann::nanoflann>)
target_include_directories(kestrel_geometry PUBLIC
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
kestrel_library(sensor LINKS kestrel_geometry)
kestrel_library(map LINKS kestrel_sensor)
kestrel_library(matching LINKS kestrel_map)
kestrel_library(mapping LINKS kestrel_matching)
kestrel_library(graph LINKS kestrel_mapping PRIVATE Ceres::ceres)
kestrel_library(session LINKS kestrel_graph
  PRIVATE protobuf::libprotobuf-lite ZLIB::ZLIB PkgConfig::XXHASH)
protobuf_generate_cpp(session_format_sources session_format_headers src/session/session.proto)
target_sources(kestrel_session PRIVATE ${session_format_sources})
target_include_directories(kestrel_session SYSTEM PRIVATE ${PROJECT_BINARY_DIR})
set_source_files_properties(${session_format_sources} PROPERTIES COMPILE_OPTIONS -w)
kestrel_library(merging LINKS kestrel_session PRIVATE PkgConfig::XXHASH)
kestrel_library(link LINKS kestrel_session PRIVATE PkgConfig::XXHASH PkgConfig::ZMQ)
kestrel_library(filter LINKS kestrel_sensor)
kestrel_library(tracking LINKS kestrel_map)
kestrel_library(lidar LINKS kestrel_tracking PRIVATE ${OCTOMAP_LIBRARIES})
target_include_directories(kestrel_lidar SYSTEM PRIVATE ${OCTOMAP_INCLUDE_DIRS})
kestrel_library(pipeline LINKS kestrel_session kestrel_filter kestrel_tracking)
kestrel_library(parameters LINKS kestrel_pipeline PRIVATE yaml-cpp)

# ---- messages: ROS message <-> core type
if(KESTREL_WITH_ROS)
  kestrel_library(messages LINKS kestrel_pipeline)
  add_dependencies(kestrel_messages ${PROJECT_NAME}_generate_messages_cpp)
  target_include_directories(kestrel_messages SYSTEM PUBLIC ${catkin_INCLUDE_DIRS})
  target_link_libraries(kestrel_messages PUBLIC ${catkin_LIBRARIES})
endif()

# ---- recordings, evaluation, reports
kestrel_library(simulation LINKS kestrel_sensor)
if(KESTREL_WITH_ROS)
  kestrel_library(recording SOURCES src/recording/*.cpp src/recording/bag/*.cpp
    LINKS kestrel_simulation kestrel_messages
    PRIVATE Boost::iostreams ${rosbag_storage_LIBRARIES})
  target_compile_definitions(kestrel_recording PUBLIC KESTREL_WITH_ROS)
  target_include_directories(kestrel_recording SYSTEM PUBLIC ${rosbag_storage_INCLUDE_DIRS})
else()
  kestrel_library(recording LINKS kestrel_simulation kestrel_map PRIVATE Boost::iostreams)
endif()
kestrel_library(offline LINKS kestrel_recording kestrel_parameters nlohmann_json::nlohmann_json)
set(COMMIT_FILE ${PROJECT_BINARY_DIR}/built_commit.cpp)
add_custom_target(built_commit BYPRODUCTS ${COMMIT_FILE} COMMAND ${CMAKE_COMMAND}
  -DSOURCE=${PROJECT_SOURCE_DIR} -DOUTPUT=${COMMIT_FILE} -P ${PROJECT_SOURCE_DIR}/cmake/commit.cmake)
add_dependencies(kestrel_offline built_commit)
target_sources(kestrel_offline PRIVATE ${COMMIT_FILE})
kestrel_library(evaluation LINKS kestrel_recording kestrel_mapping kestrel_tracking
  PRIVATE nlohmann_json::nlohmann_json)
kestrel_library(report LINKS kestrel_offline kestrel_evaluation PRIVATE PkgConfig::CAIRO geotiff TIFF::TIFF)
kestrel_library(experiments LINKS kestrel_report kestrel_merging kestrel_link kestrel_lidar)
kestrel_library(commands LINKS kestrel_report PRIVATE CLI11::CLI11)

# ---- nodes
if(KESTREL_WITH_ROS)
  kestrel_library(ros
    SOURCES src/ros/common/*.cpp src/ros/projector/*.cpp src/ros/mapper/*.cpp src/ros/filter/*.cpp src/ros/replay/*.cpp
    LINKS kestrel_messages kestrel_parameters Threads::Threads)
  # The lidar library writes maps for OctoMap, which the other nodes do not need.
  kestrel_library(ros/tracker LINKS kestrel_ros kestrel_lidar)
  kestrel_library(ros/panel SOURCES src/ros/panel/mapper_summary.cpp LINKS kestrel_messages)
  # hector's companions: not linked into the nodes that fly
  kestrel_library(ros/hector LINKS kestrel_ros kestrel_report)
  kestrel_library(ros/simulation LINKS kestrel_ros kestrel_recording)
  kestrel_library(ros/latency LINKS kestrel_ros PRIVATE ${rosbag_storage_LIBRARIES})
  target_include_directories(kestrel_ros_latency SYSTEM PUBLIC ${rosbag_storage_INCLUDE_DIRS})
endif()
