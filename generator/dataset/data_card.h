// README.md of a data set. Private to dataset/.
#pragma once

#include <string>

#include "dataset/finish.h"

namespace ensonify {

// What the data are, axes, units, beam order, licence, how to load them. Needs a sequence.
std::string data_card(const DatasetInfo& info);

}  // namespace ensonify
