#include "cli/help_format.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>

#include "dataset/texts.h"
#include "scenario/schema.h"

namespace ensonify {
namespace {

using CLI::detail::join;
using Words = std::vector<std::string>;

std::vector<const CLI::App*> commands_of(const CLI::App& program) {
  return program.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<const CLI::Option*> options_of(const CLI::App& command) {
  return command.get_options([](const CLI::Option* option) { return option->nonpositional(); });
}

std::vector<const CLI::Option*> positionals_of(const CLI::App& command) {
  return command.get_options([](const CLI::Option* option) { return !option->nonpositional(); });
}

// "-o" and "--output"; of a positional its one name, "SCENARIO".
Words names_of(const CLI::Option& option) {
  Words names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  if (names.empty()) names.push_back(option.get_name(true));
  return names;
}

bool has_value(const CLI::Option& option) {
  return option.get_items_expected_max() > 0 && !option.get_type_name().empty();
}

// All valid values, which are in the braces of the type "TEXT:{auto,cpu}"; empty: any.
Words choices_of(const CLI::Option& option) {
  Words choices;
  const std::string type = has_value(option) ? option.get_type_name() : "";
  const std::size_t open = type.find(":{"), close = type.rfind('}');
  if (open != std::string::npos && close != std::string::npos) {
    choices = CLI::detail::split(type.substr(open + 2, close - open - 2), ',');
  }
  if (option.get_name() == "--set") {
    for (const std::string& path : key_paths()) choices.push_back(path + "=");
  }
  return choices;
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

// The names of other options, as in "Only with --output."
std::string man_relation(const char* relation, const std::set<CLI::Option*>& options) {
  Words names;
  for (const CLI::Option* option : options) names.push_back(option->get_name());
  std::sort(names.begin(), names.end());  // the set is ordered by address
  return names.empty() ? "" : fmt::format(".br\n{} {}.\n", relation, roff(join(names, ", ")));
}

std::string man_entry(const CLI::Option& option) {
  const auto bold = [](const std::string& name) { return "\\fB" + roff(name) + "\\fR"; };
  std::string text = ".TP\n" + join(names_of(option), bold, ", ");
  if (has_value(option)) text += fmt::format(" \\fI{}\\fR", roff(option.get_type_name()));
  text += "\n" + roff(option.get_description()) + "\n";
  if (option.get_required()) text += ".br\nRequired.\n";
  return text + man_relation("Not with", option.get_excludes()) +
         man_relation("Only with", option.get_needs());
}

std::string man_entries(const CLI::App& command) {
  std::string text;
  for (const CLI::Option* option : positionals_of(command)) text += man_entry(*option);
  for (const CLI::Option* option : options_of(command)) text += man_entry(*option);
  const std::string footer = command.get_footer();
  if (!footer.empty()) text += ".PP\n.nf\n" + roff(footer) + "\n.fi\n";
  return text;
}

std::string synopsis(const CLI::App& command) {
  std::string text = fmt::format("\\fBensonify {}\\fR [\\fIOPTIONS\\fR]", command.get_name());
  for (const CLI::Option* option : positionals_of(command)) {
    const std::string name = fmt::format("\\fI{}\\fR", names_of(*option).front());
    text += option->get_required() ? " " + name : " [" + name + "]";
  }
  return text;
}

std::string man_page(const CLI::App& program, const std::string& version) {
  const std::string description = program.get_description();
  const std::size_t colon = description.find(": ");
  const std::string what = colon == std::string::npos ? description : description.substr(colon + 2);
  std::string text = fmt::format(
      ".TH ENSONIFY 1 \"\" \"ensonify {0}\" \"User Commands\"\n.ad l\n.SH NAME\n"
      "ensonify \\- {1}\n.SH SYNOPSIS\n\\fBensonify\\fR [\\fIOPTIONS\\fR] \\fICOMMAND\\fR\n",
      version, roff(what));
  const auto commands = commands_of(program);
  for (const CLI::App* command : commands) text += ".br\n" + synopsis(*command) + "\n";
  text += ".SH OPTIONS\n" + man_entries(program) + ".SH COMMANDS\n";
  for (const CLI::App* command : commands) {
    text +=
        fmt::format(".SS \"{}\"\n{}\n.PP\n{}\n{}", roff("ensonify " + command->get_name()),
                    roff(command->get_description()), synopsis(*command), man_entries(*command));
  }
  return text;
}

Words command_names(const CLI::App& program) {
  Words names;
  for (const CLI::App* command : commands_of(program)) names.push_back(command->get_name());
  return names;
}

// Of the first positional.
Words positional_choices(const CLI::App& command) {
  const auto positionals = positionals_of(command);
  return positionals.empty() ? Words() : choices_of(*positionals.front());
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
  return "'" + CLI::detail::find_and_replace(text, "'", "'\\''") + "'";
}

// Cases of `$command $previous` for options with a value. Without choices bash offers files.
std::string bash_values(const CLI::App& command, const std::string& name) {
  std::string text;
  for (const CLI::Option* option : options_of(command)) {
    if (!has_value(*option)) continue;
    const auto pattern = [&](const std::string& word) {
      return fmt::format("\"{} {}\"", name, word);
    };
    text += fmt::format("    {}) words=\"{}\" ;;\n", join(names_of(*option), pattern, " | "),
                        join(choices_of(*option), " "));
  }
  return text;
}

// Words where no option value is expected: options after a hyphen, otherwise `others`.
std::string bash_words(const CLI::App& command, const std::string& name, const Words& others) {
  const auto names = [](const CLI::Option* option) { return join(names_of(*option), " "); };
  return fmt::format(
      "    \"{0} \"*) if [[ $current == -* ]]; then words=\"{1}\"; else words=\"{2}\"; fi ;;\n",
      name, join(options_of(command), names, " "), join(others, " "));
}

std::string bash_completion(const CLI::App& program) {
  const Words names = command_names(program);
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
      join(names, " | "));
  const auto commands = commands_of(program);
  text += bash_values(program, "");
  for (const CLI::App* command : commands) text += bash_values(*command, command->get_name());
  text += bash_words(program, "", names);
  for (const CLI::App* command : commands) {
    text += bash_words(*command, command->get_name(), positional_choices(*command));
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

std::string zsh_values(const CLI::Option& option) {
  const Words choices = choices_of(option);
  return choices.empty() ? "_files" : fmt::format("({})", join(choices, " "));
}

// One specification of zsh's _arguments: '(-o --output)'{-o,--output=}'[what]:value:_files'. With
// the equals sign a value can follow it or be the next word.
std::string zsh_option(const CLI::Option& option) {
  const std::string action = has_value(option) ? ":value:" + zsh_values(option) : "";
  const Words names = names_of(option);
  const auto taking = [&](const std::string& name) {
    return name.starts_with("--") && has_value(option) ? name + '=' : name;
  };
  const std::string what =
      quoted(fmt::format("[{}]{}", escaped(option.get_description(), "[]:\\"), action));
  if (names.size() == 1) {
    return (option.get_items_expected_max() > 1 ? "\\*" : "") + taking(names.front()) + what;
  }
  return fmt::format("'({})'{{{}}}{}", join(names, " "), join(names, taking, ","), what);
}

std::string zsh_arguments(const CLI::App& command) {
  std::string text = "_arguments -C";
  for (const CLI::Option* option : options_of(command)) {
    text += " \\\n        " + zsh_option(*option);
  }
  for (const CLI::Option* option : positionals_of(command)) {
    text += " \\\n        " +
            quoted(fmt::format("::{}:{}", names_of(*option).front(), zsh_values(*option)));
  }
  return text;
}

std::string zsh_completion(const CLI::App& program) {
  const auto commands = commands_of(program);
  std::string text =
      "#compdef ensonify\n# Printed by ensonify --help-format zsh.\n_ensonify() {\n  local -a "
      "commands=(\n";
  for (const CLI::App* command : commands) {
    text +=
        fmt::format("    {}\n", quoted(fmt::format("{}:{}", command->get_name(),
                                                   escaped(command->get_description(), ":\\"))));
  }
  text += "  )\n  local context state line\n  typeset -A opt_args\n  " + zsh_arguments(program) +
          " \\\n        '1: :->command' '*:: :->rest'\n"
          "  [[ $state == command ]] && _describe command commands\n"
          "  [[ $state == rest ]] || return\n  case $line[1] in\n";
  for (const CLI::App* command : commands) {
    text +=
        fmt::format("    {})\n      {}\n      ;;\n", command->get_name(), zsh_arguments(*command));
  }
  // If zsh finds the file through fpath, it is the body of the function; otherwise it is sourced.
  return text +
         "  esac\n}\n"
         "if [[ $funcstack[1] == _ensonify ]]; then _ensonify \"$@\"; else compdef _ensonify "
         "ensonify; fi\n";
}

std::string fish_option(const CLI::Option& option, const std::string& condition) {
  std::string text = fmt::format("complete -c ensonify -n {}", quoted(condition));
  for (const std::string& name : names_of(option)) {
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  if (const Words choices = choices_of(option); !choices.empty()) {
    text += fmt::format(" -x -a {}", quoted(join(choices, " ")));
  } else if (has_value(option)) {
    text += " -r";
  }
  return text + fmt::format(" -d {}\n", quoted(option.get_description()));
}

std::string fish_completion(const CLI::App& program) {
  const std::string before =
      fmt::format("not __fish_seen_subcommand_from {}", join(command_names(program), " "));
  std::string text = "# fish completions of ensonify, printed by ensonify --help-format fish.\n";
  for (const CLI::Option* option : options_of(program)) text += fish_option(*option, before);
  const auto commands = commands_of(program);
  for (const CLI::App* command : commands) {
    text += fmt::format("complete -c ensonify -f -n {} -a {} -d {}\n", quoted(before),
                        command->get_name(), quoted(command->get_description()));
  }
  for (const CLI::App* command : commands) {
    const std::string within = "__fish_seen_subcommand_from " + command->get_name();
    for (const CLI::Option* option : options_of(*command)) text += fish_option(*option, within);
    for (const std::string& choice : positional_choices(*command)) {
      text += fmt::format("complete -c ensonify -f -n {} -a {}\n", quoted(within), choice);
    }
  }
  return text;
}

}  // namespace

void add_help_format(CLI::App& app, const std::string& version) {
  const auto print = [&app, version](const std::string& format) {
    std::string text;
    if (format == "man") text = man_page(app, version);
    if (format == "bash") text = bash_completion(app);
    if (format == "zsh") text = zsh_completion(app);
    if (format == "fish") text = fish_completion(app);
    if (format == "schema") text = scenario_schema();
    if (format == "outputs") text = outputs_text();
    if (text.empty()) text = members_text(format);
    text.pop_back();  // the parser's exit adds the last line feed
    throw CLI::CallForVersion(text, 0);
  };
  std::vector<std::string> formats = {"man", "bash", "zsh", "fish", "schema", "outputs"};
  for (const std::string& file : described_files()) formats.push_back(file);
  app.add_option_function<std::string>(
         "--help-format", print,
         "print the help of all commands as a man page or as completions for a shell, or the "
         "JSON Schema of scenarios for editors, or the table of image planes as JSON, or the "
         "schema of what sequence.json, dataset.json, a line of annotations.jsonl or render.json "
         "holds")
      ->check(CLI::IsMember(formats));
}

void offer_choices(CLI::Option& option, const std::vector<std::string>& choices) {
  option.check(CLI::Validator([](std::string&) { return std::string(); },
                              fmt::format("{{{}}}", fmt::join(choices, ",")), "offered"));
}

}  // namespace ensonify
