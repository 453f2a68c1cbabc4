// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/param.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace kestrel {

/// A mapper node as a process of its own.
class MapperProcess {
 public:
  explicit MapperProcess(const std::vector<std::string>& parameters) {
    ros::param::del("/mapper");  // of the node before
    std::vector<std::string> words = {KESTREL_MAPPER_NODE, "__name:=mapper",
                                      "_map_pub_period:=0.5"};
    words.insert(words.end(), parameters.begin(), parameters.end());
    pid_ = fork();
    if (pid_ != 0) return;
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  ~MapperProcess() { end(SIGINT); }
  MapperProcess(const MapperProcess&) = delete;
  MapperProcess& operator=(const MapperProcess&) = delete;

  /// Ends it with a signal and waits. Returns its status.
  int end(int signal) {
    int status = 0;
    if (pid_ <= 0) return status;
    kill(pid_, signal);
    waitpid(pid_, &status, 0);
    pid_ = 0;
    return status;
  }

  /// Waits for its end. Returns its exit code.
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = 0;
    return WEXITSTATUS(status);
  }

 private:
  pid_t pid_ = 0;
};

}  // namespace kestrel
