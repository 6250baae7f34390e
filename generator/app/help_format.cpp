#include "app/help_format.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>
#include <utility>

#include "dataset/texts.h"
#include "scenario/schema.h"

namespace ensonify {
namespace {

// The names in the braces of "TEXT:{auto,cpu}".
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
  if (option.get_name() == "--set") {
    for (const std::string& path : key_paths()) read.choices.push_back(path + "=");
  }
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

// roff would take a line that begins with a dot or an apostrophe as a request, and would typeset a
// hyphen.
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
    if (format == "schema") text = scenario_schema();
    if (format == "outputs") text = outputs_text();
    text.pop_back();  // the parser's exit adds the last line feed
    throw CLI::CallForVersion(text, 0);
  };
  app.add_option_function<std::string>(
         "--help-format", print,
         "print the help of all commands as a man page or as completions for a shell, or the "
         "JSON Schema of scenarios for editors, or the table of image planes as JSON")
      ->check(CLI::IsMember({"man", "bash", "zsh", "fish", "schema", "outputs"}));
}

void offer_choices(CLI::Option& option, const std::vector<std::string>& choices) {
  option.check(CLI::Validator([](std::string&) { return std::string(); },
                              fmt::format("{{{}}}", fmt::join(choices, ",")), "offered"));
}

namespace {

std::string joined(const std::vector<std::string>& words, const char* between) {
  return fmt::format("{}", fmt::join(words, between));
}

std::vector<std::string> command_names(const Help& help) {
  std::vector<std::string> names;
  for (const HelpCommand& command : help.commands) names.push_back(command.name);
  return names;
}

std::vector<std::string> option_names(const HelpCommand& command) {
  std::vector<std::string> names;
  for (const HelpOption& option : command.options) {
    names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

// The text with a backslash before each of these characters.
std::string escaped(const std::string& text, std::string_view characters) {
  std::string result;
  for (const char c : text) {
    if (characters.find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}

// One word of a shell. zsh needs the long form of an apostrophe, which fish also understands.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

// Cases of `$command $previous` for options with a value. Without choices bash offers files.
std::string bash_values(const HelpCommand& command, const std::string& name) {
  std::string text;
  for (const HelpOption& option : command.options) {
    if (option.value.empty()) continue;
    std::vector<std::string> patterns;
    for (const std::string& word : option.names) {
      patterns.push_back(fmt::format("\"{} {}\"", name, word));
    }
    text += fmt::format("    {}) words=\"{}\" ;;\n", joined(patterns, " | "),
                        joined(option.choices, " "));
  }
  return text;
}

// Words where no option value is expected: options after a hyphen, otherwise `others`.
std::string bash_words(const HelpCommand& command, const std::string& name,
                       const std::vector<std::string>& others) {
  return fmt::format(
      "    \"{0} \"*) if [[ $current == -* ]]; then words=\"{1}\"; else words=\"{2}\"; fi ;;\n",
      name, joined(option_names(command), " "), joined(others, " "));
}

std::vector<std::string> positional_choices(const HelpCommand& command) {
  return command.positionals.empty() ? std::vector<std::string>()
                                     : command.positionals.front().choices;
}

std::string zsh_values(const HelpOption& option) {
  return option.choices.empty() ? "_files" : fmt::format("({})", joined(option.choices, " "));
}

// One specification of zsh's _arguments: '(-o --output)'{-o,--output=}'[what]:value:_files'. With
// the equals sign a value can follow it or be the next word.
std::string zsh_option(const HelpOption& option) {
  std::string action;
  if (!option.value.empty()) action = ":value:" + zsh_values(option);
  std::vector<std::string> names = option.names;
  for (std::string& name : names) {
    if (name.starts_with("--") && !option.value.empty()) name += '=';
  }
  const std::string what =
      quoted(fmt::format("[{}]{}", escaped(option.description, "[]:\\"), action));
  if (names.size() == 1) return (option.repeats ? "\\*" : "") + names.front() + what;
  return fmt::format("'({})'{{{}}}{}", joined(option.names, " "), joined(names, ","), what);
}

std::string zsh_arguments(const HelpCommand& command) {
  std::string text = "_arguments -C";
  for (const HelpOption& option : command.options) text += " \\\n        " + zsh_option(option);
  for (const HelpOption& option : command.positionals) {
    text +=
        " \\\n        " + quoted(fmt::format("::{}:{}", option.names.front(), zsh_values(option)));
  }
  return text;
}

std::string fish_option(const HelpOption& option, const std::string& condition) {
  std::string text = fmt::format("complete -c ensonify -n {}", quoted(condition));
  for (const std::string& name : option.names) {
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  if (!option.choices.empty()) {
    text += fmt::format(" -x -a {}", quoted(joined(option.choices, " ")));
  } else if (!option.value.empty()) {
    text += " -r";
  }
  return text + fmt::format(" -d {}\n", quoted(option.description));
}

}  // namespace

std::string bash_completion(const Help& help) {
  const std::vector<std::string> commands = command_names(help);
  std::string text = fmt::format(
      R"(# bash completions of ensonify, printed by ensonify --help-format bash.
_ensonify() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}} command= words= i
  # bash splits --option=VALUE at the sign.
  if [[ $current == = ]]; then
    current=
  elif [[ $previous == = ]]; then
    previous=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case ${{COMP_WORDS[i]}} in
      {}) command=${{COMP_WORDS[i]}}; break ;;
    esac
  done
  case "$command $previous" in
)",
      joined(commands, " | "));
  text += bash_values(help.program, "");
  for (const HelpCommand& command : help.commands) text += bash_values(command, command.name);
  text += bash_words(help.program, "", commands);
  for (const HelpCommand& command : help.commands) {
    text += bash_words(command, command.name, positional_choices(command));
  }
  return text + R"(  esac
  # Without words of its own bash completes file names.
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  # A key of --set goes on with its value.
  if [[ ${COMPREPLY[0]-} == *= ]]; then compopt -o nospace 2>/dev/null || :; fi
}
complete -o bashdefault -o default -F _ensonify ensonify
)";
}

