// ensonify_import: reads one untrusted file and writes it to standard output in the format of
// import/wire.h. The program starts it (foreign_file.cpp) and survives its crashes.
#include <sys/prctl.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "world/import/import.h"
#include "world/import/wire.h"

namespace ensonify {
namespace {

void limit(int what, unsigned long long most, unsigned long long hard_margin = 0) {
  const rlimit both{static_cast<rlim_t>(most), static_cast<rlim_t>(most + hard_margin)};
  setrlimit(static_cast<__rlimit_resource>(what), &both);
}

void set_limits([[maybe_unused]] unsigned long long memory_bytes, unsigned long long seconds) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, 0);
  limit(RLIMIT_CPU, seconds, 5);  // SIGXCPU comes at the soft limit, SIGKILL at the hard one
#if !defined(ENSONIFY_SANITIZED)
  limit(RLIMIT_AS, memory_bytes);  // a sanitizer maps more than any limit
#endif
}

Normals normals_of(const std::string& word) {
  return word == "smooth" ? Normals::smooth : Normals::face;
}

MeshReflectivity wanted_reflectivity(const std::string& word) {
  if (word == "texture") return MeshReflectivity::texture;
  return word == "vertex_color" ? MeshReflectivity::vertex_color : MeshReflectivity::material;
}

// Three numbers.
Vec3 scale_of(const std::string& words) {
  char* rest = nullptr;
  const double x = std::strtod(words.c_str(), &rest);
  const double y = std::strtod(rest, &rest);
  return {x, y, std::strtod(rest, nullptr)};
}

bool run(const std::vector<std::string>& words) {
  const std::string& kind = words[2];
  const std::string& file = words[3];
  const auto answer = [](const auto& result, auto write) {
    return result ? write(stdout, *result) : write_error(stdout, result.error());
  };
  if (kind == "mesh") {
    return answer(import_mesh(file, scale_of(words[4]), normals_of(words[5]),
                              wanted_reflectivity(words[6]), words[7] == "colors"),
                  write_mesh);
  }
  if (kind == "density") return answer(import_density(file, words[4]), write_density);
  return answer(import_level_set(file, words[4], normals_of(words[5])), write_mesh);
}

}  // namespace
}  // namespace ensonify

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() != 8) {
    std::fputs("ensonify_import: ensonify starts this program to read one file at a time\n",
               stderr);
    return 2;
  }
  ensonify::set_limits(std::strtoull(words[0].c_str(), nullptr, 10),
                       std::strtoull(words[1].c_str(), nullptr, 10));
  bool told = false;
  try {
    told = ensonify::run(words);
  } catch (const std::bad_alloc&) {
    return 3;  // foreign_file.cpp says what that means
  }
  return told && std::fflush(stdout) == 0 ? 0 : 1;
}
