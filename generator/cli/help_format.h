// The help of all commands as a man page and as shell completions. Everything is read from the
// parser, so that no option is described twice.
//
//   add_help_format        the option --help-format, which prints one of them
//   offer  offer_choices   choices that the help lists and the shells complete
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace ensonify {

// Parsing ends at this option, as at --version.
void add_help_format(CLI::App& app, const std::string& version);

// The parser accepts other values too, and the command's own error names the nearest one.
void offer_choices(CLI::Option& option, const std::vector<std::string>& choices);

template <class Items>
void offer(CLI::Option& option, const Items& items) {
  std::vector<std::string> choices;
  for (const auto& item : items) choices.emplace_back(item.name);
  offer_choices(option, choices);
}

}  // namespace ensonify
