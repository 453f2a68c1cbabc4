// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/commands/mapping_command.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/session/graph_session.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

constexpr char kLast[] = "last", kUnknown[] = "unknown";

/// The numbers of "X,Y,YAW"; nothing if the text is anything else.
std::optional<Pose2> poseOf(const std::string& text) {
  std::istringstream stream(text);
  Pose2 pose;
  char commas[2] = {};
  double yaw_deg = 0.0;
  if (!(stream >> pose.x >> commas[0] >> pose.y >> commas[1] >> yaw_deg)) return std::nullopt;
  if (commas[0] != ',' || commas[1] != ',' || !stream.eof()) return std::nullopt;
  pose.yaw = normalizeAngle(degToRad(yaw_deg));
  return pose.isFinite() ? std::optional(pose) : std::nullopt;
}

std::string startProblem(const std::string& text) {
  if (text == kLast || text == kUnknown || poseOf(text)) return "";
  return "must be last, unknown or X,Y,YAW (m and degrees), but is '" + text + "'";
}

/// Throws if the session could not be saved there, before a long run.
void requireSavable(const std::string& file) {
  std::error_code error;
  const fs::path folder = fs::absolute(file, error).parent_path();
  std::string problem;
  if (!fs::is_directory(folder, error)) {
    problem = "the folder " + folder.string() + " does not exist";
  } else if (fs::is_directory(file, error)) {
    problem = "it is a folder";
  } else if (fs::exists(file, error) && fs::file_size(file, error) > 0 && !isSessionFile(file)) {
    problem = "another file has this name, which is not a session";
  }
  if (problem.empty()) return;
  throw std::runtime_error("cannot save the session to " + file + ": " + problem +
                           "; choose another --save-session");
}

}  // namespace

void addSessionOptions(CLI::App& app, MappingArguments& arguments) {
  app.add_option("--session", arguments.session,
                 "FILE: continue this session (uses --loops); RECORDING becomes a part of its map");
  app.add_option("--start", arguments.start,
                 "where RECORDING begins in the map of --session: last: where the session ended "
                 "(default); X,Y,YAW in m and degrees; unknown. Old and new are joined once a loop "
                 "between them is verified")
      ->check(startProblem);
  app.add_option("--save-session", arguments.save_session,
                 "FILE: save the session, to continue it later (uses --loops)");
}

void loadSessionFor(const MappingArguments& arguments, const SlamConfig& config, RunOptions& run) {
  if (!arguments.save_session.empty()) requireSavable(arguments.save_session);
  if (arguments.session.empty()) return;
  run.session = std::make_shared<const Session>(loadSession(arguments.session));
  try {
    graphRecordOf(*run.session, config.mapper.grid.resolution_m);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(arguments.session + ": " + error.what());
  }
  if (arguments.start == kLast) {
    run.start = startAtEnd(*run.session);
  } else if (const std::optional<Pose2> pose = poseOf(arguments.start)) {
    run.start = givenStart(*pose);
  }
}

void saveSessionOf(const OfflineRun& run, const MappingArguments& arguments) {
  if (arguments.save_session.empty() || !run.session) return;
  saveSession(arguments.save_session, *run.session);
}

}  // namespace kestrel
