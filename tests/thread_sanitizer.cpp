// What the thread sanitizer leaves out, in every test program of its preset.

// Embree guards a list of its threads' allocators, which all its devices share, by a lock that the
// sanitizer cannot see. What Embree itself calls is left out; whatever code of ours calls is not.
extern "C" const char* __tsan_default_suppressions() { return "called_from_lib:libembree3.so\n"; }
