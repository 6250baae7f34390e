# The page in Debian's Chromium, driven by playwright-core. Pages and screenshots stay in report_pages/.
set(pages ${CMAKE_CURRENT_BINARY_DIR}/report_pages)
add_test(NAME "report: pages for the browser"
  COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/browser/make_pages.py $<TARGET_FILE:ensonify> ${pages})
set_tests_properties("report: pages for the browser" PROPERTIES LABELS "program;heavy"
  FIXTURES_SETUP report_pages TIMEOUT 300)
# Debian's own node before another one: scripts/test.sh installs no other.
find_program(ENSONIFY_NODE node PATHS /usr/bin NO_DEFAULT_PATH)
find_program(ENSONIFY_NODE node)
if(ENSONIFY_NODE)
  add_test(NAME "report: page in a browser" COMMAND ${ENSONIFY_NODE} ${CMAKE_CURRENT_SOURCE_DIR}/browser/run.mjs)
else()
  add_test(NAME "report: page in a browser" COMMAND sh -c "echo 'skipped: node is missing'; exit 77")
endif()
set_tests_properties("report: page in a browser" PROPERTIES LABELS "program;heavy" TIMEOUT 300
  FIXTURES_REQUIRED report_pages SKIP_RETURN_CODE 77 ENVIRONMENT "REPORT_PAGES=${pages}")
