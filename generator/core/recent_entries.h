// What threads share by key and make once.
//
//   RecentEntries   the entries in use, and the last ones
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <mutex>

namespace ensonify {

// May be used from several threads at once; what protects the content of an entry is up to it.
template <class Key, class Entry>
class RecentEntries {
 public:
  explicit RecentEntries(std::size_t kept = 2) : kept_(kept) {}

  // The same entry as long as anybody holds it or it is among the last `kept` that were asked
  // for; a new one otherwise.
  std::shared_ptr<Entry> at(const Key& key) {
    const std::lock_guard lock(mutex_);
    std::erase_if(entries_, [](const auto& entry) { return entry.second.expired(); });
    std::shared_ptr<Entry> found = entries_[key].lock();
    if (!found) entries_[key] = found = std::make_shared<Entry>();
    std::erase(last_, found);
    last_.push_back(found);
    if (last_.size() > kept_) last_.pop_front();
    return found;
  }

 private:
  std::size_t kept_;
  std::mutex mutex_;
  std::map<Key, std::weak_ptr<Entry>> entries_;
  std::deque<std::shared_ptr<Entry>> last_;  // in the order of use
};

}  // namespace ensonify
