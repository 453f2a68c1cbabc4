# SPDX-License-Identifier: BSD-3-Clause
# Programs, libraries, headers, and an export that other CMake projects find.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(export_folder ${CMAKE_INSTALL_DATADIR}/${PROJECT_NAME}/cmake)

if(KESTREL_WITH_ROS)
  install(TARGETS ${KESTREL_PROGRAMS} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  install(TARGETS kestrel_nodelets LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
  install(DIRECTORY launch config rviz DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
else()
  install(TARGETS ${KESTREL_PROGRAMS} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY include/${PROJECT_NAME}/ DESTINATION include/${PROJECT_NAME})
