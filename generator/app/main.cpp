#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <csignal>

#include "app/command_line.h"

namespace {

// Whoever starts it without standard output or error, as some schedulers do, would have messages
// written into the first files that it opens.
void open_standard_streams() {
  int descriptor = 0;
  while (descriptor >= 0 && descriptor <= 2) descriptor = open("/dev/null", O_RDWR);
  if (descriptor > 2) close(descriptor);
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // a file beyond ulimit -f is an error of writing like others
  // A ping's arrays are as large in every ping: kept, not given back to the system and cleared
  // page by page each time.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  // With a heap for each thread, those of the threads give back what is free all the same.
  mallopt(M_ARENA_MAX, 1);
  return ensonify::run_command_line(argc, argv);
}
