#include "app/help_format.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

namespace ensonify {
namespace {

// The names between the braces of "TEXT:{auto,cpu}".
std::vector<std::string> choices_of(const std::string& type) {
  const std::size_t open = type.find(":{"), close = type.rfind('}');
  if (open == std::string::npos || close == std::string::npos) return {};
  return CLI::detail::split(type.substr(open + 2, close - open - 2), ',');
}

std::vector<std::string> names_of(const std::set<CLI::Option*>& options) {
  std::vector<std::string> names;
  for (const CLI::Option* option : options) names.push_back(option->get_name());
  std::sort(names.begin(), names.end());  // the set is ordered by address
  return names;
}

HelpOption read_option(const CLI::Option& option) {
  HelpOption read;
  for (const std::string& name : option.get_snames()) read.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) read.names.push_back("--" + name);
  if (read.names.empty()) read.names.push_back(option.get_name(true));
  if (option.get_items_expected_max() > 0) read.value = option.get_type_name();
  read.choices = choices_of(read.value);
  read.description = option.get_description();
  read.excludes = names_of(option.get_excludes());
  read.needs = names_of(option.get_needs());
  read.required = option.get_required();
  read.repeats = option.get_items_expected_max() > 1;
  return read;
}

HelpCommand read_command(const CLI::App& app) {
  HelpCommand read{app.get_name(), app.get_description(), app.get_footer(), {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    (option->nonpositional() ? read.options : read.positionals).push_back(read_option(*option));
  }
  return read;
}

// A line that begins with a dot or an apostrophe would be a request; a hyphen would be typeset.
std::string roff(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    const bool begins_line = escaped.empty() || escaped.back() == '\n';
    if (begins_line && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\') {
      escaped += "\\e";
    } else {
      escaped += c == '-' ? "\\-" : std::string(1, c);
    }
  }
  return escaped;
}

std::string joined(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string man_entry(const HelpOption& option) {
  std::string text = ".TP\n";
  for (std::size_t i = 0; i < option.names.size(); ++i) {
    text += fmt::format("{}\\fB{}\\fR", i == 0 ? "" : ", ", roff(option.names[i]));
  }
  if (!option.value.empty()) text += fmt::format(" \\fI{}\\fR", roff(option.value));
  text += "\n" + roff(option.description) + "\n";
  if (option.required) text += ".br\nRequired.\n";
  if (!option.excludes.empty()) {
    text += fmt::format(".br\nNot with {}.\n", roff(joined(option.excludes)));
  }
  if (!option.needs.empty()) {
    text += fmt::format(".br\nOnly with {}.\n", roff(joined(option.needs)));
  }
  return text;
}

std::string man_entries(const HelpCommand& command) {
  std::string text;
  for (const HelpOption& option : command.positionals) text += man_entry(option);
  for (const HelpOption& option : command.options) text += man_entry(option);
  if (!command.footer.empty()) text += ".PP\n.nf\n" + roff(command.footer) + "\n.fi\n";
  return text;
}

std::string synopsis(const HelpCommand& command) {
  std::string text = fmt::format("\\fBensonify {}\\fR [\\fIOPTIONS\\fR]", command.name);
  for (const HelpOption& option : command.positionals) {
    const std::string name = fmt::format("\\fI{}\\fR", option.names.front());
    text += option.required ? " " + name : " [" + name + "]";
  }
  return text;
}

}  // namespace

Help read_help(const CLI::App& app) {
  Help help{read_command(app), {}};
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    help.commands.push_back(read_command(*command));
  }
  return help;
}

std::string man_page(const Help& help, const std::string& version) {
  const HelpCommand& program = help.program;
  const std::size_t colon = program.description.find(": ");
  const std::string what =
      colon == std::string::npos ? program.description : program.description.substr(colon + 2);
  std::string text = fmt::format(
      ".TH ENSONIFY 1 \"\" \"ensonify {0}\" \"User Commands\"\n.ad l\n.SH NAME\n"
      "ensonify \\- {1}\n.SH SYNOPSIS\n\\fBensonify\\fR [\\fIOPTIONS\\fR] \\fICOMMAND\\fR\n",
      version, roff(what));
  for (const HelpCommand& command : help.commands) text += ".br\n" + synopsis(command) + "\n";
  text += ".SH OPTIONS\n" + man_entries(program) + ".SH COMMANDS\n";
  for (const HelpCommand& command : help.commands) {
    text += fmt::format(".SS \"{}\"\n{}\n.PP\n{}\n{}", roff("ensonify " + command.name),
                        roff(command.description), synopsis(command), man_entries(command));
  }
  return text;
}

void add_help_format(CLI::App& app, const std::string& version) {
  const auto print = [&app, version](const std::string& format) {
    const Help help = read_help(app);
    std::string text;
    if (format == "man") text = man_page(help, version);
    if (format == "bash") text = bash_completion(help);
    if (format == "zsh") text = zsh_completion(help);
    if (format == "fish") text = fish_completion(help);
    text.pop_back();  // the parser's exit ends the last line
    throw CLI::CallForVersion(text, 0);
  };
  app.add_option_function<std::string>(
         "--help-format", print,
         "print the help of all commands as a man page or as completions for a shell")
      ->check(CLI::IsMember({"man", "bash", "zsh", "fish"}));
}

void offer_choices(CLI::Option& option, const std::vector<std::string>& choices) {
  option.check(CLI::Validator([](std::string&) { return std::string(); },
                              fmt::format("{{{}}}", fmt::join(choices, ",")), "offered"));
}

}  // namespace ensonify
