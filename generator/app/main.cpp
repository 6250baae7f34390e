#include <malloc.h>

#include "app/command_line.h"

int main(int argc, char** argv) {
  // A ping's arrays are as large in every ping: kept, not given back to the system and cleared
  // page by page each time.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  // With a heap for each thread, those of the threads give back what is free all the same.
  mallopt(M_ARENA_MAX, 1);
  return ensonify::run_command_line(argc, argv);
}
