// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace kestrel {

/// Passes items from one thread to another. If the reader is too slow, the oldest items are
/// dropped.
template <typename T>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

  /// Returns false if the queue was full and the oldest item was removed.
  bool push(T item) {
    bool had_room = true;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      had_room = items_.size() < capacity_;
      if (!had_room) items_.pop_front();
      items_.push_back(std::move(item));
    }
    changed_.notify_one();
    return had_room;
  }

  /// Waits for an item. Empty after the queue was closed.
  std::optional<T> pop() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return closed_ || !items_.empty(); });
    if (closed_) return std::nullopt;
    T item = std::move(items_.front());
    items_.pop_front();
    return item;
  }

  /// Removes all items and returns their number.
  std::size_t clear() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::size_t count = items_.size();
    items_.clear();
    return count;
  }

  /// Closes the queue permanently and wakes the reader.
  void close() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      closed_ = true;
    }
    changed_.notify_all();
  }

 private:
  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<T> items_;
  bool closed_ = false;
};

}  // namespace kestrel
