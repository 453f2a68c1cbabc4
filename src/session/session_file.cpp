// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/session/session_file.h"

#include <google/protobuf/message_lite.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <utility>

#include "chunk_format.h"
#include "kestrel_slam/map/atomic_file.h"
#include "session_messages.h"

namespace kestrel {
namespace {

/// The kinds of chunks and the schema version that this program writes. It reads this and all older
/// ones.
struct Schema {
  const char* tag;
  std::uint32_t version;
};
constexpr Schema kInfo{"INFO", 1}, kSubmaps{"SUBM", 1}, kGraph{"GRAP", 1}, kKeyframes{"KEYF", 1};

/// A chunk ends as soon as it is longer. Damage costs at most one chunk.
constexpr std::size_t kChunkBytes = 1U << 18U;

void add(ChunkWriter& writer, const Schema& schema, const google::protobuf::MessageLite& message) {
  writer.add(schema.tag, schema.version, message.SerializeAsString());
}

/// Collects items in one message and begins another one when it is full.
template <typename Message>
class ChunkFiller {
 public:
  ChunkFiller(ChunkWriter& writer, const Schema& schema) : writer_(writer), schema_(schema) {}

  /// `next(message)` adds an item to the message and returns it.
  template <typename Items, typename Next>
  void add(const Items& items, Next next) {
    for (const auto& item : items) {
      auto* const added = next(message_);
      setMessage(item, *added);
      bytes_ += added->ByteSizeLong();
      if (bytes_ >= kChunkBytes) flush();
    }
  }
  void flush() {
    if (bytes_ > 0) kestrel::add(writer_, schema_, message_);
    message_.Clear();
    bytes_ = 0;
  }

 private:
  ChunkWriter& writer_;
  Schema schema_;
  Message message_;
  std::size_t bytes_ = 0;
};

template <typename Message>
Message parsed(const std::string& content) {
  Message message;
  if (!message.ParseFromString(content)) throw std::runtime_error("it is not what its tag says");
  return message;
}

template <typename Messages, typename Items>
void append(const Messages& messages, Items& items) {
  items.reserve(items.size() + static_cast<std::size_t>(messages.size()));
  for (const auto& message : messages) items.push_back(fromMessage(message));
}

void addKeyframes(const Session& session, ChunkWriter& writer) {
  ChunkFiller<session_format::Keyframes> filler(writer, kKeyframes);
  filler.add(session.keyframes, [](auto& message) { return message.add_keyframes(); });
  filler.flush();
}

void addSubmaps(const Session& session, ChunkWriter& writer) {
  ChunkFiller<session_format::Submaps> filler(writer, kSubmaps);
  filler.add(session.submaps, [](auto& message) { return message.add_submaps(); });
  filler.flush();
}

void addGraph(const Session& session, ChunkWriter& writer) {
  ChunkFiller<session_format::Graph> filler(writer, kGraph);
  std::size_t vertices = 0;
  filler.add(session.vertices, [&vertices](auto& message) {
    if (message.vertices_size() == 0) message.set_vertices_before(vertices);
    ++vertices;
    return message.add_vertices();
  });
  filler.flush();
  const auto afterVertices = [&vertices](auto& message) -> auto& {
    message.set_vertices_before(vertices);
    return message;
  };
  filler.add(session.edges, [&](auto& message) { return afterVertices(message).add_edges(); });
  filler.add(session.loops, [&](auto& message) { return afterVertices(message).add_loops(); });
  filler.add(session.odometry,
             [&](auto& message) { return afterVertices(message).add_odometry(); });
  filler.flush();
}

/// Puts the chunks of a file together.
class SessionReader {
 public:
  /// Throws std::runtime_error if a newer version has written one of the chunks.
  explicit SessionReader(const ChunkReader& file) : file_(file) {
    for (std::size_t i = 0; i < file.chunks().size(); ++i) requireKnown(file.chunks()[i], i);
    session_.written_by = file.writer();
  }

  /// Reads all chunks. What is wrong with one of them goes to `damage`.
  void readAll(std::vector<std::string>& damage) {
    for (std::size_t i = 0; i < file_.chunks().size(); ++i) {
      try {
        take(file_.chunks()[i]);
      } catch (const std::runtime_error& error) {
        damage.push_back(file_.chunks()[i].describe(i) + ": " + error.what());
      }
    }
    if (!info_) return damage.push_back("the parameters and statistics (chunk INFO) are missing");
    reportLost("keyframes", session_.keyframes.size(), info_->keyframes(), damage);
    reportLost("submaps", session_.submaps.size(), info_->submaps(), damage);
  }

