// The parts of HDF5 that the format hdf5 needs, through its C API. Private to export/; implemented
// in the module of file_module.h.
//
//   Hdf5File          groups, attributes and small arrays at once
//   Hdf5Array         a stacked array that grows by rows: one chunk per row, one row per ping
//
// Writes no time stamps. After a failure nothing more is written, and status() returns the error.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"

namespace ensonify {

enum class Hdf5Type { u8, u16, u32, u64, f16, f32, f64, complex64 };

// Fill value for rows smaller than the array and for unwritten cells.
enum class Hdf5Fill { zero, no_energy, nan };

struct Hdf5Text {
  std::string key, value;
};

struct Hdf5ArraySpec {
  std::string path;  // /group/name; groups are made
  Hdf5Type type = Hdf5Type::f32;
  std::vector<std::uint64_t> shape;  // rows first
  bool deflate = false;
  Hdf5Fill fill = Hdf5Fill::zero;
  std::vector<Hdf5Text> attributes;
  std::vector<std::string> axes;  // paths of 1-d arrays for each dimension; "" for none
};

class Hdf5File {
 public:
  Hdf5File() = default;
  virtual ~Hdf5File() = default;
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  virtual void make_array(const Hdf5ArraySpec& spec) = 0;
  // Writes row `row` of an array. Its extents are `shape`, which has one dimension less than the
  // array and no larger extent. `data` points to its values in C order.
  virtual void write_row(const std::string& path, std::uint64_t row, const void* data,
                         const std::vector<std::uint64_t>& shape) = 0;
  // The whole of an array.
  virtual void write_all(const std::string& path, const void* data) = 0;
  // Closes the existing arrays: no more rows can be written to them.
  virtual void release_arrays() = 0;
  // One-dimensional texts of fixed length, padded with zeros.
  virtual void write_texts(const std::string& path, const std::vector<std::string>& texts) = 0;
  // Sets an attribute of the root ("/") or of a group, which is made.
  virtual void set_text(const std::string& group, const std::string& key,
                        const std::string& value) = 0;
  virtual void set_number(const std::string& group, const std::string& key,
                          std::uint64_t value) = 0;
  virtual void set_number(const std::string& group, const std::string& key, double value) = 0;

  // Closes the file. Error (io): the first failure.
  virtual Status close() = 0;
};

}  // namespace ensonify
