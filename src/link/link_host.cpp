// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/link/link_host.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <random>
#include <set>
#include <sstream>
#include <stdexcept>
#include <zmq.hpp>

#include "kestrel_slam/map/atomic_file.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

constexpr int kHeartbeatMs = 2000, kTimeoutMs = 6000, kReconnectMs = 200, kMaxReconnectMs = 2000;
/// Without it, the kernel waits longer and longer between its tries while the network is down.
constexpr int kConnectMs = 3000;
constexpr int kQueue = 200;           // messages
constexpr std::size_t kKeyText = 40;  // characters of a key in Z85
constexpr std::size_t kKeyBytes = 32;
constexpr double kStep_s = 0.05;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Keys {
  std::string public_key, secret_key;  // Z85
  bool empty() const { return public_key.empty(); }
};

Keys readKeys(const std::string& path) {
  Keys keys;
  if (path.empty()) return keys;
  std::istringstream lines(readFile(path));
  for (std::string name, key; lines >> name >> key;) {
    if (name == "public") keys.public_key = key;
    if (name == "secret") keys.secret_key = key;
  }
  if (keys.public_key.size() != kKeyText || keys.secret_key.size() != kKeyText)
    throw std::runtime_error(path + ": has no keys; make it with session_link --make-keys");
  return keys;
}

std::string hex(std::uint64_t value) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

/// Reads all parts of a message. Nothing if there is none.
std::vector<std::string> receiveParts(zmq::socket_t& socket) {
  std::vector<std::string> parts;
  zmq::message_t part;
  do {
    if (!socket.recv(part, zmq::recv_flags::dontwait)) return {};
    parts.push_back(part.to_string());
  } while (part.more());
  return parts;
}

}  // namespace

void makeLinkKeys(const std::string& path) {
  std::array<char, kKeyText + 1> public_key{}, secret_key{};
  if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0)
    throw std::runtime_error("this ZeroMQ has no CURVE; install libzmq5 with libsodium");
  if (fs::exists(path)) throw std::runtime_error(path + ": exists; remove it to make new keys");
  writeFileAtomically(
      path, std::string("public ") + public_key.data() + "\nsecret " + secret_key.data() + "\n");
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
}

struct LinkHost::Sockets {
  struct Peer {
    std::string address;
    zmq::socket_t socket;
    LinkSender sender;
  };

  explicit Sockets(const LinkHostConfig& host)
      : config(host),
        keys(readKeys(host.keys)),
        receiver([this](const StreamId& stream) { return open(stream); }, host.link,
                 std::random_device()()) {
    if (!keys.empty()) answerKeys();
    openJournals();
    if (!config.bind.empty()) listen();
    for (const std::string& address : config.peers) connect(address);
  }

  std::shared_ptr<ChunkJournal> open(const StreamId& stream) const {
    if (config.folder.empty()) return std::make_shared<ChunkJournal>("", stream);
    const std::string name = stream.vehicle + "_" + hex(stream.epoch) + ".journal";
    return std::make_shared<ChunkJournal>((fs::path(config.folder) / name).string(), stream);
  }

  void openJournals() {
    if (config.folder.empty()) return;
    fs::create_directories(config.folder);
    std::set<fs::path> files;
    for (const auto& entry : fs::directory_iterator(config.folder)) {
      if (entry.path().extension() == ".journal") files.insert(entry.path());
    }
    for (const fs::path& file : files) {
      try {
        receiver.addStream(std::make_shared<ChunkJournal>(file.string()));
      } catch (const std::runtime_error& error) {
        report(error.what());
      }
    }
  }

  /// Only hosts with the same keys may connect (ZeroMQ's ZAP).
  void answerKeys() {
    zap = zmq::socket_t(context, zmq::socket_type::rep);
    zap.bind("inproc://zeromq.zap.01");
  }

  void checkKey() {
    const std::vector<std::string> request = receiveParts(zap);
    if (request.empty()) return;
    std::array<std::uint8_t, kKeyBytes> expected{};
    zmq_z85_decode(expected.data(), keys.public_key.c_str());
    const bool good = request.size() >= 7 && request[5] == "CURVE" &&
                      request[6] == std::string(expected.begin(), expected.end());
    const std::string id = request.size() > 1 ? request[1] : "";
    const std::vector<std::string> answer = {
        "1.0", id, good ? "200" : "400", good ? "OK" : "unknown key", "", ""};
    for (std::size_t i = 0; i < answer.size(); ++i) {
      zap.send(zmq::buffer(answer[i]),
               i + 1 < answer.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
    }
    if (!good) report("a peer with other keys was refused; give all hosts the same file of keys");
  }

  void prepare(zmq::socket_t& socket) const {
    socket.set(zmq::sockopt::linger, 0);
    socket.set(zmq::sockopt::sndhwm, kQueue);
    socket.set(zmq::sockopt::rcvhwm, kQueue);
    socket.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(kMaxLinkMessage));
    socket.set(zmq::sockopt::heartbeat_ivl, kHeartbeatMs);
    socket.set(zmq::sockopt::heartbeat_timeout, kTimeoutMs);
    if (keys.empty()) return;
    socket.set(zmq::sockopt::curve_publickey, keys.public_key);
    socket.set(zmq::sockopt::curve_secretkey, keys.secret_key);
  }