  Session& session() { return session_; }

 private:
  void requireKnown(const Chunk& chunk, std::size_t number) const {
    for (const Schema& schema : {kInfo, kSubmaps, kGraph, kKeyframes}) {
      if (chunk.tag != schema.tag || chunk.schema_version <= schema.version) continue;
      throw std::runtime_error(chunk.describe(number) + " has the newer schema version " +
                               std::to_string(chunk.schema_version) + "; read the file with " +
                               file_.writer());
    }
  }

  void take(const Chunk& chunk) {
    if (chunk.tag == kInfo.tag) {
      info_ = parsed<session_format::Info>(file_.content(chunk));
      takeInfo(*info_, session_);
    } else if (chunk.tag == kSubmaps.tag) {
      const auto message = parsed<session_format::Submaps>(file_.content(chunk));
      append(message.submaps(), session_.submaps);
    } else if (chunk.tag == kKeyframes.tag) {
      const auto message = parsed<session_format::Keyframes>(file_.content(chunk));
      append(message.keyframes(), session_.keyframes);
    } else if (chunk.tag == kGraph.tag) {
      takeGraph(parsed<session_format::Graph>(file_.content(chunk)));
    }
  }

  void takeGraph(const session_format::Graph& graph) {
    if (graph.vertices_before() != session_.vertices.size()) {
      throw std::runtime_error("vertices before it are lost, so its numbers mean nothing");
    }
    append(graph.vertices(), session_.vertices);
    append(graph.edges(), session_.edges);
    append(graph.loops(), session_.loops);
    append(graph.odometry(), session_.odometry);
  }

  static void reportLost(const char* what, std::uint64_t found, std::uint64_t saved,
                         std::vector<std::string>& damage) {
    if (found == saved) return;
    damage.push_back("it has " + std::to_string(found) + " of " + std::to_string(saved) + ' ' +
                     what);
  }

  const ChunkReader& file_;
  std::optional<session_format::Info> info_;
  Session session_;
};

}  // namespace

std::string encodeSession(const Session& session) {
  const std::string problem = problemOf(session);
  if (!problem.empty()) throw std::invalid_argument("the session cannot be saved: " + problem);
  ChunkWriter writer(session.written_by);
  kestrel::add(writer, kInfo, infoMessage(session));
  addSubmaps(session, writer);
  addGraph(session, writer);
  addKeyframes(session, writer);
  return writer.finish();
}

void saveSession(const std::string& path, const Session& session) {
  writeFileAtomically(path, encodeSession(session));
}

Session decodeSession(const std::string& bytes) {
  const ChunkReader file(bytes);
  std::vector<std::string> damage = file.damage();
  if (damage.empty()) {
    SessionReader reader(file);
    reader.readAll(damage);
    const std::string problem = problemOf(reader.session());
    if (damage.empty() && problem.empty()) return std::move(reader.session());
    damage.push_back(problem);
  }
  throw std::runtime_error("the session is damaged: " + damage.front() +
                           "; session_info --repair keeps the rest");
}

bool isSessionFile(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  std::string start(chunk_format::kMagicBytes, '\0');
  std::ifstream(path, std::ios::binary)
      .read(start.data(), static_cast<std::streamsize>(start.size()));
  return start == chunk_format::kMagic;
}

std::string readSessionFile(const std::string& path) {
  std::error_code ignored;
  const bool is_plain = std::filesystem::is_regular_file(path, ignored);
  if (is_plain && std::ifstream(path) && !isSessionFile(path)) {
    throw std::runtime_error("cannot read " + path + ": it is not a session of kestrel_slam");
  }
  return readFile(path);
}

Session loadSession(const std::string& path) {
  const std::string bytes = readSessionFile(path);
  try {
    return decodeSession(bytes);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("cannot load " + path + ": " + error.what());
  }
}

RepairedSession repairSession(const std::string& bytes) {
  const ChunkReader file(bytes);
  RepairedSession repaired{{}, file.damage()};
  SessionReader reader(file);
  reader.readAll(repaired.damage);
  removeDangling(reader.session());
  const std::string problem = problemOf(reader.session());
  if (!problem.empty()) throw std::runtime_error("the session cannot be repaired: " + problem);
  repaired.session = std::move(reader.session());
  return repaired;
}

}  // namespace kestrel
