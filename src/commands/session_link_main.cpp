// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/commands/mapping_command.h"
#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/link/link_host.h"
#include "kestrel_slam/link/session_chunks.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> send;
  std::string receive, make_keys;
  LinkHostConfig host;
  double rate_kb = 200.0, seconds = 0.0;
  bool until_sent = false;
};

/// Looks every so many seconds whether a session was saved again, and writes what was received.
constexpr double kEvery_s = 1.0;

/// A session file of this host that a mapper saves again and again.
class SentFile {
 public:
  SentFile(std::string vehicle, std::string file, std::string folder)
      : vehicle_(std::move(vehicle)), file_(std::move(file)), folder_(std::move(folder)) {}

  const std::string& vehicle() const { return vehicle_; }

  /// Appends what is new. A session that begins anew gets another journal.
  void update(LinkHost& host) {
    std::error_code error;
    const auto time = fs::last_write_time(file_, error);
    if (error || time == time_) return;
    const Session session = loadSession(file_);
    time_ = time;
    const std::uint64_t epoch = epochOf(session);
    if (epoch == 0) return;
    if (!journal_ || journal_->stream().epoch != epoch) begin(epoch, host);
    cutter_->update(session);
  }

 private:
  void begin(std::uint64_t epoch, LinkHost& host) {
    char name[32];
    std::snprintf(name, sizeof name, "_%016llx.sent", static_cast<unsigned long long>(epoch));
    const std::string path =
        folder_.empty() ? "" : (fs::path(folder_) / (vehicle_ + name)).string();
    journal_ = std::make_shared<ChunkJournal>(path, StreamId{vehicle_, epoch});
    cutter_ = std::make_unique<SessionCutter>(*journal_);
    host.send(journal_);
  }

  std::string vehicle_, file_, folder_;
  fs::file_time_type time_;
  std::shared_ptr<ChunkJournal> journal_;
  std::unique_ptr<SessionCutter> cutter_;
};

std::vector<SentFile> sentFiles(const Options& options) {
  std::vector<SentFile> files;
  std::set<std::string> names;
  for (const std::string& argument : options.send) {
    const std::size_t equal = argument.find('=');
    const bool named = equal != std::string::npos;
    const std::string file = named ? argument.substr(equal + 1) : argument;
    const std::string name = named ? argument.substr(0, equal) : fs::path(file).stem().string();
    if (!isVehicleName(name))
      throw CLI::ValidationError("--send", "'" + name + "' is no name of a vehicle");
    if (!names.insert(name).second)
      throw CLI::ValidationError("--send", "two vehicles are called " + name);
    files.emplace_back(name, file, options.host.folder);
  }
  return files;
}

/// Writes VEHICLE.session, and for earlier maps of the same vehicle VEHICLE_EPOCH.session.
class ReceivedFiles {
 public:
  explicit ReceivedFiles(std::string folder) : folder_(std::move(folder)) {}

  void update(const LinkReceiver& receiver) {
    for (const auto& [stream, journal] : receiver.streams()) {
      std::uint64_t& written = written_[stream];
      if (journal->bytes() == written) continue;
      const Session session = assembledSession(*journal);
      if (!session.keyframes.empty()) saveSession(fileOf(stream, session), session);
      written = journal->bytes();
    }
  }

 private:
  /// The map that was begun last has the name of the vehicle.
  std::string fileOf(const StreamId& stream, const Session& session) {
    auto& [time, epoch] = newest_[stream.vehicle];
    const double began = session.keyframes.front()->time;
    if (epoch != 0 && epoch != stream.epoch && began < time) return named(stream);
    if (epoch != 0 && epoch != stream.epoch) {
      std::error_code ignored;
      fs::rename(fs::path(folder_) / (stream.vehicle + ".session"), named({stream.vehicle, epoch}),
                 ignored);
    }
    time = began;
    epoch = stream.epoch;
    return (fs::path(folder_) / (stream.vehicle + ".session")).string();
  }

  std::string named(const StreamId& stream) const {
    return (fs::path(folder_) / (stream.vehicle + "_" + std::to_string(stream.epoch) + ".session"))
        .string();
  }

  std::string folder_;
  std::map<StreamId, std::uint64_t> written_;
  std::map<std::string, std::pair<double, std::uint64_t>> newest_;  // time and epoch
};

void update(std::vector<SentFile>& files, LinkHost& host) {
  for (SentFile& file : files) {
    try {
      file.update(host);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "session_link: %s: %s\n", file.vehicle().c_str(), error.what());
    }
  }
}

void run(Options options) {
  if (!options.make_keys.empty()) return makeLinkKeys(options.make_keys);
  stopOnSignals();
  options.host.link.bytes_per_s = 1e3 * options.rate_kb;
  std::vector<SentFile> files = sentFiles(options);
  if (!options.host.folder.empty()) prepareOutput(options.host.folder);
  if (!options.receive.empty()) prepareOutput(options.receive);
  LinkHost host(options.host);
  ReceivedFiles received(options.receive);
  for (double elapsed = 0.0; !stopRequested(); elapsed += kEvery_s) {
    update(files, host);
    host.run(kEvery_s);
    if (!options.receive.empty()) received.update(host.receiver());
    for (const std::string& problem : host.takeProblems())
      std::fprintf(stderr, "session_link: %s\n", problem.c_str());
    if (options.until_sent && !files.empty() && host.missing() == 0) return;
    if (options.seconds > 0.0 && elapsed >= options.seconds) return;
  }
}

void check(const Options& options) {
  if (!options.make_keys.empty()) return;
  if (options.send.empty() && options.receive.empty())
    throw CLI::RequiredError("--send or --receive");
  if (!options.send.empty() && options.host.peers.empty())
    throw CLI::RequiredError("--connect (--send sends to these hosts)");
  if (!options.receive.empty() && options.host.bind.empty())
    throw CLI::RequiredError("--listen (--receive is for what arrives there)");
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Carries sessions between hosts, over a network that may fail: everything arrives once, the "
      "newest first, after any break or restart.\n"
      "Exit code 0: done or stopped; 1: bad input; 2: wrong usage.");
  Options options;
  app.add_option("--send", options.send,
                 "session file of a vehicle of this host, or NAME=FILE; it may be saved again at "
                 "any time")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--receive", options.receive, "folder for the sessions of other hosts");
  app.add_option("--journal", options.host.folder,
                 "folder that remembers what was sent and received, for restarts");
  app.add_option("--listen", options.host.bind, "address of this host, such as tcp://*:5601");
  app.add_option("--connect", options.host.peers,
                 "address of another host, such as tcp://10.0.0.2:5601; may be repeated")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--keys", options.host.keys,
                 "file of keys: only hosts with the same file may join or listen");
  app.add_option("--make-keys", options.make_keys, "FILE: make such a file and exit");
  app.add_option("--rate", options.rate_kb, "limit of the traffic to each host, kB/s")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "end after this time");
  app.add_flag("--until-sent", options.until_sent, "end when the others have everything");
  return runTool(
      "session_link", app, argc, argv, [&] { run(options); }, [&] { check(options); });
}
