# The pages that scripts/make_reference.py makes are those of the schemas, and say what the program does.
add_test(NAME "docs: scenario keys" COMMAND /usr/bin/python3 -m unittest -v reference_test
  WORKING_DIRECTORY ${CMAKE_CURRENT_LIST_DIR})
set_tests_properties("docs: scenario keys" PROPERTIES LABELS program TIMEOUT 300
  ENVIRONMENT "ENSONIFY=$<TARGET_FILE:ensonify>")
