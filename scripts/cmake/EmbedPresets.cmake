# Writes a C++ source with the text of every preset, so that the program needs no data files.
#   cmake -DOUTPUT=preset_files.cpp "-DFILES=a.yaml;b.yaml" -P EmbedPresets.cmake

set(table "")
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME_WLE)
  file(READ "${file}" text)
  string(FIND "${text}" ")ensonify\"" end_of_literal)
  if(NOT end_of_literal EQUAL -1)
    message(FATAL_ERROR "${file} holds the characters that end a raw string literal")
  endif()
  string(APPEND table "    {\"${name}\", R\"ensonify(${text})ensonify\"},\n")
endforeach()

file(WRITE "${OUTPUT}" "// Written by scripts/cmake/EmbedPresets.cmake from configs/sonars.
#include \"scenario/preset_files.h\"

namespace ensonify {
namespace {

constexpr PresetFile kPresetFiles[] = {
${table}};

}  // namespace

std::span<const PresetFile> preset_files() { return kPresetFiles; }

}  // namespace ensonify
")
