// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/session/chunk_file.h"
#include "kestrel_slam/session/session.h"

namespace kestrel {

/// The bytes of a session file. The same session gives the same bytes. Throws std::invalid_argument
/// if the session has a problem.
std::string encodeSession(const Session& session);

/// Encodes and writes a session. The file is the whole old one or the whole new one, whenever the
/// process is killed. Also throws std::runtime_error if the file cannot be written.
void saveSession(const std::string& path, const Session& session);

/// The session that encodeSession() made these bytes of. Chunks of unknown kinds are skipped.
/// Throws std::runtime_error if the bytes are damaged or come from a newer version.
Session decodeSession(const std::string& bytes);

/// Whether a plain file begins as a session file does. Reads only its first bytes.
bool isSessionFile(const std::string& path);

/// The bytes of a file that begins as a session file does. Other files may be larger than the
/// memory and are not read. Throws std::runtime_error with the file and the reason.
std::string readSessionFile(const std::string& path);

/// Throws std::runtime_error with the file, the reason and the place in the file.
Session loadSession(const std::string& path);

/// What could be read of a damaged file.
struct RepairedSession {
  Session session;
  std::vector<std::string> damage;  ///< what is wrong and what was lost; empty if the file is whole
};

/// Everything in the whole chunks of a file, without what refers to lost parts. Throws
/// std::runtime_error if this is no session file, or one of a newer version.
RepairedSession repairSession(const std::string& bytes);

}  // namespace kestrel
