// Errors of the command line, with the command, option or choice that was probably meant.
#pragma once

#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace ensonify {

// What is wrong with a command line that the parser refused, without a line end.
std::string usage_error_text(const CLI::App& program, const CLI::ParseError& error);

}  // namespace ensonify
