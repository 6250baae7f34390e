// The one slow file of Catch2 2.13: its main and all of its machinery. 3.x brings its own main.
#if __has_include(<catch2/catch_test_macros.hpp>)
#else
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#endif
