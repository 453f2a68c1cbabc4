# SPDX-License-Identifier: BSD-3-Clause
# One program for each file named *_main.cpp. The nodes are also built as nodelets.
set(KESTREL_PROGRAMS)

# kestrel_program(MAIN library...)
function(kestrel_program main)
  get_filename_component(name ${main} NAME_WE)
  string(REGEX REPLACE "_main$" "" name ${name})
  add_executable(${name} ${main})
  target_link_libraries(${name} PRIVATE ${ARGN} kestrel_warnings)
  set(KESTREL_PROGRAMS ${KESTREL_PROGRAMS} ${name} PARENT_SCOPE)
endfunction()

file(GLOB COMMANDS CONFIGURE_DEPENDS src/commands/*_main.cpp)
if(NOT KESTREL_WITH_ROS)
  list(FILTER COMMANDS EXCLUDE REGEX "/(carmen_to_bag|simulate_flight)_main\\.cpp$")
endif()
# map_recording compiles the headers for all.
list(PREPEND COMMANDS ${PROJECT_SOURCE_DIR}/src/commands/map_recording_main.cpp)
list(REMOVE_DUPLICATES COMMANDS)
set(PAGES ${PROJECT_BINARY_DIR}/pages)
file(MAKE_DIRECTORY ${PAGES}/man ${PAGES}/completions)
foreach(main ${COMMANDS})
  # Only few tools need the experiments, and scripts/demo builds none of them.
  file(STRINGS ${main} experiments REGEX "#include \"kestrel_slam/(experiments|merging|link|lidar)/")
  if(experiments)
    set(experiments kestrel_experiments)
  endif()
  kestrel_program(${main} kestrel_commands ${experiments} CLI11::CLI11)
  get_filename_component(name ${main} NAME_WE)
  string(REGEX REPLACE "_main$" "" name ${name})
  precompile(${name} map_recording <CLI/CLI.hpp>)
  # Man page and completion come from the options of the program.
  add_custom_command(TARGET ${name} POST_BUILD
    COMMAND ${name} --man-page > ${PAGES}/man/${name}.1
    COMMAND ${name} --bash-completion > ${PAGES}/completions/${name})
endforeach()
add_custom_target(map_batch_pages ALL
  COMMAND ${PROJECT_SOURCE_DIR}/scripts/map_batch --man-page > ${PAGES}/man/map_batch.1
  COMMAND ${PROJECT_SOURCE_DIR}/scripts/map_batch --bash-completion > ${PAGES}/completions/map_batch
  COMMAND ${PROJECT_SOURCE_DIR}/scripts/map_merger --man-page > ${PAGES}/man/map_merger.1
  COMMAND ${PROJECT_SOURCE_DIR}/scripts/map_merger --bash-completion > ${PAGES}/completions/map_merger)

if(KESTREL_WITH_ROS)
  foreach(main mapper/mapper_node projector/scan_projector_node filter/pose_filter_node replay/recorded_tf_node)
    kestrel_program(src/ros/${main}_main.cpp kestrel_ros)
  endforeach()
  kestrel_program(src/ros/tracker/tracker_node_main.cpp kestrel_ros_tracker)
  foreach(main hector_map_server hector_trajectory_server geotiff_node map_to_image_node)
    kestrel_program(src/ros/hector/${main}_main.cpp kestrel_ros_hector)
  endforeach()
  kestrel_program(src/ros/simulation/simulated_flight_main.cpp kestrel_ros_simulation)
  kestrel_program(src/ros/latency/measure_latency_main.cpp kestrel_ros_latency)
  kestrel_program(src/ros/replay/scan_joiner_main.cpp kestrel_messages)
  # The panel of rviz, where rviz can be built against.
  find_package(rviz QUIET)
  find_package(Qt5 QUIET COMPONENTS Widgets)
  if(rviz_FOUND AND Qt5_FOUND)
    add_library(kestrel_rviz SHARED src/ros/panel/mapper_panel.cpp src/ros/panel/mapper_panel.h)
    set_target_properties(kestrel_rviz PROPERTIES AUTOMOC ON)
    target_include_directories(kestrel_rviz SYSTEM PRIVATE ${rviz_INCLUDE_DIRS})
    target_link_libraries(kestrel_rviz PRIVATE kestrel_ros_panel ${rviz_LIBRARIES} Qt5::Widgets)
  else()
    message(STATUS "rviz (librviz-dev) was not found: the panel for rviz is not built")
  endif()
  add_library(kestrel_nodelets SHARED src/ros/nodelets.cpp)
  target_link_libraries(kestrel_nodelets PRIVATE kestrel_ros_tracker kestrel_warnings)
endif()
