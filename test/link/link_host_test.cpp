// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/link/link_host.h"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <fstream>
#include <thread>
#include <zmq.hpp>

#include "temporary_folder.h"

namespace kestrel {
namespace {

const StreamId kStream{"uav0", 3};

/// A port of the loopback that is free now.
std::string freeAddress() {
  zmq::context_t context;
  zmq::socket_t socket(context, zmq::socket_type::router);
  socket.bind("tcp://127.0.0.1:*");
  return socket.get(zmq::sockopt::last_endpoint);
}

std::shared_ptr<ChunkJournal> journalOf(std::size_t chunks) {
  auto journal = std::make_shared<ChunkJournal>("", kStream);
  for (std::size_t i = 0; i < chunks; ++i) journal->append(0, std::string(1500, 'x'));
  return journal;
}

std::uint64_t receivedBy(LinkHost& host) {
  const auto& streams = host.receiver().streams();
  const auto found = streams.find(kStream);
  return found == streams.end() ? 0 : found->second->last();
}

/// Runs both hosts until the receiver has `chunks`, or some seconds.
void run(LinkHost& sender, LinkHost& receiver, std::uint64_t chunks, double most_s = 8.0) {
  for (double s = 0.0; s < most_s && receivedBy(receiver) < chunks; s += 0.2) {
    std::thread other([&] { sender.run(0.2); });
    receiver.run(0.2);
    other.join();
  }
}

TEST(LinkHost, ChunksArriveAndARestartedHostGoesOn) {
  const TemporaryFolder folder;
  LinkHostConfig listening;
  listening.bind = freeAddress();
  listening.folder = folder.file("received");
  LinkHostConfig sending;
  sending.peers = {listening.bind};
  LinkHost sender(sending);
  const auto journal = journalOf(20);
  sender.send(journal);
  sender.run(0.3);  // nobody listens yet
  {
    LinkHost receiver(listening);
    run(sender, receiver, 20);
    EXPECT_EQ(receivedBy(receiver), 20U);
  }
  journal->append(0, "while the other host is down");
  sender.run(0.3);
  LinkHost receiver(listening);
  EXPECT_EQ(receivedBy(receiver), 20U) << "from its journal";
  run(sender, receiver, 21);
  EXPECT_EQ(receivedBy(receiver), 21U);
  EXPECT_EQ(receiver.receiver().streams().at(kStream)->numbers().ranges().size(), 1U);
}

TEST(LinkHost, OnlyHostsWithTheSameKeysAreHeard) {
  const TemporaryFolder folder;
  makeLinkKeys(folder.file("keys"));
  makeLinkKeys(folder.file("other"));
  EXPECT_THROW(makeLinkKeys(folder.file("keys")), std::runtime_error);
  LinkHostConfig listening;
  listening.bind = freeAddress();
  listening.keys = folder.file("keys");
  LinkHost receiver(listening);
  for (const std::string& keys : {std::string(), folder.file("other")}) {
    LinkHostConfig sending;
    sending.peers = {listening.bind};
    sending.keys = keys;
    LinkHost sender(sending);
    sender.send(journalOf(3));
    run(sender, receiver, 3, 1.5);
    EXPECT_EQ(receivedBy(receiver), 0U) << keys;
  }
  LinkHostConfig sending;
  sending.peers = {listening.bind};
  sending.keys = listening.keys;
  LinkHost sender(sending);
  sender.send(journalOf(3));
  run(sender, receiver, 3);
  EXPECT_EQ(receivedBy(receiver), 3U);
}

TEST(LinkHost, NobodyElseListens) {
  // Who answers at the address, but has no keys or other ones, hears nothing.
  const TemporaryFolder folder;
  makeLinkKeys(folder.file("keys"));
  makeLinkKeys(folder.file("other"));
  LinkHostConfig sending;
  sending.peers = {freeAddress()};
  sending.keys = folder.file("keys");
  LinkHost sender(sending);
  sender.send(journalOf(3));
  for (const std::string& keys : {std::string(), folder.file("other")}) {
    LinkHostConfig listening;
    listening.bind = sending.peers.front();
    listening.keys = keys;
    LinkHost receiver(listening);
    run(sender, receiver, 3, 1.5);
    EXPECT_EQ(receivedBy(receiver), 0U) << keys;
  }
  EXPECT_EQ(sender.missing(), 3U);
}

TEST(LinkHost, APublicKeyIsNotEnough) {
  const TemporaryFolder folder;
  makeLinkKeys(folder.file("keys"));
  LinkHostConfig listening;
  listening.bind = freeAddress();
  listening.keys = folder.file("keys");
  LinkHost receiver(listening);
  std::ifstream file(listening.keys);
  std::string word, server_key;
  file >> word >> server_key;
  char public_key[41], secret_key[41];
  ASSERT_EQ(zmq_curve_keypair(public_key, secret_key), 0);
  zmq::context_t context;
  zmq::socket_t stranger(context, zmq::socket_type::dealer);
  stranger.set(zmq::sockopt::linger, 0);
  stranger.set(zmq::sockopt::curve_serverkey, server_key);
  stranger.set(zmq::sockopt::curve_publickey, std::string(public_key));
  stranger.set(zmq::sockopt::curve_secretkey, std::string(secret_key));
  stranger.connect(listening.bind);
  LinkMessage message;
  message.kind = LinkMessage::Kind::kChunk;
  message.stream = kStream;
  message.chunk = {1, 0, "content"};
  stranger.send(zmq::buffer(encode(message)), zmq::send_flags::dontwait);
  receiver.run(1.0);
  EXPECT_EQ(receivedBy(receiver), 0U);
  const std::vector<std::string> problems = receiver.takeProblems();
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_NE(problems.front().find("other keys"), std::string::npos) << problems.front();
}

TEST(LinkHost, AnotherVersionIsSaid) {
  // A peer that sends a message of version 9 is answered, and the user hears of it.
  LinkHostConfig listening;
  listening.bind = freeAddress();
  LinkHost receiver(listening);
  LinkMessage message;
  message.stream = kStream;
  message.last = 1;
  std::string bytes = encode(message);
  bytes.resize(bytes.size() - 8);
  bytes[4] = 9;
  const std::uint64_t checksum = XXH64(bytes.data(), bytes.size(), 0);
  for (int i = 0; i < 8; ++i) bytes += static_cast<char>((checksum >> (8 * i)) & 0xFFU);
  zmq::context_t context;
  zmq::socket_t newer(context, zmq::socket_type::dealer);
  newer.set(zmq::sockopt::linger, 0);
  newer.connect(listening.bind);
  newer.send(zmq::buffer(bytes));
  receiver.run(0.5);
  zmq::message_t answer;
  ASSERT_TRUE(newer.recv(answer, zmq::recv_flags::dontwait));
  EXPECT_EQ(decode(answer.to_string())->kind, LinkMessage::Kind::kOtherVersion);
  const std::vector<std::string> problems = receiver.takeProblems();
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_NE(problems.front().find("version"), std::string::npos) << problems.front();
}

TEST(LinkHost, GarbageDoesNotDisturb) {
  LinkHostConfig listening;
  listening.bind = freeAddress();
  LinkHost receiver(listening);
  zmq::context_t context;
  zmq::socket_t noise(context, zmq::socket_type::dealer);
  noise.set(zmq::sockopt::linger, 0);
  noise.connect(listening.bind);
  for (int i = 0; i < 50; ++i) noise.send(zmq::buffer(std::string(50, 'n')));
  noise.send(zmq::buffer(std::string(5'000'000, 'n')));  // too much: the connection is closed
  LinkHostConfig sending;
  sending.peers = {listening.bind};
  LinkHost sender(sending);
  sender.send(journalOf(5));
  run(sender, receiver, 5);
  EXPECT_EQ(receivedBy(receiver), 5U);
  EXPECT_EQ(receiver.takeProblems().size(), 1U) << "said once";
}

TEST(LinkHost, BadAddressesAndKeysAreSaid) {
  LinkHostConfig config;
  config.peers = {"nowhere"};
  EXPECT_THROW(LinkHost{config}, std::runtime_error);
  config.peers.clear();
  config.keys = "/does/not/exist";
  EXPECT_THROW(LinkHost{config}, std::runtime_error);
}

}  // namespace
}  // namespace kestrel
