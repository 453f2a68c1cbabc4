// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/recording/bag/bag_structure.h"

namespace kestrel {

/// The content of a bag as a plain file. A bag that is compressed as a whole (.gz, .bz2, .xz) is
/// decompressed into a temporary file, which nobody else can see and which disappears with this
/// object, also if the process is killed.
class UnpackedBag {
 public:
  /// Throws std::runtime_error with the name of the file, also if `stop` returns true.
  UnpackedBag(const std::string& path, const StopRequest& stop);
  ~UnpackedBag();
  UnpackedBag(const UnpackedBag&) = delete;
  UnpackedBag& operator=(const UnpackedBag&) = delete;

  /// The file to open.
  const std::string& path() const { return path_; }

 private:
  void unpack(const std::string& source, const StopRequest& stop);

  std::string path_;
  int file_ = -1;  ///< descriptor of the temporary file
};

}  // namespace kestrel
