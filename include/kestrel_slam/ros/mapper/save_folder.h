// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kestrel {

/// Decides where the services that save and load may write and read. Everybody who reaches the ROS
/// master can call them.
///
/// A relative path cannot leave the first folder. An absolute path, or one that begins with ~, must
/// be inside of one of the folders. Links to other places are not followed. Only maps are replaced.
class SaveFolder {
 public:
  /// What messages say.
  struct Words {
    std::string rule, parameter;
  };

  /// `folder`: the value of the parameter. Empty: the working folder of the node, the home folder
  /// and the folder of temporary files.
  explicit SaveFolder(const std::string& folder,
                      Words words = {"maps are only saved", "save_folder"});

  /// The path without file extension, whose folder exists. Throws std::runtime_error with the
  /// reason if the path must not be written.
  std::string stemOf(const std::string& path) const;

  /// The path of a file. With `create`, its folder exists. Throws as stemOf.
  std::string fileOf(const std::string& path, bool create) const;

 private:
  void requireInside(const std::filesystem::path& stem, bool is_relative) const;

  Words words_;
  std::vector<std::filesystem::path> folders_;  ///< without links
};

}  // namespace kestrel
