#include "app/interrupt.h"

#include <csignal>

namespace ensonify {
namespace {

// A signal handler reaches nothing but a variable of the process.
volatile std::sig_atomic_t g_signal = 0;

extern "C" void remember_signal(int signal) {
  g_signal = signal;
  // A second one ends the program at once; whole files are kept anyhow.
  std::signal(signal, SIG_DFL);
}

}  // namespace

void listen_for_interrupts() {
  std::signal(SIGINT, remember_signal);
  std::signal(SIGTERM, remember_signal);
}

bool interrupted() { return g_signal != 0; }

}  // namespace ensonify
