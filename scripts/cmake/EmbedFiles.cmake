# Texts travel inside the program, so that it runs from anywhere.
#   embed_files(OUTPUT HEADER TYPE FUNCTION FILES)   files -> a C++ source, made anew when one changes
#
# As a script it writes that source: HEADER declares `struct TYPE {name, text}` and
# `std::span<const TYPE> FUNCTION()` in namespace ensonify.

if(CMAKE_SCRIPT_MODE_FILE)
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

  file(WRITE "${OUTPUT}" "// Written by scripts/cmake/EmbedFiles.cmake.
#include \"${HEADER}\"

namespace ensonify {

std::span<const ${TYPE}> ${FUNCTION}() {
  static constexpr ${TYPE} kFiles[] = {
${table}};
  return kFiles;
}

}  // namespace ensonify
")
  return()
endif()

set(ENSONIFY_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

function(embed_files output header type function files)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DHEADER=${header} -DTYPE=${type}
            -DFUNCTION=${function} "-DFILES=${files}" -P ${ENSONIFY_EMBED_SCRIPT}
    DEPENDS ${files} ${ENSONIFY_EMBED_SCRIPT}
    VERBATIM)
endfunction()
