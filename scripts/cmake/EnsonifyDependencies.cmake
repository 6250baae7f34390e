# Third parties, all from the distribution. Order matters on Debian 12: TBB by its own config
# file first, so that no find module shipped beside another library shadows it.

find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(FFTW REQUIRED IMPORTED_TARGET fftw3)

if(ENSONIFY_USE_TBB AND NOT ENSONIFY_ACOUSTICS_ONLY)
  find_package(TBB CONFIG REQUIRED)
endif()

if(NOT ENSONIFY_ACOUSTICS_ONLY)
  find_package(embree 4 CONFIG QUIET)
  if(NOT embree_FOUND)
    find_package(embree 3 CONFIG REQUIRED)
  endif()
  find_package(OpenEXR CONFIG REQUIRED)
  find_package(yaml-cpp REQUIRED)
  find_package(assimp REQUIRED)
  include(EnsonifyOpenVdb)  # after OpenEXR, which brings Imath
  find_package(CLI11 REQUIRED)
  find_package(fmt REQUIRED)
  find_package(nlohmann_json REQUIRED)
  find_package(valijson REQUIRED)  # newer releases call the target ValiJSON::valijson
  if(NOT TARGET ValiJSON::valijson)
    add_library(ValiJSON::valijson INTERFACE IMPORTED)
    target_link_libraries(ValiJSON::valijson INTERFACE valijson)
  endif()
  find_package(OpenSSL REQUIRED COMPONENTS Crypto)
  find_package(ZLIB REQUIRED)
  find_package(PNG REQUIRED)
  find_package(LibArchive REQUIRED)
  find_package(muparser CONFIG REQUIRED)
  pkg_check_modules(DEFLATE REQUIRED IMPORTED_TARGET libdeflate)
endif()

if(ENSONIFY_TESTS)
  find_package(Catch2 REQUIRED)
endif()
