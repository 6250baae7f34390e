// The help of all commands as a man page and as shell completions. Everything is read from the
// tables of the parser, so that no option is described twice.
//
//   HelpOption  HelpCommand  read_help   the contents of the parser as plain values
//   man_page  bash_completion  zsh_completion  fish_completion
//   add_help_format                      the option --help-format, which prints one of them
//   offer  offer_choices                 choices that the help lists and the shells complete
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace ensonify {

struct HelpOption {
  std::vector<std::string> names;    // "-o", "--output"; of a positional its one name, "SCENARIO"
  std::string value;                 // type of its value, "INT:INT in [0 - 4096]"; empty: a flag
  std::vector<std::string> choices;  // all valid values; empty: any
  std::string description;
  std::vector<std::string> excludes, needs;  // names of options
  bool required = false, repeats = false;
};

struct HelpCommand {
  std::string name, description, footer;
  std::vector<HelpOption> positionals, options;
};

struct Help {
  HelpCommand program;
  std::vector<HelpCommand> commands;
};

Help read_help(const CLI::App& app);

std::string man_page(const Help& help, const std::string& version);
std::string bash_completion(const Help& help);
std::string zsh_completion(const Help& help);
std::string fish_completion(const Help& help);

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
