// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <set>

#include "../merging/building.h"
#include "kestrel_slam/merging/merged_session.h"
#include "kestrel_slam/session/session_file.h"
#include "run_command.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// The session of one vehicle. Returns the number of keyframes.
std::size_t saveFlight(const std::string& path, int first, int last) {
  const VehicleMap map = building::mapOf("x", {}, building::tour(first, last));
  MapMerger merger{MapperConfig(), LoopConfig()};
  merger.update(map);
  saveSession(path, mergedSession(merger.vehicles(), merger.merge(), 0));
  return map.keyframes.size();
}

TEST(SessionLinkCommand, TwoHostsWithOneVehicleNameLoseNothing) {
  const TemporaryFolder folder;
  std::set<std::size_t> sent;
  sent.insert(saveFlight(folder.file("first.session"), 0, 0));
  sent.insert(saveFlight(folder.file("second.session"), 2, 1));
  ASSERT_EQ(sent.size(), 2U);
  const std::string link = std::string(KESTREL_TOOL_DIR) + "/session_link ";
  const std::string address = "tcp://127.0.0.1:" + std::to_string(20'000 + getpid() % 10'000);
  const auto sending = [&](const std::string& name) {
    return link + "--send uav0=" + folder.file(name + ".session") + " --connect " + address +
           " --until-sent --seconds 30; ";
  };
  const std::string received = folder.file("received");
  const Outcome outcome =
      runCommand("bash -c '" + link + "--receive " + received + " --listen " + address +
                 " --seconds 60 & " + sending("first") + sending("second") + sending("first") +
                 "sleep 2; kill %1; wait %1; echo stopped with $?'");
  EXPECT_NE(outcome.output.find("stopped with 0"), std::string::npos) << outcome.output;
  std::set<std::size_t> arrived;
  for (const auto& file : std::filesystem::directory_iterator(received))
    arrived.insert(loadSession(file.path().string()).keyframes.size());
  EXPECT_EQ(arrived, sent) << "each is a file of its own";
  EXPECT_TRUE(std::filesystem::exists(received + "/uav0.session")) << "the newer flight";
}

}  // namespace
}  // namespace kestrel
