// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <string>

namespace kestrel {

/// Holds signals that end the process back while it exists, so that no temporary file remains.
class HeldSignals {
 public:
  HeldSignals();
  ~HeldSignals();
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

 private:
  sigset_t before_{};
};

/// A folder to write files to. While the object exists, other processes of this package that write
/// to the same folder wait, and signals are held back. What a process left that was killed is
/// removed by the next one.
class OutputFolder {
 public:
  static constexpr const char* kFileEnding = ".tmp";

  explicit OutputFolder(const std::string& path);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Replaces a file by one with the new content. A symbolic link with this name is replaced, its
  /// target is not touched. Throws std::runtime_error with the file and the reason.
  void write(const std::string& name, const std::string& content);
  void remove(const std::string& name);
  /// Throws std::runtime_error if this name is taken by something else than a file.
  void requireReplaceable(const std::string& name) const;
  /// Throws std::runtime_error if this file could not be written.
  void requireWritable(const std::string& name);
  /// Whether the file is there, or a link to nothing.
  bool has(const std::string& name) const;

  std::string pathOf(const std::string& name) const;

  /// Names of temporary files and folders: the n-th of this process.
  static std::string temporaryName(int n, const std::string& ending);
  static bool isTemporary(const std::string& name, const std::string& ending);
  /// Writes the names in a folder to the disk.
  static void sync(const std::string& path);

 private:
  void lock();
  void removeStale();
  std::string writeNameless(const std::string& content);
  std::string writeTemporary(const std::string& name, const std::string& content);

  HeldSignals signals_;
  std::string path_;
  int folder_ = -1;
  int open_error_ = 0;
  bool locked_ = false;
};

}  // namespace kestrel
