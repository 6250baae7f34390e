#include "world/foreign_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <thread>

#include "core/runtime.h"
#include "world/density.h"
#include "world/mesh.h"

namespace ensonify {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int kNoMemory = 3;  // the importer's exit status

// The importer process, which ends with this object.
class Child {
 public:
  explicit Child(const ImportRequest& request) {
    int ends[2] = {-1, -1};
    if (pipe2(ends, O_CLOEXEC) != 0) return;
    std::vector<std::string> words = {request.importer.string(),
                                      std::to_string(request.limits.memory_bytes),
                                      std::to_string(request.limits.seconds)};
    words.insert(words.end(), request.words.begin(), request.words.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
#if !defined(ENSONIFY_SANITIZED)
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
#endif
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    // The importer has its own process group, so that signals from the terminal to the program's
    // group do not reach it.
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    if (posix_spawn(&pid_, argv[0], &actions, &attributes, argv.data(), environ) != 0) pid_ = -1;
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    pipe_ = ends[0];
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (pid_ > 0) {
      kill(-pid_, SIGKILL);  // its group, with everything that it has started
      int status = 0;
      while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
      }
    }
    if (pipe_ >= 0) close(pipe_);
  }

  bool started() const { return pid_ > 0; }
  int pipe() const { return pipe_; }

  // Returns its exit status, or none if it is still running at `end`.
  std::optional<int> wait_until(Clock::time_point end) {
    int status = 0;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      if (Clock::now() > end) return {};
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    pid_ = -1;
    return status;
  }

 private:
  pid_t pid_ = -1;
  int pipe_ = -1;
};

enum class PipeEnd { none, closed, late };

// Reads the bytes from the pipe until they are complete, the pipe ends or the time is up.
PipeEnd read_all(int pipe, Clock::time_point end, char* to, std::size_t bytes) {
  while (bytes > 0) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() <= 0) return PipeEnd::late;
    pollfd wanted{pipe, POLLIN, 0};
    const int ready =
        poll(&wanted, 1, static_cast<int>(std::min<std::int64_t>(left.count(), 1 << 20)));
    if (ready <= 0) continue;  // a signal, or the time is up
    const ssize_t got = read(pipe, to, bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return PipeEnd::closed;
    to += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return PipeEnd::none;
}

Error refused(const ImportRequest& request, const std::string& why) {
  return {ErrorKind::usage, fmt::format("{}: {}", request.file.string(), why)};
}

std::string gigabytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} GB", static_cast<double>(bytes) * 1e-9);
}

Error nonsense(const ImportRequest& request) {
  return refused(request,
                 "its reader returned nothing usable; the file is damaged: export it again");
}

Error too_late(const ImportRequest& request) {
  return refused(request, fmt::format("not read within {} s; the file is damaged or too large: "
                                      "export it again, in smaller parts",
                                      request.limits.seconds));
}

// Such signals come from a person, or from the system when memory runs out. The file is not at
// fault, and a later try may succeed.
bool is_from_outside(int signal) {
  return signal == SIGKILL || signal == SIGTERM || signal == SIGINT || signal == SIGHUP ||
         signal == SIGQUIT;
}

// The reason why an importer ended without a usable result.
Error told_by(int status, const ImportRequest& request) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) return too_late(request);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNoMemory) {
    return refused(request, fmt::format("needs more memory than {}; the file is damaged or too "
                                        "large: export it again, in smaller parts",
                                        gigabytes(request.limits.memory_bytes)));
  }
  if (WIFSIGNALED(status) && is_from_outside(WTERMSIG(status))) {
    return Error{ErrorKind::io,
                 fmt::format("{}: its reader was ended from outside ({}); repeat the "
                             "command",
                             request.file.string(), strsignal(WTERMSIG(status)))};
  }
  if (WIFSIGNALED(status)) {
    return refused(request,
                   fmt::format("crashes its reader ({}); the file is damaged: export it again",
                               strsignal(WTERMSIG(status))));
  }
  return nonsense(request);
}

}  // namespace

ImportLimits import_limits(std::uint64_t file_bytes) {
  return {(std::uint64_t{2} << 30) + 64 * file_bytes, 60 + file_bytes / 1'000'000};
}

std::filesystem::path importer_path() { return companion_path("ensonify_import"); }

Status run_import(const ImportRequest& request,
                  const std::function<Status(const WireInput&)>& read) {
  Child child(request);
  if (!child.started()) {
    return Error{
        ErrorKind::io,
        fmt::format("{} cannot be started; ensonify needs it next to itself to read meshes "
                    "and OpenVDB files: build it again",
                    request.importer.string())};
  }
  const auto end = Clock::now() + std::chrono::seconds(4 * request.limits.seconds);
  PipeEnd ended = PipeEnd::none;
  WireInput in;
  in.most_bytes = request.limits.memory_bytes;
  in.read = [&](void* to, std::size_t bytes) {
    ended = read_all(child.pipe(), end, static_cast<char*>(to), bytes);
    return ended == PipeEnd::none;
  };
  Status got = read(in);
  if (got || got.error().kind != ErrorKind::bug) return got;
  if (ended == PipeEnd::late) return too_late(request);
  // Kills an importer that might keep writing nonsense forever.
  if (ended == PipeEnd::none) return nonsense(request);
  const std::optional<int> status = child.wait_until(end);
  return status ? told_by(*status, request) : too_late(request);
}

namespace {

template <class T>
Result<T> load(const std::filesystem::path& file, std::vector<std::string> words,
               Result<T> (*read)(const WireInput&)) {
  std::error_code none;
  const std::uint64_t bytes = std::filesystem::file_size(file, none);
  ImportRequest request{importer_path(), file, std::move(words), import_limits(none ? 0 : bytes)};
  std::optional<T> loaded;
  const Status done = run_import(request, [&](const WireInput& in) -> Status {
    Result<T> result = read(in);
    if (!result) return result.error();
    loaded = std::move(*result);
    return {};
  });
  if (!done) return done.error();
  return std::move(*loaded);
}

const char* word_of(Normals normals) { return normals == Normals::smooth ? "smooth" : "face"; }

const char* word_of(MeshReflectivity reflectivity) {
  constexpr const char* kWords[] = {"material", "vertex_color", "texture"};
  return kWords[static_cast<int>(reflectivity)];
}

}  // namespace

Result<Mesh> load_mesh(const std::filesystem::path& file, Vec3 scale, Normals normals,
                       MeshReflectivity reflectivity, bool colors) {
  return load<Mesh>(
      file,
      {"mesh", file.string(), fmt::format("{:a} {:a} {:a}", scale.x, scale.y, scale.z),
       word_of(normals), word_of(reflectivity), colors ? "colors" : ""},
      read_mesh);
}

Result<DensityGrid> load_density_vdb(const std::filesystem::path& file, const std::string& grid) {
  return load<DensityGrid>(file, {"density", file.string(), grid, "", "", ""}, read_density);
}

Result<Mesh> load_level_set_vdb(const std::filesystem::path& file, const std::string& grid,
                                Normals normals) {
  return load<Mesh>(file, {"level_set", file.string(), grid, word_of(normals), "", ""}, read_mesh);
}

}  // namespace ensonify
