// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/link/session_link.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "kestrel_slam/geometry/random.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

const StreamId kLinkStream{"uav0", 7};

/// A network that loses, delays, reorders, duplicates and damages messages.
class Network {
 public:
  double loss = 0.05, duplication = 0.05, damage = 0.02, delay_s = 0.2;
  bool open = true;

  void send(const std::string& bytes, double now) {
    sent_bytes += bytes.size();
    for (int copies = random_.uniform() < duplication ? 2 : 1; copies > 0; --copies) {
      if (!open || random_.uniform() < loss) continue;
      std::string arriving = bytes;
      if (random_.uniform() < damage) arriving[arriving.size() / 2] ^= 0x10;
      on_the_way_.emplace(now + delay_s * (0.5 + random_.uniform()), arriving);
    }
  }

  std::vector<std::string> arrivedBy(double now) {
    std::vector<std::string> result;
    while (!on_the_way_.empty() && on_the_way_.begin()->first <= now) {
      result.push_back(on_the_way_.begin()->second);
      on_the_way_.erase(on_the_way_.begin());
    }
    return result;
  }

  std::size_t sent_bytes = 0;

 private:
  Random random_{5};
  std::multimap<double, std::string> on_the_way_;
};

/// A vehicle that maps, a network, and a host that listens.
class Pair {
 public:
  explicit Pair(std::string folder) : folder_(std::move(folder)) {
    startSender();
    startReceiver();
  }

  void startSender() {
    journal_.reset();
    journal_ = std::make_shared<ChunkJournal>(path("sender"), kLinkStream);
    sender_ = std::make_unique<LinkSender>();
    sender_->addStream(journal_);
  }
  void startReceiver() {
    receiver_.reset();
    receiver_ = std::make_unique<LinkReceiver>(
        [this](const StreamId& id) { return std::make_shared<ChunkJournal>(path("receiver"), id); },
        LinkConfig(), ++starts_);
    if (std::filesystem::exists(path("receiver")))
      receiver_->addStream(std::make_shared<ChunkJournal>(path("receiver")));
    receiver_->on_chunk = [this](const StreamId&, const LinkChunk& chunk) {
      ++delivered[chunk.number];
      last_delivered = chunk.number;
    };
  }

  /// Runs for some seconds; the vehicle makes 2 kB twice a second.
  void run(double seconds, bool mapping = true) {
    constexpr double kStep = 0.05;
    for (double end = now + seconds; now < end; now += kStep) {
      if (mapping && now >= next_chunk_) {
        next_chunk_ = now + 0.5;
        journal_->append(0, std::string(2000, static_cast<char>('a' + journal_->last() % 26)));
      }
      for (int i = 0; i < 100; ++i) {
        const auto message = sender_->next(now);
        if (!message) break;
        there.send(*message, now);
      }
      for (const std::string& bytes : there.arrivedBy(now)) {
        const auto message = decode(bytes);
        if (!message) continue;
        if (const auto answer = receiver_->receive(*message)) back.send(*answer, now);
      }
      for (const std::string& bytes : back.arrivedBy(now)) {
        if (const auto message = decode(bytes)) sender_->receive(*message, now);
      }
    }
  }

  bool hasAll() const {
    for (std::uint64_t number = 1; number <= journal_->last(); ++number) {
      if (delivered.count(number) == 0 || delivered.at(number) != 1) return false;
    }
    return delivered.size() == journal_->last();
  }

  ChunkJournal& journal() { return *journal_; }
  LinkSender& sender() { return *sender_; }
  LinkReceiver& receiver() { return *receiver_; }

  Network there, back;
  std::map<std::uint64_t, int> delivered;
  std::uint64_t last_delivered = 0;
  double now = 100.0;

 private:
  std::string path(const char* name) const {
    return folder_.empty() ? "" : folder_ + name + ".journal";
  }

  std::string folder_;
  std::uint64_t starts_ = 0;
  std::shared_ptr<ChunkJournal> journal_;
  std::unique_ptr<LinkSender> sender_;
  std::unique_ptr<LinkReceiver> receiver_;
  double next_chunk_ = 0.0;
};

TEST(SessionLink, EverythingArrivesOnceThroughABadNetwork) {
  Pair pair("");
  pair.run(60.0);
  pair.run(10.0, false);
  EXPECT_TRUE(pair.hasAll()) << pair.delivered.size() << " of " << pair.journal().last();
  EXPECT_EQ(pair.sender().missing(), 0U);
  EXPECT_LT(pair.there.sent_bytes, 1.3 * 2000 * static_cast<double>(pair.journal().last()));
}

