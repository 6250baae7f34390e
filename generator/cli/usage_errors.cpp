#include "cli/usage_errors.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "scenario/text.h"

namespace ensonify {
namespace {

using Names = std::vector<std::string>;

std::string with_hint(const std::string& word, const Names& names) {
  return shown(word) + hint(word, {names.begin(), names.end()});
}

bool is_option(const std::string& word) { return word.size() > 1 && word[0] == '-'; }

std::string help_of(const CLI::App& command) {
  const std::string of = command.get_parent() != nullptr ? " " + command.get_name() : "";
  return fmt::format("; `ensonify{} --help` prints what is expected", of);
}

std::string unknown_option(const CLI::App& command, const std::string& word) {
  Names names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return "unknown option " + with_hint(word.substr(0, word.find('=')), names) + help_of(command);
}

std::string unknown_command(const CLI::App& program, const std::string& word) {
  Names names;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  const std::string what =
      word.empty() ? "no command" : "unknown command " + with_hint(word, names);
  return fmt::format("{}; expected one of {}, which `ensonify --help` describes", what,
                     fmt::join(names, ", "));
}

// The error of CLI::IsMember, "--simd: avx not in {auto,sse4,avx2,avx512}", in the words of keys.
std::optional<std::string> unknown_choice(const std::string& text) {
  constexpr std::string_view kBeforeChoices = " not in {";
  const std::size_t name = text.find(": "), choices = text.rfind(kBeforeChoices);
  if (name == std::string::npos || choices == std::string::npos || name > choices) {
    return std::nullopt;
  }
  const std::string word = text.substr(name + 2, choices - name - 2);
  const std::size_t first = choices + kBeforeChoices.size();
  const Names known = CLI::detail::split(text.substr(first, text.rfind('}') - first), ',');
  return fmt::format("{}: {} is not known{}; expected one of {}", text.substr(0, name), shown(word),
                     hint(word, {known.begin(), known.end()}), fmt::join(known, ", "));
}

}  // namespace

std::string usage_error_text(const CLI::App& program, const CLI::ParseError& error) {
  const auto given = program.get_subcommands();
  const CLI::App& command = given.empty() ? program : *given.front();
  // An option that is not known may be the reason why a required one seems to be missing.
  const Names unknown = command.remaining();
  const std::string first = unknown.empty() ? "" : unknown.front();
  const bool lacks_command = given.empty() && error.get_name() == "RequiredError";
  if (lacks_command && !is_option(first)) return unknown_command(program, first);
  for (const std::string& word : unknown) {
    if (is_option(word)) return unknown_option(command, word);
  }
  if (!unknown.empty()) return "unexpected argument " + shown(first) + help_of(command);
  return unknown_choice(error.what()).value_or(error.what() + help_of(command));
}

}  // namespace ensonify
