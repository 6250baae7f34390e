// What the machine can do at best, to put the stages' speeds into proportion.
#pragma once

#include <filesystem>
#include <string>

#include "bench/bench.h"
#include "bench/kernels.h"

namespace ensonify {

double fma_gflops(const KernelTable& kernels, double seconds);
double copy_gb_s(std::size_t bytes, double seconds);

// Fills the disk's part. Error (io): the folder cannot be written.
Status measure_disk(const std::filesystem::path& folder, std::size_t bytes, MachineReport& machine);

// Writes a new file past the page cache where the file system allows that, and waits until the disk
// has it. The bytes must begin on a 4096-byte boundary and have room up to a multiple of 4096.
// `direct` says whether the page cache was passed. Error (io).
Status write_to_disk(const std::filesystem::path& file, const char* bytes, std::size_t count,
                     bool& direct);

// Memory as write_to_disk wants it.
class PageBuffer {
 public:
  explicit PageBuffer(std::size_t bytes);  // zero at first; throws std::bad_alloc
  ~PageBuffer();
  PageBuffer(const PageBuffer&) = delete;
  PageBuffer& operator=(const PageBuffer&) = delete;
  char* data() const { return data_; }

 private:
  char* data_;
};

// A new folder in `parent`, gone with all that is in it when this is.
class ScratchFolder {
 public:
  static Result<ScratchFolder> make(const std::filesystem::path& parent);
  ~ScratchFolder();
  ScratchFolder(ScratchFolder&& other) noexcept;
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

}  // namespace ensonify
