# What the preset acoustics-only promises, without compiling it: the lower folders need FFTW and nothing else. Their
# tests are linked with these folders and FFTW alone, over the threads of the standard library.
if(ENSONIFY_ACOUSTICS_ONLY OR ENSONIFY_SANITIZE)
  return()
endif()
set(lower core acoustics synthesis labels)
list(TRANSFORM lower PREPEND ensonify_ OUTPUT_VARIABLE libraries)
list(REVERSE libraries)
set(archives ensonify_host_queue ${libraries})
list(TRANSFORM archives REPLACE "(.+)" "$<TARGET_FILE:\\1>")

add_executable(test_lower_folders ${CMAKE_SOURCE_DIR}/generator/core/parallel.cpp)
foreach(folder IN LISTS lower)
  target_sources(test_lower_folders PRIVATE $<TARGET_OBJECTS:test_${folder}>)
endforeach()
# By file, so that what these targets ask for themselves, TBB above all, does not come along.
target_link_libraries(test_lower_folders PRIVATE ensonify_catch ${archives} PkgConfig::FFTW Threads::Threads
                      ${CMAKE_DL_LIBS})
add_dependencies(test_lower_folders ensonify_host_queue ${libraries})
add_test(NAME "lower folders: FFTW is all they need" COMMAND test_lower_folders -w NoTests "for_each*")
set_tests_properties("lower folders: FFTW is all they need" PROPERTIES LABELS fast)

# Libraries that are headers alone do not show when linking.
list(TRANSFORM lower PREPEND ${CMAKE_SOURCE_DIR}/generator/ OUTPUT_VARIABLE folders)
add_test(NAME "lower folders: no header of other packages"
  COMMAND grep -rnE "#include <(embree|openvdb|nanovdb|fmt|nlohmann|valijson|yaml-cpp|assimp|Imf|Imath|png|hdf5|CLI|openssl|libdeflate|zlib|archive|webp|cairo)" ${folders})
set_tests_properties("lower folders: no header of other packages" PROPERTIES LABELS fast WILL_FAIL ON)
