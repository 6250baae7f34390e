# What `cmake --install` installs, and the Debian packages that CPack makes of it. Three components:
# `program`, `python` where Python's headers are, and `cuda` where the CUDA module is built. The module needs cuFFT, which Debian's main
# section does not have, so it is a package of its own and dpkg-shlibdeps does not see it.
if(NOT TARGET ensonify)
  return()
endif()
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME program)
set(CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS  # whatever the umask is
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(companions lib/ensonify)  # as core/runtime.cpp has it
set(data share/ensonify)

install(TARGETS ensonify RUNTIME DESTINATION bin)
get_property(modules GLOBAL PROPERTY ENSONIFY_MODULES)
install(TARGETS ensonify_importer ${modules} RUNTIME DESTINATION ${companions} LIBRARY DESTINATION ${companions})
if(TARGET ensonify_cuda)
  # The loader does not look into NVIDIA's folders by itself.
  set_target_properties(ensonify_cuda PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)
  install(TARGETS ensonify_cuda LIBRARY DESTINATION ${companions} COMPONENT cuda)
endif()

# Scenes, sweeps, schemas and pages refer to one another by relative paths: they stay as in the repository.
install(DIRECTORY scenes configs output_schema docs DESTINATION ${data})
install(FILES README.md CHANGELOG.md CITATION.cff DESTINATION ${data})
install(PROGRAMS scripts/slurm/submit.sh scripts/slurm/task.sh scripts/slurm/finish.sh
        DESTINATION ${data}/scripts/slurm)
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/help)
file(CREATE_LINK ../../ensonify/docs ${CMAKE_BINARY_DIR}/help/docs SYMBOLIC)
install(FILES ${CMAKE_BINARY_DIR}/help/docs DESTINATION share/doc/ensonify)
install(FILES LICENSE DESTINATION share/doc/ensonify RENAME copyright)

# Debian's python3 looks there below /usr; below another prefix PYTHONPATH has to name the folder.
install(DIRECTORY scripts/ensonify_dataset DESTINATION lib/python3/dist-packages
        FILES_MATCHING PATTERN "*.py" PATTERN "*.json" PATTERN __pycache__ EXCLUDE)
if(TARGET ensonify_python)
  install(TARGETS ensonify_python LIBRARY DESTINATION lib/python3/dist-packages/ensonify COMPONENT python)
  install(DIRECTORY scripts/python/ensonify DESTINATION lib/python3/dist-packages COMPONENT python
          FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN py.typed PATTERN __pycache__ EXCLUDE)
endif()

# generator/cli/CMakeLists.txt makes these with the program.
install(FILES ${CMAKE_BINARY_DIR}/help/ensonify.1.gz DESTINATION share/man/man1)
install(FILES ${CMAKE_BINARY_DIR}/help/ensonify.bash DESTINATION share/bash-completion/completions RENAME ensonify)
install(FILES ${CMAKE_BINARY_DIR}/help/_ensonify DESTINATION share/zsh/vendor-completions)
install(FILES ${CMAKE_BINARY_DIR}/help/ensonify.fish DESTINATION share/fish/vendor_completions.d)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS ${CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS})
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_CONTACT "The ensonify developers <ensonify@localhost>")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "ensonify generates data sets of multibeam (forward-looking) sonars offline from a
scenario file: coherent complex time series, images, and exact labels. The same
scenario and seed give the same bytes.")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_COMPONENTS_ALL program)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME ensonify)
set(CPACK_DEBIAN_PROGRAM_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "ensonify-cuda, ffmpeg")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS python3-numpy)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/scripts/debian/prerm)
if(TARGET ensonify_python)
  math(EXPR next_minor "${Python_VERSION_MINOR} + 1")
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Python package of ensonify: pings as NumPy arrays, streams for training.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-ensonify)
  set(CPACK_DEBIAN_PYTHON_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  # The importer, the reader and the version of Python whose module it is.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "ensonify (= ${PROJECT_VERSION}), python3-numpy, \
python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), python3 (<< ${Python_VERSION_MAJOR}.${next_minor})")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS python3-torch)
endif()
if(TARGET ensonify_cuda)
  list(APPEND CPACK_COMPONENTS_ALL cuda)
  set(CPACK_COMPONENT_CUDA_DESCRIPTION "CUDA backend of ensonify. It needs cuFFT of CUDA 12 or newer, from NVIDIA's packages.")
  set(CPACK_DEBIAN_CUDA_PACKAGE_NAME ensonify-cuda)
  set(CPACK_DEBIAN_CUDA_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_CUDA_PACKAGE_DEPENDS "ensonify (= ${PROJECT_VERSION})")
endif()
include(CPack)
