// What nearly every unit of the lower folders reads. Sources include what they use themselves: this header changes
// how long the compiler takes and nothing else.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "core/vec.h"
