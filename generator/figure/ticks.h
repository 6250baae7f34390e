// Round numbers along an axis.
//
//   tick_step    1, 2 or 5 times a power of ten
//   ticks_in     its multiples between two ends
//   tick_text    a multiple as people write it
#pragma once

#include <string>
#include <vector>

namespace ensonify {

// The smallest that gives at most `most` steps. Needs span > 0, most >= 1.
double tick_step(double span, int most);

// In rising order, whichever end is larger.
std::vector<double> ticks_in(double end, double other_end, double step);

// With as many decimals as the step has, and a true minus sign.
std::string tick_text(double value, double step);

}  // namespace ensonify
