// SPDX-License-Identifier: BSD-3-Clause
// What a peer may send, how much of it, and in which order.
#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "kestrel_slam/link/session_link.h"

namespace kestrel {
namespace {

const StreamId kPeerStream{"uav0", 7};

TEST(LinkPeers, APeerCannotSendALocalVehicleOrTooManyStreams) {
  LinkConfig config;
  config.max_streams = 2;
  LinkReceiver receiver([](const StreamId& id) { return std::make_shared<ChunkJournal>("", id); },
                        config);
  receiver.addLocal("uav1");
  LinkMessage message;
  message.kind = LinkMessage::Kind::kOffer;
  message.last = 1;
  message.stream = {"uav1", 1};
  EXPECT_FALSE(receiver.receive(message)) << "two vehicles with one name";
  for (std::uint64_t epoch = 0; epoch < 5; ++epoch) {
    message.stream = {"uav2", epoch};
    EXPECT_EQ(receiver.receive(message).has_value(), epoch < 2);
  }
  EXPECT_EQ(receiver.streams().size(), 2U);
  EXPECT_EQ(receiver.refused().size(), 2U);
}

TEST(LinkPeers, ManyStreamsCannotFillTheDisk) {
  LinkConfig config;
  config.max_bytes = 20'000;
  LinkReceiver receiver([](const StreamId& id) { return std::make_shared<ChunkJournal>("", id); },
                        config);
  LinkMessage message;
  message.kind = LinkMessage::Kind::kChunk;
  message.chunk = {1, 0, std::string(1'000, 'x')};
  for (message.stream = kPeerStream; message.stream.epoch < 57; ++message.stream.epoch)
    receiver.receive(message);
  std::uint64_t bytes = 0;
  for (const auto& [id, journal] : receiver.streams()) bytes += journal->bytes();
  EXPECT_LT(bytes, 24'000U);
  EXPECT_EQ(receiver.refused().count("too much data"), 1U);
}

TEST(LinkPeers, APeerCannotFillTheDisk) {
  LinkConfig config;
  config.max_stream_bytes = 5'000;
  LinkReceiver receiver([](const StreamId& id) { return std::make_shared<ChunkJournal>("", id); },
                        config);
  LinkMessage message;
  message.kind = LinkMessage::Kind::kChunk;
  message.stream = kPeerStream;
  message.chunk.content = std::string(1'000, 'x');
  for (int i = 0; i < 100; ++i) {
    ++message.chunk.number;
    receiver.receive(message);
  }
  EXPECT_LT(receiver.streams().at(kPeerStream)->bytes(), 7'000U);
  EXPECT_EQ(receiver.refused().count("too much data"), 1U);
}

TEST(LinkPeers, AnotherVersionIsAnswered) {
  LinkReceiver receiver([](const StreamId& id) { return std::make_shared<ChunkJournal>("", id); });
  LinkMessage message;
  message.kind = LinkMessage::Kind::kOtherVersion;
  message.version = 9;
  const auto answer = receiver.receive(message);
  ASSERT_TRUE(answer);
  LinkSender sender;
  LinkMessage other = *decode(*answer);
  EXPECT_EQ(other.kind, LinkMessage::Kind::kOtherVersion);
  other.version = 9;
  sender.receive(other, 1.0);
  EXPECT_EQ(sender.otherVersion(), 9);
  EXPECT_FALSE(sender.next(2.0));
}

TEST(LinkPeers, APeerThatIsUpdatedGetsEverything) {
  LinkSender sender;
  const auto journal = std::make_shared<ChunkJournal>("", kPeerStream);
  journal->append(0, "content");
  sender.addStream(journal);
  LinkMessage other;
  other.kind = LinkMessage::Kind::kOtherVersion;
  other.version = 9;
  sender.receive(other, 1.0);
  const auto offer = sender.next(2.0);
  ASSERT_TRUE(offer);
  EXPECT_EQ(decode(*offer)->kind, LinkMessage::Kind::kOffer);
  EXPECT_FALSE(sender.next(2.1)) << "no chunks for another version";
  LinkReceiver updated([](const StreamId& id) { return std::make_shared<ChunkJournal>("", id); });
  sender.receive(*decode(*updated.receive(*decode(*offer))), 2.2);
  EXPECT_EQ(sender.otherVersion(), 0);
  const auto chunk = sender.next(2.3);
  ASSERT_TRUE(chunk);
  EXPECT_EQ(decode(*chunk)->kind, LinkMessage::Kind::kChunk);
}

TEST(LinkPeers, TheNewestOfAllStreamsComesFirst) {
  // A vehicle was restarted while nobody listened: its old map must not delay the new one.
  LinkSender sender;
  std::vector<std::shared_ptr<ChunkJournal>> journals;
  for (const std::uint64_t epoch : {1U, 2U}) {
    journals.push_back(std::make_shared<ChunkJournal>("", StreamId{"uav0", epoch}));
    for (int i = 0; i < 50; ++i) journals.back()->append(0, std::string(100, 'x'));
    sender.addStream(journals.back());
  }
  LinkReceiver receiver([](const StreamId& id) { return std::make_shared<ChunkJournal>("", id); });
  std::vector<std::pair<std::uint64_t, std::uint64_t>> arrived;
  for (double now = 1.0; arrived.size() < 4; now += 0.1) {
    ASSERT_LT(now, 5.0);
    const auto message = sender.next(now);
    if (!message) continue;
    if (const LinkMessage sent = *decode(*message); sent.kind == LinkMessage::Kind::kChunk)
      arrived.emplace_back(sent.stream.epoch, sent.chunk.number);
    if (const auto answer = receiver.receive(*decode(*message)))
      sender.receive(*decode(*answer), now);
  }
  const std::set<std::pair<std::uint64_t, std::uint64_t>> newest(arrived.begin(), arrived.end());
  EXPECT_EQ(newest.count({1, 50}) + newest.count({2, 50}) + newest.count({2, 49}), 3U);
}

std::size_t residentBytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * 4096;
}

TEST(LinkPeers, TheMemoryIsBoundedWhileNobodyListens) {
  const auto journal = std::make_shared<ChunkJournal>("", kPeerStream);
  LinkSender sender;
  sender.addStream(journal);
  const std::size_t before = residentBytes();
  for (int second = 0; second < 300; ++second) {
    journal->append(0, std::string(200'000, 'x'));
    for (int i = 0; i < 10; ++i) sender.next(second + 0.1 * i);
  }
  EXPECT_GT(journal->bytes(), 60'000'000U);
  EXPECT_LT(residentBytes(), before + 10'000'000U);
}

}  // namespace
}  // namespace kestrel
