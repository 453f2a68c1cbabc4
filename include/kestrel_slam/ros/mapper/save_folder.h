// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kestrel {

/// Decides where the service save_map may write. Everybody who reaches the ROS master can call it.
///
/// A relative path cannot leave the first folder. An absolute path, or one that begins with ~, must
/// be inside of one of the folders. Links to other places are not followed. Only maps are replaced.
class SaveFolder {
 public:
  /// `folder`: the parameter ~save_folder. Empty: the working folder of the node, the home folder
  /// and the folder of temporary files.
  explicit SaveFolder(const std::string& folder);

  /// The path without file extension, whose folder exists. Throws std::runtime_error with the
  /// reason if the path must not be written.
  std::string stemOf(const std::string& path) const;

 private:
  void requireInside(const std::filesystem::path& stem, bool is_relative) const;

  std::vector<std::filesystem::path> folders_;  ///< without links
};

}  // namespace kestrel
