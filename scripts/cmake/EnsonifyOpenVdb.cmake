# OpenVDB::openvdb. Debian 12's own find module asks for development files of Boost that its package
# does not depend on and nothing here needs.

find_path(OPENVDB_INCLUDE openvdb/openvdb.h REQUIRED)
find_library(OPENVDB_LIBRARY openvdb REQUIRED)
mark_as_advanced(OPENVDB_INCLUDE OPENVDB_LIBRARY)
# Its headers start TBB, whatever the threads of this program are.
find_package(TBB CONFIG REQUIRED)

add_library(OpenVDB::openvdb UNKNOWN IMPORTED)
set_target_properties(OpenVDB::openvdb PROPERTIES
  IMPORTED_LOCATION ${OPENVDB_LIBRARY}
  INTERFACE_INCLUDE_DIRECTORIES ${OPENVDB_INCLUDE}
  INTERFACE_LINK_LIBRARIES "Imath::Imath;TBB::tbb;Threads::Threads")
if(ENSONIFY_SANITIZE MATCHES "undefined" AND CMAKE_CXX_COMPILER_ID STREQUAL Clang)
  set_property(TARGET OpenVDB::openvdb PROPERTY
    INTERFACE_COMPILE_OPTIONS -fsanitize-ignorelist=${CMAKE_SOURCE_DIR}/tests/foreign_headers.txt)
endif()
