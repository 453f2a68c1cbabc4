// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace kestrel {

/// A folder for the files of one test. It is deleted after the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    const std::string name = (std::filesystem::temp_directory_path() / "kestrel_XXXXXX").string();
    std::string buffer = name;
    path_ = mkdtemp(buffer.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string file(const std::string& name) const { return path_ + "/" + name; }

  /// Writes a file and returns its path.
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(file(name), std::ios::binary) << content;
    return file(name);
  }

 private:
  std::string path_;
};

/// The folder of the real recordings; empty if it is absent.
inline std::string dataFolder() {
  const char* set = std::getenv("KESTREL_DATA");
  const std::string folder = set != nullptr ? set : KESTREL_SOURCE_DIR "/../shared/data";
  return std::filesystem::is_directory(folder) ? folder : std::string();
}

/// The message of the exception that `action` throws, or "nothing thrown".
template <typename Action>
std::string messageOf(Action action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "nothing thrown";
}

#define EXPECT_CONTAINS(text, part) \
  EXPECT_NE(std::string(text).find(part), std::string::npos) << "in: " << (text)

#define SKIP_WITHOUT_DATA(folder)                                                         \
  if ((folder).empty()) {                                                                 \
    GTEST_SKIP() << "no recordings: neither KESTREL_DATA nor ../shared/data is a folder"; \
  }

}  // namespace kestrel
