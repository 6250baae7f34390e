// Commits one fault by name and ends with 0: whoever notices must end the process otherwise.
#include <chrono>
#include <climits>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "core/parallel.h"

namespace {

// Two items that start together on two threads and write one variable: no luck of timing hides it.
int race() {
  int shared = 0;
  ensonify::Workers(2).for_each(2, [&](std::size_t i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    for (int k = 0; k < 1000; ++k) shared += static_cast<int>(i) + k;
  });
  return shared;
}

int heap_overflow(std::size_t count) {
  std::vector<int> values(count);
  const int* data = values.data();
  return data[count];
}

int signed_overflow(int one) { return INT_MAX + one; }

// Nothing points to the block when the program ends.
int leak(std::size_t count) {
  int* volatile lost = new int[count + 1]();
  const int value = lost[count];
  lost = nullptr;
  return value;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string fault = argc > 1 ? argv[1] : "";
  int result = 0;
  if (fault == "race") result = race();
  if (fault == "heap-overflow") result = heap_overflow(static_cast<std::size_t>(argc));
  if (fault == "leak") result = leak(static_cast<std::size_t>(argc));
  if (fault == "signed-overflow") result = signed_overflow(argc - 1);
  std::printf("nobody noticed (%d)\n", result);
  return 0;
}
