// A netCDF-4 file, which is an HDF5 file with conventions of its own: dimensions are dimension
// scales, and types that variables share are named. Private to export/; implemented in the module
// of file_module.h.
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
inline NetcdfAttributes described(const char* long_name, const char* units,
                                  NetcdfAttributes more = {}) {
  NetcdfAttributes all = {{"long_name", std::string(long_name)}, {"units", std::string(units)}};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

struct NetcdfVariable {
  std::string path;
  NetcdfType type = NetcdfType::f32;
  std::vector<std::string> dimensions;  // paths; none: a scalar
  NetcdfAttributes attributes;
  std::string named_type = {};  // path of an enumeration, or of a ragged type
};

class NetcdfFile {
 public:
  NetcdfFile() = default;
  virtual ~NetcdfFile() = default;
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  // Each needs its parent.
  virtual void group(const std::string& path, const NetcdfAttributes& attributes) = 0;
  // Of "/" or a group.
  virtual void attribute(const std::string& group, const NetcdfAttribute& attribute) = 0;
  // ... whose type is an enumeration.
  virtual void enumerated(const std::string& group, const std::string& key, const std::string& type,
                          std::int8_t value) = 0;
  // A dimension without a variable.
  virtual void dimension(const std::string& path, std::uint64_t length) = 0;
  // A dimension, and the variable with its coordinates. `variable.dimensions` is ignored.
  virtual void coordinate(const NetcdfVariable& variable, std::uint64_t length) = 0;
  virtual void enumeration(const std::string& path,
                           const std::vector<std::pair<const char*, std::int8_t>>& members) = 0;
  // Rows of floats of any length.
  virtual void ragged_type(const std::string& path) = 0;
  // Variables with two dimensions or more have a compressed chunk for each index of the first one,
  // but for ragged ones.
  virtual void variable(const NetcdfVariable& variable) = 0;

  // The whole of a variable; values have its type.
  virtual void write(const std::string& path, const void* values) = 0;
  virtual void write_texts(const std::string& path, const std::vector<std::string>& texts) = 0;
  // All values at index `at` of the first dimension.
  virtual void write_at(const std::string& path, std::uint64_t at, const void* values) = 0;
  virtual void write_text_at(const std::string& path, std::uint64_t at,
                             const std::string& text) = 0;
  // Rows of a ragged variable at that index: `values` has rows of equal length.
  virtual void write_ragged_at(const std::string& path, std::uint64_t at,
                               std::span<const float> values, std::uint64_t rows) = 0;

  // Error (io): the first failure.
  virtual Status close() = 0;
};

}  // namespace ensonify
