// Catch2 of either generation: 2.13 has one header, 3.x has many.
#pragma once

// An exception within an assertion ends its case, whose report then names the assertion before: to
// catch it at each assertion costs the compiler a tenth of its time.
#define CATCH_CONFIG_FAST_COMPILE

#if __has_include(<catch2/catch_test_macros.hpp>)
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
// Catch::Approx also names a matcher there.
using Catch::Detail::Approx;
#endif