std::string zsh_completion(const Help& help) {
  std::string text =
      "#compdef ensonify\n# Printed by ensonify --help-format zsh.\n_ensonify() {\n  local -a "
      "commands=(\n";
  for (const HelpCommand& command : help.commands) {
    text += fmt::format("    {}\n", quoted(fmt::format("{}:{}", command.name,
                                                       escaped(command.description, ":\\"))));
  }
  text += "  )\n  local context state line\n  typeset -A opt_args\n  " +
          zsh_arguments(help.program) +
          " \\\n        '1: :->command' '*:: :->rest'\n"
          "  [[ $state == command ]] && _describe command commands\n"
          "  [[ $state == rest ]] || return\n  case $line[1] in\n";
  for (const HelpCommand& command : help.commands) {
    text += fmt::format("    {})\n      {}\n      ;;\n", command.name, zsh_arguments(command));
  }
  // If zsh finds the file through fpath, it is the body of the function; otherwise it is sourced.
  return text +
         "  esac\n}\n"
         "if [[ $funcstack[1] == _ensonify ]]; then _ensonify \"$@\"; else compdef _ensonify "
         "ensonify; fi\n";
}

std::string fish_completion(const Help& help) {
  const std::string before =
      fmt::format("not __fish_seen_subcommand_from {}", joined(command_names(help), " "));
  std::string text = "# fish completions of ensonify, printed by ensonify --help-format fish.\n";
  for (const HelpOption& option : help.program.options) text += fish_option(option, before);
  for (const HelpCommand& command : help.commands) {
    text += fmt::format("complete -c ensonify -f -n {} -a {} -d {}\n", quoted(before), command.name,
                        quoted(command.description));
  }
  for (const HelpCommand& command : help.commands) {
    const std::string within = "__fish_seen_subcommand_from " + command.name;
    for (const HelpOption& option : command.options) text += fish_option(option, within);
    for (const std::string& choice : positional_choices(command)) {
      text += fmt::format("complete -c ensonify -f -n {} -a {}\n", quoted(within), choice);
    }
  }
  return text;
}

}  // namespace ensonify
