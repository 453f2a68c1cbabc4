# SPDX-License-Identifier: BSD-3-Clause
# What find_package(kestrel_slam) gives: one target for each library, kestrel_slam::<folder>, and
# kestrel_slam_LIBRARIES with those that run on a vehicle. Installed as kestrel_slamConfig.cmake
# without ROS; with ROS, catkin's own kestrel_slamConfig.cmake includes it.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3)
find_dependency(Threads)
# Needed by some of the libraries. CMake reports a missing one when such a library is linked.
foreach(package yaml-cpp nlohmann_json CLI11 nanoflann Ceres Protobuf ZLIB TIFF)
  find_package(${package} QUIET)
endforeach()
find_package(Boost QUIET COMPONENTS iostreams)
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND AND NOT TARGET PkgConfig::CAIRO)
  pkg_check_modules(CAIRO QUIET IMPORTED_TARGET cairo)
endif()
if(PkgConfig_FOUND AND NOT TARGET PkgConfig::XXHASH)
  pkg_check_modules(XXHASH QUIET IMPORTED_TARGET libxxhash)
endif()

if(PkgConfig_FOUND AND NOT TARGET PkgConfig::ZMQ)
  pkg_check_modules(ZMQ QUIET IMPORTED_TARGET libzmq)
endif()

# In the same catkin workspace the targets already exist.
if(NOT TARGET kestrel_slam::geometry)
  include(${kestrel_slam_DIR}/kestrel_slamTargets.cmake)
endif()
set(kestrel_slam_LIBRARIES kestrel_slam::parameters kestrel_slam::pipeline)
if(TARGET kestrel_slam::messages)
  list(INSERT kestrel_slam_LIBRARIES 0 kestrel_slam::messages)
endif()
