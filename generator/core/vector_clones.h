// ENSONIFY_VECTOR_CLONES: a function compiled once for each width of vectors, chosen when the
// program starts. Operations are not fused (-ffp-contract=off), so that all clones give the same
// bits. Sanitized programs, built by clang, have only the plain function.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ENSONIFY_VECTOR_CLONES \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define ENSONIFY_VECTOR_CLONES
#endif
