// The program as a whole.
//
//   run_command_line   parses argv, runs a command, and maps its error to an exit status
//   program_version  program_commit   of this program; written at build time
#pragma once

namespace ensonify {

// Runs the program and returns the exit status: 0 success; 1 a bug or a damaged data set; 2 wrong
// usage or scenario; 3 some runs or sequences cannot be made, all others are; 4 reading or writing
// failed; 5 memory; 130 interrupted.
int run_command_line(int argc, const char* const* argv);

const char* program_version();
// 12 digits, "+" and a hash for a changed tree; "unknown" without .git.
const char* program_commit();

}  // namespace ensonify
