// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "kestrel_slam/map/atomic_file.h"
#include "room_log.h"
#include "temporary_folder.h"

namespace kestrel {

/// Tests of tools that map a log of a RoomFlight and write into the same temporary folder.
class RoomLogTest : public ::testing::Test {
 protected:
  explicit RoomLogTest(int scans)
      : log_(folder_.write("flight.clf", RoomFlight::carmenLog(scans))) {}

  std::string outputs(const std::string& name) const { return " --output " + folder_.file(name); }
  std::string read(const std::string& name) const { return readFile(folder_.file(name)); }

  TemporaryFolder folder_;
  std::string log_;
};

}  // namespace kestrel
