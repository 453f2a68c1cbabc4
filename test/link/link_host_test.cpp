// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/link/link_host.h"

#include <gtest/gtest.h>

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
