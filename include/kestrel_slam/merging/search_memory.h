// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace kestrel {

/// Results of searches, by a hash of all that they depend on: the scans, their poses in the local
/// frame of the mapper, which never change, and where the search begins. A result that is here
/// is the one that the search would give again, so maps that grow cost only what is new.
class SearchMemory {
 public:
  using Key = std::array<std::uint64_t, 2>;
  using Numbers = std::array<double, 16>;

  /// The result with this key. If it is not here, `search` makes it.
  const Numbers& result(const Key& key, const std::function<Numbers()>& search);

  /// What was asked for since the last call is kept, and all other results are forgotten.
  void forgetUnused();

  /// Searches that were made, because their results were not here.
  std::size_t searches() const { return searches_; }
  std::size_t size() const { return results_.size(); }

  /// The bytes of a file. `parameters`: all that the results depend on and that is not in the keys.
  std::string encode(const std::string& parameters) const;
  /// Takes the results of such a file. Nothing if it is damaged, or made with other parameters:
  /// then everything is searched again.
  void decode(const std::string& bytes, const std::string& parameters);

 private:
  struct Entry {
    Numbers numbers;
    bool used = false;
  };

  std::map<Key, Entry> results_;
  std::size_t searches_ = 0;
};

/// Makes a key of 128 bits.
class KeyMaker {
 public:
  void add(const std::string& text);
  void add(double value) { addBytes(&value, sizeof value); }
  void add(const SearchMemory::Key& key) { addBytes(key.data(), sizeof key); }
  void add(std::uint64_t value) { addBytes(&value, sizeof value); }
  SearchMemory::Key key() const;

 private:
  void addBytes(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }

  std::string bytes_;
};

}  // namespace kestrel
