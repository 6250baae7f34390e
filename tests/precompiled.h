// What nearly every test reads.
#pragma once

#include "catch.h"
#include "precompiled/std.h"
