#include <fmt/format.h>

#include <string_view>

#include "app/help_format.h"

namespace ensonify {
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

// The text with each of these characters behind a backslash.
std::string escaped(const std::string& text, std::string_view characters) {
  std::string result;
  for (const char c : text) {
    if (characters.find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}

// One word of a shell; zsh needs the long form of an apostrophe, and fish understands it too.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

// Cases of `$command $previous` for options that take a value. Without choices bash offers files.
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

// What may stand where no option's value is expected: options behind a hyphen, else `others`.
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

// One specification of zsh's _arguments: '(-o --output)'{-o,--output=}'[what]:value:_files'. The
// sign lets a value follow it as well as stand in the next word.
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
  // The file is read as the function's body when fpath leads to it, and sourced by hand otherwise.
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
