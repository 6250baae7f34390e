#include "figure/animation.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "formats/output_place.h"
#include "formats/webp.h"

extern char** environ;

namespace ensonify {
namespace fs = std::filesystem;
namespace {

class WebpSink : public AnimationSink {
 public:
  WebpSink(std::filesystem::path path, const AnimationFormat& format)
      : path_(std::move(path)), animation_(format.width, format.height, format.fps) {}

  Status add(const RgbImage& frame) override { return animation_.add(frame.rgb); }

  Status finish() override {
    const auto bytes = animation_.finish();
    return bytes ? write_whole(path_, *bytes) : Status(bytes.error());
  }

 private:
  std::filesystem::path path_;
  WebpAnimation animation_;
};

}  // namespace

Result<std::unique_ptr<AnimationSink>> open_webp(const std::filesystem::path& path,
                                                 const AnimationFormat& format) {
  return std::unique_ptr<AnimationSink>(std::make_unique<WebpSink>(path, format));
}

namespace {

std::string system_reason(int number) { return std::generic_category().message(number); }

// The first executable on PATH; empty if there is none.
std::string find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::string folders = path != nullptr ? path : "/usr/bin:/bin";
  for (std::size_t at = 0; at <= folders.size();) {
    const std::size_t end = std::min(folders.find(':', at), folders.size());
    const fs::path program = fs::path(folders.substr(at, end - at)) / name;
    std::error_code error;
    if (program.is_absolute() && fs::is_regular_file(program, error) &&
        ::access(program.c_str(), X_OK) == 0) {
      return program.string();
    }
    at = end + 1;
  }
  return "";
}

std::vector<std::string> arguments_of(const std::string& program, const fs::path& path,
                                      const AnimationFormat& format) {
  return {program, "-hide_banner", "-loglevel", "error", "-nostdin", "-y",
          // the input
          "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
          fmt::format("{}x{}", format.width, format.height), "-r", fmt::format("{}", format.fps),
          "-i", "pipe:0",
          // the output: without date and version, in a widely supported format
          "-an", "-pix_fmt", "yuv420p", "-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v",
          "+bitexact", "-movflags", "+faststart", "-f", "mp4",
          "file:" + fs::absolute(path).string()};
}

struct ClosedFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// The frames go to the standard input of ffmpeg, which is started without a shell. File names never
// appear where it expects options or protocols.
class Mp4Sink : public AnimationSink {
 public:
  ~Mp4Sink() override { stop(); }

  Status start(const std::string& program, const fs::path& path, const AnimationFormat& format) {
    messages_.reset(std::tmpfile());
    // A socket, because writing to one without a reader can return an error instead of raising a
    // signal.
    std::array<int, 2> ends{};
    if (!messages_ || ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
      return Error{ErrorKind::io, "starting ffmpeg: " + system_reason(errno)};
    }
    to_child_ = ends[0];
    std::vector<std::string> words = arguments_of(program, path, format);
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ::fileno(messages_.get()), STDERR_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    // In its own process group Ctrl-C of a terminal does not reach it.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    const int failure =
        ::posix_spawn(&child_, program.c_str(), &actions, &attributes, argv.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (failure != 0) {
      child_ = -1;
      return Error{ErrorKind::io, fmt::format("starting {}: {}", program, system_reason(failure))};
    }
    return {};
  }

  Status add(const RgbImage& frame) override {
    std::size_t sent = 0;
    while (sent < frame.rgb.size()) {
      const auto count =
          ::send(to_child_, frame.rgb.data() + sent, frame.rgb.size() - sent, MSG_NOSIGNAL);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) {
        const Status ended = finish();
        return ended ? Status(Error{ErrorKind::io, "ffmpeg stopped reading frames"}) : ended;
      }
      sent += static_cast<std::size_t>(count);
    }
    return {};
  }

  Status finish() override {
    if (to_child_ >= 0) ::close(std::exchange(to_child_, -1));
    int status = 0;
    const pid_t child = std::exchange(child_, -1);
    if (child < 0) return Error{ErrorKind::io, "ffmpeg has exited"};
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
    const std::string how = WIFEXITED(status)
                                ? fmt::format("exited with status {}", WEXITSTATUS(status))
                                : fmt::format("was ended by signal {}", WTERMSIG(status));
    return Error{ErrorKind::io, fmt::format("ffmpeg {}{}", how, said())};
  }

 private:
  // The start of the child's output, which names the cause, on one line.
  std::string said() {
    std::array<char, 600> bytes{};
    std::rewind(messages_.get());
    const std::size_t count = std::fread(bytes.data(), 1, bytes.size(), messages_.get());
    std::string text = ": ";
    for (const char c : std::string_view(bytes.data(), count)) {
      text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
    return count > 0 ? text : "";
  }

  void stop() {
    if (to_child_ >= 0) ::close(to_child_);
    if (child_ < 0) return;
    ::kill(child_, SIGTERM);
    while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }

  std::unique_ptr<std::FILE, ClosedFile> messages_;
  int to_child_ = -1;
  pid_t child_ = -1;
};

}  // namespace

Result<std::unique_ptr<AnimationSink>> open_mp4(const fs::path& path,
                                                const AnimationFormat& format) {
  const std::string program = find_program("ffmpeg");
  if (program.empty()) {
    return Error{ErrorKind::usage,
                 "MP4 needs the program ffmpeg, which is not on PATH; install it (Debian: apt "
                 "install ffmpeg), or name an output that ends in .webp"};
  }
  auto sink = std::make_unique<Mp4Sink>();
  if (const Status started = sink->start(program, path, format); !started) return started.error();
  return std::unique_ptr<AnimationSink>(std::move(sink));
}

}  // namespace ensonify
