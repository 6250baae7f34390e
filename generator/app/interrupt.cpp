#include "app/interrupt.h"

#include <time.h>
#include <unistd.h>

#include <atomic>
#include <csignal>

#include "core/error.h"

namespace ensonify {
namespace {

// A signal handler reaches nothing but variables of the process; the threads look at this one.
std::atomic<bool> g_interrupted = false;

// Batch systems tell a script and its program at once, and the script passes on what it was told:
// what comes within so long is one signal.
constexpr long long kOneSignal_ns = 1'000'000'000;
std::atomic<long long> g_first_ns = 0;
static_assert(std::atomic<bool>::is_always_lock_free);
static_assert(std::atomic<long long>::is_always_lock_free);

extern "C" void remember_signal(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const long long now_ns = now.tv_sec * 1'000'000'000LL + now.tv_nsec;
  g_interrupted = true;
  long long first_ns = 0;
  if (g_first_ns.compare_exchange_strong(first_ns, now_ns)) return;
  if (now_ns - first_ns < kOneSignal_ns) return;
  // A second one ends the program at once; whole files are kept anyhow.
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

extern "C" void end_at_once(int) { _exit(exit_code(ErrorKind::interrupted)); }

}  // namespace

void expect_interrupts() {
  std::signal(SIGINT, end_at_once);
  std::signal(SIGTERM, end_at_once);
}

void listen_for_interrupts() {
  std::signal(SIGINT, remember_signal);
  std::signal(SIGTERM, remember_signal);
  // Of a terminal that was closed; `nohup` has it ignored.
  if (std::signal(SIGHUP, remember_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

bool interrupted() { return g_interrupted; }

}  // namespace ensonify
