// Text between double quotes, as JSON and YAML both read it. Private to export/.
#pragma once

#include <string>
#include <string_view>

namespace ensonify {

std::string quoted_text(std::string_view text);

}  // namespace ensonify
