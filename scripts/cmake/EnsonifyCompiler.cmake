# Language level, warnings, sanitizers and the way a folder of generator/ becomes a target.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
# One set of flags for all, so that all share precompiled headers and any folder can go into a module.
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_program(ENSONIFY_CCACHE ccache)
if(ENSONIFY_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_SOURCE_DIR}/scripts/cmake/cached.sh)
endif()
if(ENSONIFY_CCACHE AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  string(APPEND CMAKE_CXX_FLAGS " -fpch-preprocess")  # without it ccache passes over precompiled headers
elseif(ENSONIFY_CCACHE AND CMAKE_CXX_COMPILER_ID STREQUAL Clang)
  string(APPEND CMAKE_CXX_FLAGS " -Xclang -fno-pch-timestamp")  # its time would make each precompiled header new
endif()

add_library(ensonify_flags INTERFACE)
target_include_directories(ensonify_flags INTERFACE ${CMAKE_SOURCE_DIR}/generator)
# Contracted multiply-adds would give other bytes on other compilers for the same source.
target_compile_options(ensonify_flags INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;-Wshadow;-Wnon-virtual-dtor;-Wold-style-cast;-ffp-contract=off;-fno-semantic-interposition>)
if(ENSONIFY_SANITIZE)
  target_compile_options(ensonify_flags INTERFACE
    -fsanitize=${ENSONIFY_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer
    # With a sanitizer's instrumentation gcc 12 takes every variant for uninitialized.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(ensonify_flags INTERFACE -fsanitize=${ENSONIFY_SANITIZE})
endif()
# Nearly all instructions of a data set are those of the folders that compute. The others read, write and print: there
# a release build leaves out the loop transformations, the vectorizer and the further inlining, a third of the compiler's
# time. What computes in such a folder is named by COMPUTES. A sanitizer's checks make code large, and clang's optimizer
# takes as long for it as for all else together: under one only the folders that compute are optimized, and beside the
# fuzzers what they and the tests of statistics run often.
set(ENSONIFY_COMPUTING core acoustics synthesis instrument labels world trace camera)
# The folders whose paths the fuzzers look for: the others take a fifth less to compile without counting theirs.
set(ENSONIFY_FUZZED "")
set(ENSONIFY_UNOPTIMIZED "")
set(ENSONIFY_LIGHT "")
if(ENSONIFY_SANITIZE)
  if(ENSONIFY_FUZZ)
    list(APPEND ENSONIFY_COMPUTING scenario_fields compare_computes)
    set(ENSONIFY_FUZZED core formats formats_computes scenario scenario_fields world import dataset recordings sweep)
  endif()
  set(ENSONIFY_UNOPTIMIZED -O0)
  set(ENSONIFY_LIGHT -O0)
else()
  list(APPEND ENSONIFY_COMPUTING figure)
  if(CMAKE_BUILD_TYPE STREQUAL Release)
    set(ENSONIFY_LIGHT -O1)
  endif()
endif()

# Nearly all of what the compiler reads for one of our files is the standard library and a few third parties. A batch
# of files is one unit, which reads them once, and a precompiled header holds what nearly every unit needs. Neither
# is there without ENSONIFY_FAST_BUILD, so that a missing include or a name that two files share shows.
set(ENSONIFY_BATCH 64)
if(ENSONIFY_FAST_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # A unit takes up to 1.9 GB; collecting garbage below one gigabyte would be a tenth of the compiler's time.
  target_compile_options(ensonify_flags INTERFACE $<$<COMPILE_LANGUAGE:CXX>:--param=ggc-min-heapsize=1000000>)
endif()
if(ENSONIFY_FAST_BUILD AND NOT CMAKE_COMPILE_WARNING_AS_ERROR)
  # Where warnings are errors, fmt also checks every format string; who only wants the program need not repeat it.
  target_compile_definitions(ensonify_flags INTERFACE FMT_CONSTEVAL=)
endif()

# ensonify_precompiled(NAME HEADER LIBRARIES...): a header that other targets reuse.
function(ensonify_precompiled name header)
  add_library(${name} OBJECT ${CMAKE_SOURCE_DIR}/generator/precompiled/empty.cpp)
  target_link_libraries(${name} PRIVATE ensonify_flags ${ARGN})
  target_precompile_headers(${name} PRIVATE ${header})
  if("fmt::fmt" IN_LIST ARGN)
    target_compile_options(${name} PRIVATE ${ENSONIFY_UNOPTIMIZED})
  endif()
endfunction()

# What the targets of one folder share.
function(ensonify_compiled_as target name libraries)
  set(precompiled ensonify_precompiled_std)
  # A header precompiled without optimization is of no use to a unit with it.
  if("fmt::fmt" IN_LIST libraries AND NOT (ENSONIFY_SANITIZE AND name IN_LIST ENSONIFY_COMPUTING))
    set(precompiled ensonify_precompiled_fmt)
  endif()
  if(ENSONIFY_FAST_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${ENSONIFY_BATCH})
    target_precompile_headers(${target} REUSE_FROM ${precompiled})
  endif()
  target_link_libraries(${target} PUBLIC ensonify_flags PRIVATE ${libraries})
  if(name IN_LIST ENSONIFY_FUZZED)
    # What -fsanitize=fuzzer-no-link stands for, which would need precompiled headers of its own.
    target_compile_options(${target} PRIVATE
      -fsanitize-coverage=inline-8bit-counters,indirect-calls,trace-cmp,pc-table,stack-depth -fno-builtin-memcmp)
  endif()
endfunction()

# ensonify_library(NAME FOLDERS cpu ... EXCEPT main.cpp ... COMPUTES b.cpp ... ALSO files ... USES other folders ...
#                  PRIVATE third parties ...)
# One library of the files in the current folder and in FOLDERS below it. Those in EXCEPT belong to other targets; ALSO
# names files of elsewhere and generated ones. Third parties are PRIVATE, so that a wrong include does not compile.
function(ensonify_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "FOLDERS;EXCEPT;COMPUTES;ALSO;USES;PRIVATE")
  list(TRANSFORM arg_USES PREPEND ensonify_)
  list(TRANSFORM arg_FOLDERS APPEND /*.cpp)
  file(GLOB sources RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS *.cpp ${arg_FOLDERS})
  list(REMOVE_ITEM sources ${arg_EXCEPT} ${arg_COMPUTES})
  add_library(ensonify_${name} STATIC ${sources} ${arg_ALSO})
  ensonify_compiled_as(ensonify_${name} ${name} "${arg_PRIVATE}")
  target_link_libraries(ensonify_${name} PUBLIC ${arg_USES})
  if(NOT name IN_LIST ENSONIFY_COMPUTING)
    target_compile_options(ensonify_${name} PRIVATE ${ENSONIFY_LIGHT})
  endif()
  if(arg_COMPUTES)
    add_library(ensonify_${name}_computes OBJECT ${arg_COMPUTES})
    ensonify_compiled_as(ensonify_${name}_computes ${name}_computes "${arg_PRIVATE}")
    target_link_libraries(ensonify_${name}_computes PRIVATE ${arg_USES})
    target_sources(ensonify_${name} PRIVATE $<TARGET_OBJECTS:ensonify_${name}_computes>)
    if(NOT "${name}_computes" IN_LIST ENSONIFY_COMPUTING)
      target_compile_options(ensonify_${name}_computes PRIVATE ${ENSONIFY_UNOPTIMIZED})
    endif()
  endif()
endfunction()

# ensonify_module(NAME SOURCES a.cpp ... PRIVATE third parties ...)
# libensonify_NAME.so next to the program, which opens it when it needs it (core/runtime.h): the libraries in PRIVATE
# are then not linked at every start.
function(ensonify_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;PRIVATE")
  add_library(ensonify_${name} MODULE ${arg_SOURCES})
  target_link_libraries(ensonify_${name} PRIVATE ensonify_flags ensonify_core ${arg_PRIVATE})
  target_compile_options(ensonify_${name} PRIVATE ${ENSONIFY_UNOPTIMIZED})
  # Otherwise a symbol of the program's own copy is taken in place of the module's.
  target_link_options(ensonify_${name} PRIVATE -Wl,-Bsymbolic)
  set_target_properties(ensonify_${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
  set_property(GLOBAL APPEND PROPERTY ENSONIFY_MODULES ensonify_${name})
endfunction()
