# SPDX-License-Identifier: BSD-3-Clause
# One program of unit tests for each folder of test/. The tests in messages/, recording/bag/
# and ros/ and the files named bag_* need ROS. The tests in ros/common/ need no ROS master.
find_package(GTest REQUIRED)
enable_testing()

function(kestrel_test folder)
  file(GLOB sources CONFIGURE_DEPENDS test/${folder}/*_test.cpp test/${folder}/*_fuzzer.cpp)
  if(NOT folder MATCHES "^(messages|recording/bag|ros/common)$")
    if(NOT KESTREL_WITH_ROS)
      list(FILTER sources EXCLUDE REGEX "/bag_[a-z_0-9]*_(test|fuzzer)\\.cpp$")
    elseif(KESTREL_ONLY_ROS_TESTS)
      list(FILTER sources INCLUDE REGEX "/(bag_[a-z_0-9]*_(test|fuzzer)|corpus_test)\\.cpp$")
    endif()
  endif()
  if(NOT sources)
    return()
  endif()
  string(REPLACE "/" "_" name ${folder})
  add_executable(test_${name} ${sources})
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}/test)
  target_link_libraries(test_${name} PRIVATE kestrel_commands kestrel_experiments kestrel_warnings GTest::gtest_main)
  target_compile_definitions(test_${name} PRIVATE
    KESTREL_SOURCE_DIR="${PROJECT_SOURCE_DIR}" KESTREL_TOOL_DIR="$<TARGET_FILE_DIR:map_recording>")
  if(folder STREQUAL "filter")
    target_link_libraries(test_filter PRIVATE Ceres::ceres)  # a reference solution
  endif()
  if(folder STREQUAL "lidar")
    target_include_directories(test_lidar SYSTEM PRIVATE ${OCTOMAP_INCLUDE_DIRS})
    target_link_libraries(test_lidar PRIVATE ${OCTOMAP_LIBRARIES})  # reads a map back
  endif()
  add_test(NAME ${name} COMMAND test_${name})
  # The longest tests start first, which shortens a parallel test run.
  if(folder MATCHES "^(mapping|experiments|matching)$")
    set_tests_properties(${name} PROPERTIES COST 100)
  endif()
endfunction()

foreach(folder geometry sensor map matching graph session merging link mapping filter tracking lidar pipeline
    parameters simulation recording
    offline evaluation report experiments commands fuzz)
  kestrel_test(${folder})
endforeach()
if(NOT KESTREL_ONLY_ROS_TESTS)
  add_test(NAME migration_doc COMMAND ${PROJECT_SOURCE_DIR}/test/scripts/migration_doc_test.py)
  add_test(NAME map_batch COMMAND ${PROJECT_SOURCE_DIR}/test/scripts/map_batch_test.py)
  add_test(NAME map_batch_slurm COMMAND ${PROJECT_SOURCE_DIR}/test/scripts/map_batch_slurm_test.py)
  add_test(NAME session_link COMMAND ${PROJECT_SOURCE_DIR}/test/scripts/session_link_test.py)
  set_tests_properties(session_link PROPERTIES ENVIRONMENT KESTREL_TOOL_DIR=$<TARGET_FILE_DIR:map_recording>)
  set_tests_properties(map_batch_slurm session_link PROPERTIES SKIP_RETURN_CODE 77)
endif()
if(KESTREL_WITH_ROS)
  add_test(NAME report_in_chromium
    COMMAND ${PROJECT_SOURCE_DIR}/test/scripts/report_test.py $<TARGET_FILE_DIR:map_recording>)
  set_tests_properties(report_in_chromium PROPERTIES SKIP_RETURN_CODE 77)
  kestrel_test(messages)
  kestrel_test(recording/bag)
  kestrel_test(ros/common)
  target_link_libraries(test_ros_common PRIVATE kestrel_ros_hector kestrel_ros_panel)
  add_dependencies(test_ros_common mapper_node scan_projector_node pose_filter_node tracker_node geotiff_node
    map_to_image_node simulated_flight)
endif()

# Tests on live nodes: rostest starts a master and the nodes of each .test file.
if(KESTREL_WITH_ROS AND CATKIN_ENABLE_TESTING)
  find_package(rostest REQUIRED)
  file(GLOB HELPERS CONFIGURE_DEPENDS test/ros/*.cpp)
  list(FILTER HELPERS EXCLUDE REGEX "_test\\.cpp$")
  add_library(kestrel_ros_testing STATIC EXCLUDE_FROM_ALL ${HELPERS})
  target_include_directories(kestrel_ros_testing PUBLIC ${PROJECT_SOURCE_DIR}/test ${PROJECT_SOURCE_DIR}/test/ros)
  target_link_libraries(kestrel_ros_testing
    PUBLIC kestrel_ros_latency kestrel_recording PRIVATE kestrel_warnings)
  file(GLOB ROS_TEST_SOURCES CONFIGURE_DEPENDS test/ros/*_test.cpp test/ros/*/*_test.cpp)
  list(FILTER ROS_TEST_SOURCES EXCLUDE REGEX "/ros/common/")
  if(NOT TARGET kestrel_rviz)
    list(FILTER ROS_TEST_SOURCES EXCLUDE REGEX "/ros/panel/")
  endif()
  foreach(source ${ROS_TEST_SOURCES})
    get_filename_component(name ${source} NAME_WE)
    add_executable(${name} ${source})
    target_link_libraries(${name} PRIVATE kestrel_ros_testing kestrel_warnings GTest::gtest
      ${rosbag_storage_LIBRARIES})
    target_compile_definitions(${name} PRIVATE KESTREL_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
      KESTREL_MAPPER_NODE="$<TARGET_FILE:mapper_node>"
      KESTREL_SCAN_PROJECTOR_NODE="$<TARGET_FILE:scan_projector_node>")
  endforeach()
  target_link_libraries(pipeline_parity_test PRIVATE kestrel_offline)
  target_link_libraries(replay_freiburg_test PRIVATE kestrel_evaluation)
  target_link_libraries(several_vehicles_test PRIVATE kestrel_evaluation kestrel_merging)
  target_link_libraries(follow_merged_test PRIVATE kestrel_merging)
  file(GLOB ROS_TESTS CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} test/ros/*.test
    test/ros/*/*.test)
  if(TARGET kestrel_rviz)
    find_package(Qt5 REQUIRED COMPONENTS Widgets Test)
    target_include_directories(panel_test SYSTEM PRIVATE ${rviz_INCLUDE_DIRS})
    target_link_libraries(panel_test PRIVATE ${rviz_LIBRARIES} Qt5::Widgets Qt5::Test)
    add_dependencies(panel_test kestrel_rviz)
  else()
    list(FILTER ROS_TESTS EXCLUDE REGEX "/ros/panel/")
  endif()
  foreach(test ${ROS_TESTS})
    add_rostest(${test})
  endforeach()
endif()
