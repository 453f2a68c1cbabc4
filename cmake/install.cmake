# SPDX-License-Identifier: BSD-3-Clause
# Installs programs, libraries and headers, and an export for other CMake projects:
# find_package(kestrel_slam) gives the targets kestrel_slam::<folder>
# (cmake/kestrel_slam-extras.cmake).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(EXPORT_FOLDER share/${PROJECT_NAME}/cmake)

if(KESTREL_WITH_ROS)
  install(TARGETS ${KESTREL_PROGRAMS} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  install(TARGETS kestrel_nodelets LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
  if(TARGET kestrel_rviz)
    install(TARGETS kestrel_rviz LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
  endif()
  catkin_install_python(PROGRAMS scripts/map_batch scripts/map_merger DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  install(DIRECTORY launch config rviz DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
  install(DIRECTORY include/${PROJECT_NAME}/ DESTINATION include/${PROJECT_NAME})
  set(LIBRARY_FOLDER ${CATKIN_PACKAGE_LIB_DESTINATION})
  set(BATCH_FOLDER ${CATKIN_PACKAGE_BIN_DESTINATION})
else()
  install(TARGETS ${KESTREL_PROGRAMS} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(PROGRAMS scripts/map_batch DESTINATION ${CMAKE_INSTALL_BINDIR})
  set(BATCH_FOLDER ${CMAKE_INSTALL_DATADIR}/${PROJECT_NAME})
  install(DIRECTORY include/${PROJECT_NAME}/ DESTINATION include/${PROJECT_NAME}
    PATTERN ros EXCLUDE PATTERN messages EXCLUDE PATTERN bag EXCLUDE)
  set(LIBRARY_FOLDER ${CMAKE_INSTALL_LIBDIR})
  install(FILES cmake/kestrel_slam-extras.cmake DESTINATION ${EXPORT_FOLDER}
    RENAME ${PROJECT_NAME}Config.cmake)
  write_basic_package_version_file(${PROJECT_NAME}ConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/${PROJECT_NAME}ConfigVersion.cmake
    DESTINATION ${EXPORT_FOLDER})
endif()

install(DIRECTORY ${PAGES}/man/ DESTINATION share/man/man1)
install(DIRECTORY ${PAGES}/completions/ DESTINATION share/bash-completion/completions)

# The parts of map_batch lie beside it, or in share/ where others install their programs too.
install(DIRECTORY scripts/kestrel_batch DESTINATION ${BATCH_FOLDER}
  FILES_MATCHING PATTERN *.py PATTERN *.html PATTERN __pycache__ EXCLUDE)

install(TARGETS ${KESTREL_LIBRARIES} EXPORT ${PROJECT_NAME}Targets
  ARCHIVE DESTINATION ${LIBRARY_FOLDER})
install(EXPORT ${PROJECT_NAME}Targets NAMESPACE ${PROJECT_NAME}:: DESTINATION ${EXPORT_FOLDER})
if(KESTREL_WITH_ROS)
  # For packages that are built with the devel space of catkin.
  export(EXPORT ${PROJECT_NAME}Targets NAMESPACE ${PROJECT_NAME}::
    FILE ${CATKIN_DEVEL_PREFIX}/${EXPORT_FOLDER}/${PROJECT_NAME}Targets.cmake)
endif()
