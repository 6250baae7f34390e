# Writes OUTPUT with the version and the commit of the checkout SOURCE, touching it only when they
# changed. "+" and 8 digits after a commit: the working tree held changes of tracked files, and this
# is their hash, so that two such builds do not take each other's data for their own.
find_package(Git QUIET)
set(commit "unknown")
if(Git_FOUND AND EXISTS ${SOURCE}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${SOURCE} rev-parse --short=12 HEAD
    OUTPUT_VARIABLE head OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed)
    set(commit ${head})
    execute_process(COMMAND ${GIT_EXECUTABLE} -C ${SOURCE} diff HEAD
      OUTPUT_VARIABLE changes ERROR_QUIET)
    if(NOT changes STREQUAL "")
      string(SHA256 changes "${changes}")
      string(SUBSTRING ${changes} 0 8 changes)
      string(APPEND commit "+${changes}")
    endif()
  endif()
endif()
# Without git, or where git distrusts the folder's owner, the commit still stands in plain files.
if(commit STREQUAL "unknown" AND EXISTS ${SOURCE}/.git/HEAD)
  file(STRINGS ${SOURCE}/.git/HEAD head LIMIT_COUNT 1)
  if(head MATCHES "^ref: (.*)$")
    set(branch ${CMAKE_MATCH_1})
    set(head "")
    if(EXISTS ${SOURCE}/.git/${branch})
      file(STRINGS ${SOURCE}/.git/${branch} head LIMIT_COUNT 1)
    elseif(EXISTS ${SOURCE}/.git/packed-refs)
      file(STRINGS ${SOURCE}/.git/packed-refs head REGEX " ${branch}$" LIMIT_COUNT 1)
    endif()
  endif()
  if(head MATCHES "^[0-9a-f]+")
    string(SUBSTRING "${head}" 0 12 commit)
  endif()
endif()
set(text "#include \"run/program.h\"\n
namespace ensonify {
const char* program_version() { return \"${VERSION}\"; }
const char* program_commit() { return \"${commit}\"; }
}  // namespace ensonify\n")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT old STREQUAL text)
  file(WRITE ${OUTPUT} "${text}")
endif()
