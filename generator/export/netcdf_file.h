// A netCDF-4 file, which is an HDF5 file with conventions of its own: dimensions are dimension
// scales, and types that variables share are named. Private to export/.
//
//   NetcdfType  NetcdfAttribute  NetcdfAttributes  described  NetcdfVariable
//   NetcdfFile   group  attribute  dimension  enumeration  ragged_type  variable, and writing
//
// All names are paths from the root. Writes no time stamps. After a failure nothing more is
// written, and close() returns the error.
//
// Source: "NetCDF-4 File Format",
// https://docs.unidata.ucar.edu/netcdf-c/current/file_format_specifications.html
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/error.h"

namespace ensonify {

// `named`: the type of NetcdfVariable::named_type.
enum class NetcdfType { i8, i16, i32, u64, f32, f64, text, named };

struct NetcdfAttribute {
  std::string key;
  std::variant<std::string, int, short, float, double, std::vector<short>> value;
};
using NetcdfAttributes = std::vector<NetcdfAttribute>;

// With the attributes that nearly all variables have.
NetcdfAttributes described(const char* long_name, const char* units, NetcdfAttributes more = {});

struct NetcdfVariable {
  std::string path;
  NetcdfType type = NetcdfType::f32;
  std::vector<std::string> dimensions;  // paths; none: a scalar
  NetcdfAttributes attributes;
  std::string named_type = {};  // path of an enumeration, or of a ragged type
};

class NetcdfFile {
 public:
  // `path` must not exist.
  explicit NetcdfFile(std::filesystem::path path);
  ~NetcdfFile();
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  // Each needs its parent.
  void group(const std::string& path, const NetcdfAttributes& attributes);
  // Of "/" or a group.
  void attribute(const std::string& group, const NetcdfAttribute& attribute);
  // ... whose type is an enumeration.
  void enumerated(const std::string& group, const std::string& key, const std::string& type,
                  std::int8_t value);
  // A dimension without a variable.
  void dimension(const std::string& path, std::uint64_t length);
  // A dimension, and the variable with its coordinates. `variable.dimensions` is ignored.
  void coordinate(const NetcdfVariable& variable, std::uint64_t length);
  void enumeration(const std::string& path,
                   const std::vector<std::pair<const char*, std::int8_t>>& members);
  // Rows of floats of any length.
  void ragged_type(const std::string& path);
  // Variables with two dimensions or more have a compressed chunk for each index of the first one,
  // but for ragged ones.
  void variable(const NetcdfVariable& variable);

  // The whole of a variable; values have its type.
  void write(const std::string& path, const void* values);
  void write_texts(const std::string& path, const std::vector<std::string>& texts);
  // All values at index `at` of the first dimension.
  void write_at(const std::string& path, std::uint64_t at, const void* values);
  void write_text_at(const std::string& path, std::uint64_t at, const std::string& text);
  // Rows of a ragged variable at that index: `values` has rows of equal length.
  void write_ragged_at(const std::string& path, std::uint64_t at, std::span<const float> values,
                       std::uint64_t rows);

  // Error (io): the first failure.
  Status close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ensonify
