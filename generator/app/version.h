// Which program this is; written at build time.
#pragma once

namespace ensonify {

const char* program_version();
const char*
program_commit();  // 12 digits, "+" and a hash for a changed tree; "unknown" without .git

}  // namespace ensonify
