#include "world/models/models.h"

namespace ensonify {

// A piece of wall one brick thick: 1 m long, 0.6 m high, 0.24 m through.
Solid wall_solid() { return box({1, 0.24, 0.6}); }

}  // namespace ensonify