  void listen() {
    server = zmq::socket_t(context, zmq::socket_type::router);
    prepare(server);
    if (!keys.empty()) server.set(zmq::sockopt::curve_server, true);
    try {
      server.bind(config.bind);
    } catch (const zmq::error_t& error) {
      throw std::runtime_error("cannot listen on " + config.bind + ": " + error.what());
    }
  }

  void connect(const std::string& address) {
    zmq::socket_t socket(context, zmq::socket_type::dealer);
    prepare(socket);
    // Nothing is queued while the peer is not there.
    socket.set(zmq::sockopt::immediate, true);
    socket.set(zmq::sockopt::connect_timeout, kConnectMs);
    socket.set(zmq::sockopt::reconnect_ivl, kReconnectMs);
    socket.set(zmq::sockopt::reconnect_ivl_max, kMaxReconnectMs);
    if (!keys.empty()) socket.set(zmq::sockopt::curve_serverkey, keys.public_key);
    try {
      socket.connect(address);
    } catch (const zmq::error_t& error) {
      throw std::runtime_error("bad address " + address + ": " + error.what() +
                               "; use tcp://HOST:PORT");
    }
    peers.push_back({address, std::move(socket), LinkSender(config.link)});
  }

  void step() {
    std::vector<zmq::pollitem_t> items;
    for (Peer& peer : peers) items.push_back({peer.socket.handle(), 0, ZMQ_POLLIN, 0});
    if (server) items.push_back({server.handle(), 0, ZMQ_POLLIN, 0});
    if (zap) items.push_back({zap.handle(), 0, ZMQ_POLLIN, 0});
    try {
      zmq::poll(items, std::chrono::milliseconds(static_cast<int>(1e3 * kStep_s)));
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
      return;  // a signal: the caller knows whether it is to stop
    }
    if (zap) checkKey();
    if (server) serve();
    for (Peer& peer : peers) talkTo(peer);
  }

  void serve() {
    for (auto parts = receiveParts(server); !parts.empty(); parts = receiveParts(server)) {
      const auto message = parts.size() == 2 ? decode(parts[1]) : std::nullopt;
      if (!message) {
        report("a peer sends what is not a message of session_link");
        continue;
      }
      const std::optional<std::string> answer = answerTo(*message);
      if (!answer) continue;
      server.send(zmq::buffer(parts[0]), zmq::send_flags::sndmore | zmq::send_flags::dontwait);
      server.send(zmq::buffer(*answer), zmq::send_flags::dontwait);
    }
  }

  std::optional<std::string> answerTo(const LinkMessage& message) {
    std::optional<std::string> answer;
    try {
      answer = receiver.receive(message);
    } catch (const std::exception& error) {
      report(error.what());  // a full disk: the chunk is not acknowledged and comes again
    }
    for (const auto& refused : receiver.refused()) report("refused: " + refused.first);
    return answer;
  }

  void talkTo(Peer& peer) {
    for (auto parts = receiveParts(peer.socket); !parts.empty();
         parts = receiveParts(peer.socket)) {
      const auto message = decode(parts.back());
      if (message) peer.sender.receive(*message, now());
    }
    if (peer.sender.otherVersion() != 0)
      report(peer.address + " speaks version " + std::to_string(peer.sender.otherVersion()) +
             " of the protocol, this is " + std::to_string(kLinkVersion) + "; update one of them");
    for (auto message = peer.sender.next(now()); message; message = peer.sender.next(now())) {
      if (!peer.socket.send(zmq::buffer(*message), zmq::send_flags::dontwait)) return;
    }
  }

  void report(const std::string& problem) {
    if (reported.insert(problem).second) problems.push_back(problem);
  }

  LinkHostConfig config;
  Keys keys;
  zmq::context_t context;
  zmq::socket_t zap, server;
  std::vector<Peer> peers;
  LinkReceiver receiver;
  std::set<std::string> reported;
  std::vector<std::string> problems;
};

LinkHost::LinkHost(const LinkHostConfig& config) : sockets_(std::make_unique<Sockets>(config)) {}
LinkHost::~LinkHost() = default;

void LinkHost::send(const std::shared_ptr<ChunkJournal>& journal) {
  sockets_->receiver.addLocal(journal->stream().vehicle);
  for (Sockets::Peer& peer : sockets_->peers) peer.sender.addStream(journal);
}

void LinkHost::run(double seconds) {
  for (const double end = now() + seconds; now() < end;) sockets_->step();
}

LinkReceiver& LinkHost::receiver() { return sockets_->receiver; }

std::uint64_t LinkHost::missing() const {
  std::uint64_t most = 0;
  for (const Sockets::Peer& peer : sockets_->peers) most = std::max(most, peer.sender.missing());
  return most;
}

std::vector<std::string> LinkHost::takeProblems() {
  std::vector<std::string> problems;
  problems.swap(sockets_->problems);
  return problems;
}

}  // namespace kestrel
