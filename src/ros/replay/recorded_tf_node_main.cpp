// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/replay/recorded_transforms.h"

namespace {

/// The help of the node lists this parameter. The node reads it itself.
struct Config {
  std::string own_frames;
};

std::vector<kestrel::Parameter> parametersOf(Config& config) {
  kestrel::Parameter own;
  own.name = "own_frames";
  own.description =
      "Frames, separated by commas, whose transform to the parent is left out, because another "
      "node "
      "publishes it.";
  own.value = &config.own_frames;
  own.group = "Frames";
  return {own};
}

}  // namespace

int main(int argc, char** argv) {
  using namespace kestrel;
  constexpr NodeProgram kProgram = {
      "recorded_tf", "recorded_tf_node",
      "passes tf of a recording from recorded/tf and recorded/tf_static to\n"
      "/tf and /tf_static, without the transforms that the nodes of the replay publish themselves.",
      "roslaunch kestrel_slam replay.launch bag:=/absolute/path.bag"};
  return runNode<RecordedTransforms, Config>(argc, argv, kProgram);
}
