#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <csignal>

#include "run/program.h"

namespace {

// Some schedulers start programs without standard output or error. Messages would then go into the
// first files that the program opens.
void open_standard_streams() {
  int descriptor = 0;
  while (descriptor >= 0 && descriptor <= 2) descriptor = open("/dev/null", O_RDWR);
  if (descriptor > 2) close(descriptor);
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // a file beyond ulimit -f is a write error like others
  // The arrays of a ping are equally large in every ping. They are kept instead of being returned
  // to the system and cleared page by page each time.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  // Uses one heap for all threads, because separate heaps of threads would still return free
  // memory.
  mallopt(M_ARENA_MAX, 1);
  return ensonify::run_command_line(argc, argv);
}
