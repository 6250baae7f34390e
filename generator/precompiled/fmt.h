// The same for the folders that print, which use fmt.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <set>
#include <unordered_map>

#include "precompiled/std.h"
