// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace kestrel {

/// Hands items from one thread to another. Where the reader is too slow, the oldest are dropped.
template <typename T>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

  /// False where the oldest item had to make room.
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

  /// Waits for an item; nothing once the queue is closed.
  std::optional<T> pop() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return closed_ || !items_.empty(); });
    if (closed_) return std::nullopt;
    T item = std::move(items_.front());
    items_.pop_front();
    return item;
  }

  /// Forgets what waits; returns how many items that were.
  std::size_t clear() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::size_t count = items_.size();
    items_.clear();
    return count;
  }

  /// Ends the waiting of the reader for good.
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