TEST(SessionLink, CatchesUpTenSecondsAfterAPartitionOfAMinute) {
  Pair pair("");
  pair.run(20.0);
  pair.there.open = pair.back.open = false;
  const std::size_t before = pair.there.sent_bytes;
  pair.run(60.0);
  EXPECT_LT(pair.there.sent_bytes - before, 50'000U) << "nobody listens";
  pair.there.open = pair.back.open = true;
  pair.run(10.0);
  pair.run(3.0, false);
  EXPECT_TRUE(pair.hasAll()) << pair.delivered.size() << " of " << pair.journal().last();
}

TEST(SessionLink, TheNewestChunksComeFirst) {
  Pair pair("");
  pair.there.open = false;
  pair.run(100.0);
  pair.there = Network();
  pair.there.loss = pair.there.duplication = pair.there.damage = 0.0;
  pair.run(6.0, false);
  ASSERT_FALSE(pair.delivered.empty());
  EXPECT_EQ(pair.delivered.rbegin()->first, pair.journal().last());
  EXPECT_EQ(pair.delivered.size(), pair.journal().last());
  EXPECT_LT(pair.last_delivered, 100U) << "the oldest come last";
}

TEST(SessionLink, BothSidesMayRestart) {
  const TemporaryFolder folder;
  Pair pair(folder.file(""));
  pair.run(15.0);
  pair.startReceiver();
  pair.run(15.0);
  pair.startSender();
  pair.run(15.0);
  pair.startSender();
  pair.startReceiver();
  pair.run(5.0, false);
  pair.run(5.0, false);
  EXPECT_TRUE(pair.hasAll()) << pair.delivered.size() << " of " << pair.journal().last();
}

TEST(SessionLink, AReceiverThatLostItsJournalGetsEverythingAgain) {
  Pair pair("");
  pair.run(20.0);
  pair.delivered.clear();
  pair.startReceiver();
  pair.run(10.0, false);
  EXPECT_TRUE(pair.hasAll()) << pair.delivered.size() << " of " << pair.journal().last();
}

TEST(SessionLink, AHalfWrittenChunkIsSentAgain) {
  const TemporaryFolder folder;
  Pair pair(folder.file(""));
  pair.run(10.0);
  const std::string file = folder.file("receiver.journal");
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 100);
  pair.startReceiver();
  pair.run(10.0, false);
  EXPECT_EQ(pair.receiver().streams().at(kLinkStream)->numbers().ranges().size(), 1U);
  EXPECT_EQ(pair.receiver().streams().at(kLinkStream)->last(), pair.journal().last());
}

TEST(SessionLink, OnlyTheNewestOfAKeyIsSent) {
  Pair pair("");
  for (int i = 0; i < 50; ++i) pair.journal().append(3, std::string(10'000, 'x'));
  pair.run(12.0, false);
  EXPECT_EQ(pair.delivered.size(), 1U);
  EXPECT_EQ(pair.last_delivered, 50U);
  EXPECT_EQ(pair.sender().missing(), 0U);
  EXPECT_LT(pair.there.sent_bytes, 40'000U);
}

TEST(SessionLink, TheRateIsLimited) {
  Pair pair("");
  for (int i = 0; i < 1000; ++i) pair.journal().append(0, std::string(5'000, 'x'));
  pair.run(5.0, false);
  EXPECT_LT(pair.there.sent_bytes, 1'250'000U);
  EXPECT_GT(pair.there.sent_bytes, 800'000U) << pair.delivered.size() << " delivered";
}

TEST(SessionLink, GarbageIsIgnored) {
  Random random(3);
  LinkMessage message;
  message.kind = LinkMessage::Kind::kChunk;
  message.stream = kLinkStream;
  message.chunk = {1, 0, "content"};
  const std::string good = encode(message);
  ASSERT_TRUE(decode(good));
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string damaged = good;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    EXPECT_FALSE(decode(damaged)) << "byte " << i;
    EXPECT_FALSE(decode(good.substr(0, i))) << "half a message";
  }
  for (int i = 0; i < 1000; ++i) {
    std::string noise;
    for (int k = 0; k < i % 100; ++k) noise += static_cast<char>(256 * random.uniform());
    EXPECT_FALSE(decode(noise));
  }
  EXPECT_FALSE(decode(std::string(2 * kMaxLinkMessage, 'x')));
}

}  // namespace
}  // namespace kestrel
