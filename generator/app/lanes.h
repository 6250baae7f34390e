// Work that is done side by side, in order, until some of it fails.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"

namespace ensonify {

// Calls work(lane, i) for i = 0 ... count - 1, in this order, from `lanes` lanes at once, until one
// fails.
template <class Work>
Status in_lanes(int lanes, std::size_t count, Work work) {
  std::vector<Status> statuses(lanes);
  std::atomic<std::size_t> next = 0;
  Workers(lanes).for_each(lanes, [&](std::size_t lane) {
    for (std::size_t i; (i = next.fetch_add(1)) < count;) {
      statuses[lane] = work(lane, i);
      if (!statuses[lane]) {
        next = count;
        return;
      }
    }
  });
  for (const Status& status : statuses) {
    if (!status) return status;
  }
  return {};
}

}  // namespace ensonify
