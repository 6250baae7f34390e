#include "export/netcdf_file.h"

#include <hdf5_hl.h>
#include <cstdio>

#include <map>

#include "export/hdf5_handle.h"

namespace ensonify {
namespace {

// The label of a dimension scale that is no variable, as readers of netCDF-4 expect it.
constexpr char kOnlyDimension[] = "This is a netCDF dimension but not a netCDF variable.%10llu";

hid_t stored_type(NetcdfType type) {
  switch (type) {
    case NetcdfType::i8:
      return H5T_STD_I8LE;
    case NetcdfType::i16:
      return H5T_STD_I16LE;
    case NetcdfType::i32:
      return H5T_STD_I32LE;
    case NetcdfType::u64:
      return H5T_STD_U64LE;
    case NetcdfType::f64:
      return H5T_IEEE_F64LE;
    default:
      return H5T_IEEE_F32LE;
  }
}

Hdf5Handle any_text_type() {
  Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

// Lists of members in the order in which they were made, as netCDF-4 wants it.
Hdf5Handle ordered(hid_t kind) {
  Hdf5Handle list = timeless(kind);
  constexpr unsigned kOrder = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
  if (kind != H5P_DATASET_CREATE) H5Pset_link_creation_order(list.get(), kOrder);
  H5Pset_attr_creation_order(list.get(), kOrder);
  return list;
}

struct NetcdfWriterState {
  std::filesystem::path path;
  hid_t file = -1;
  std::string failure;
  struct Array {
    Hdf5Handle set, type;
    std::vector<hsize_t> shape;
  };
  std::map<std::string, Array> arrays;
  std::map<std::string, Hdf5Handle> types;
  std::map<std::string, hsize_t> lengths;  // of dimensions

  bool failed() const { return !failure.empty(); }
  void check(bool ok, const std::string& what) {
    if (!ok && failure.empty()) failure = what;
  }

  void put(hid_t object, const std::string& key, hid_t type, hsize_t count, const void* values) {
    const Hdf5Handle space(
        count == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Hdf5Handle made(
        H5Acreate2(object, key.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(made.ok() && H5Awrite(made.get(), type, values) >= 0, "attribute " + key);
  }
  void put(hid_t object, const NetcdfAttribute& attribute) {
    const auto& [key, value] = attribute;
    if (const auto* text = std::get_if<std::string>(&value)) {
      const Hdf5Handle type = text_type(text->size());
      // An empty text has one byte in HDF5, a zero, which c_str() has.
      put(object, key, type.get(), 0, text->c_str());
    } else if (const auto* whole = std::get_if<int>(&value)) {
      put(object, key, H5T_NATIVE_INT, 1, whole);
    } else if (const auto* little = std::get_if<short>(&value)) {
      put(object, key, H5T_NATIVE_SHORT, 1, little);
    } else if (const auto* number = std::get_if<float>(&value)) {
      put(object, key, H5T_NATIVE_FLOAT, 1, number);
    } else if (const auto* exact = std::get_if<double>(&value)) {
      put(object, key, H5T_NATIVE_DOUBLE, 1, exact);
    } else if (const auto* several = std::get_if<std::vector<short>>(&value)) {
      put(object, key, H5T_NATIVE_SHORT, several->size(), several->data());
    }
  }

  void name_type(const std::string& name, Hdf5Handle type) {
    const Hdf5Handle list = timeless(H5P_DATATYPE_CREATE);
    check(H5Tcommit2(file, name.c_str(), type.get(), H5P_DEFAULT, list.get(), H5P_DEFAULT) >= 0,
          name);
    types.emplace(name, std::move(type));
  }

  Hdf5Handle type_of(const NetcdfVariable& variable) {
    if (variable.type == NetcdfType::text) return any_text_type();
    if (variable.type != NetcdfType::named) {
      return Hdf5Handle(H5Tcopy(stored_type(variable.type)), H5Tclose);
    }
    // Opened again, so that the variable refers to the name and not to a copy.
    return Hdf5Handle(H5Topen2(file, variable.named_type.c_str(), H5P_DEFAULT), H5Tclose);
  }

  // An array of the variable's type, with its attributes.
  void make(const NetcdfVariable& variable, const std::vector<hsize_t>& shape) {
    Hdf5Handle type = type_of(variable);
    const Hdf5Handle list = ordered(H5P_DATASET_CREATE);
    if (shape.size() > 1 && variable.type != NetcdfType::named) {
      std::vector<hsize_t> chunk = shape;
      chunk[0] = 1;
      H5Pset_chunk(list.get(), static_cast<int>(chunk.size()), chunk.data());
      H5Pset_deflate(list.get(), 1);
    }
    const Hdf5Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
    H5Pset_chunk_cache(access.get(), 1, 0, 1);
    const Hdf5Handle space(
        shape.empty() ? H5Screate(H5S_SCALAR)
                      : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
        H5Sclose);
    Hdf5Handle set(H5Dcreate2(file, variable.path.c_str(), type.get(), space.get(), H5P_DEFAULT,
                              list.get(), access.get()),
                   H5Dclose);
    check(type.ok() && set.ok(), variable.path);
    if (failed()) return;
    for (const NetcdfAttribute& attribute : variable.attributes) put(set.get(), attribute);
    arrays.emplace(variable.path, Array{std::move(set), std::move(type), shape});
  }

  void write_part(const std::string& name, hsize_t at, hid_t type, const void* values) {
    if (failed()) return;
    const Array& array = arrays.at(name);
    std::vector<hsize_t> start(array.shape.size(), 0), count = array.shape;
    start[0] = at;
    count[0] = 1;
    const Hdf5Handle space(H5Dget_space(array.set.get()), H5Sclose);
    const Hdf5Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                            H5Sclose);
    const bool written =
        H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(),
                            nullptr) >= 0 &&
        H5Dwrite(array.set.get(), type, memory.get(), space.get(), H5P_DEFAULT, values) >= 0;
    check(written, name);
  }
};

class NetcdfWriter final : public NetcdfFile {
 public:
  explicit NetcdfWriter(std::filesystem::path path);
  ~NetcdfWriter() override;

  void group(const std::string& path, const NetcdfAttributes& attributes) override;
  void attribute(const std::string& group, const NetcdfAttribute& attribute) override;
  void enumerated(const std::string& group, const std::string& key, const std::string& type,
                  std::int8_t value) override;
  void dimension(const std::string& path, std::uint64_t length) override;
  void coordinate(const NetcdfVariable& variable, std::uint64_t length) override;
  void enumeration(const std::string& path,
                   const std::vector<std::pair<const char*, std::int8_t>>& members) override;
  void ragged_type(const std::string& path) override;
  void variable(const NetcdfVariable& variable) override;
  void write(const std::string& path, const void* values) override;
  void write_texts(const std::string& path, const std::vector<std::string>& texts) override;
  void write_at(const std::string& path, std::uint64_t at, const void* values) override;
  void write_text_at(const std::string& path, std::uint64_t at, const std::string& text) override;
  void write_ragged_at(const std::string& path, std::uint64_t at, std::span<const float> values,
                       std::uint64_t rows) override;
  Status close() override;

 private:
  using State = NetcdfWriterState;
  State state_;
};

NetcdfWriter::NetcdfWriter(std::filesystem::path path) {
  state_.path = std::move(path);
  // As in hdf5_file.cpp.
  H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Hdf5Handle list = ordered(H5P_FILE_CREATE);
  state_.file = H5Fcreate(state_.path.c_str(), H5F_ACC_EXCL, list.get(), H5P_DEFAULT);
  state_.check(state_.file >= 0, "the file");
}

NetcdfWriter::~NetcdfWriter() {
  state_.arrays.clear();
  state_.types.clear();
  if (state_.file >= 0) H5Fclose(state_.file);
}

void NetcdfWriter::group(const std::string& path, const NetcdfAttributes& attributes) {
  if (state_.failed()) return;
  const Hdf5Handle list = ordered(H5P_GROUP_CREATE);
  const Hdf5Handle made(H5Gcreate2(state_.file, path.c_str(), H5P_DEFAULT, list.get(), H5P_DEFAULT),
                        H5Gclose);
  state_.check(made.ok(), path);
  for (const NetcdfAttribute& one : attributes) {
    if (!state_.failed()) state_.put(made.get(), one);
  }
}

void NetcdfWriter::attribute(const std::string& group, const NetcdfAttribute& attribute) {
  if (state_.failed()) return;
  const Hdf5Handle object(H5Gopen2(state_.file, group.c_str(), H5P_DEFAULT), H5Gclose);
  state_.check(object.ok(), group);
  if (!state_.failed()) state_.put(object.get(), attribute);
}

void NetcdfWriter::enumerated(const std::string& group, const std::string& key,
                              const std::string& type, std::int8_t value) {
  if (state_.failed()) return;
  const Hdf5Handle object(H5Gopen2(state_.file, group.c_str(), H5P_DEFAULT), H5Gclose);
  state_.check(object.ok(), group);
  if (!state_.failed()) state_.put(object.get(), key, state_.types.at(type).get(), 1, &value);
}

void NetcdfWriter::dimension(const std::string& path, std::uint64_t length) {
  if (state_.failed()) return;
  // No values: the type is what the netCDF library itself takes.
  const Hdf5Handle list = ordered(H5P_DATASET_CREATE);
  const hsize_t count = length;
  const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  Hdf5Handle set(H5Dcreate2(state_.file, path.c_str(), H5T_IEEE_F32BE, space.get(), H5P_DEFAULT,
                            list.get(), H5P_DEFAULT),
                 H5Dclose);
  char label[80];
  std::snprintf(label, sizeof label, kOnlyDimension, static_cast<unsigned long long>(length));
  state_.check(set.ok() && H5DSset_scale(set.get(), label) >= 0, path);
  if (state_.failed()) return;
  state_.lengths[path] = length;
  state_.arrays.emplace(
      path, State::Array{std::move(set), Hdf5Handle(H5Tcopy(H5T_IEEE_F32BE), H5Tclose), {count}});
}

void NetcdfWriter::coordinate(const NetcdfVariable& variable, std::uint64_t length) {
  if (state_.failed()) return;
  state_.make(variable, {length});
  if (state_.failed()) return;
  const std::string name = variable.path.substr(variable.path.rfind('/') + 1);
  const hid_t set = state_.arrays.at(variable.path).set.get();
  state_.check(H5DSset_scale(set, name.c_str()) >= 0, variable.path);
  state_.lengths[variable.path] = length;
}

void NetcdfWriter::enumeration(const std::string& path,
                               const std::vector<std::pair<const char*, std::int8_t>>& members) {
  if (state_.failed()) return;
  Hdf5Handle type(H5Tenum_create(H5T_STD_I8LE), H5Tclose);
  for (const auto& [name, value] : members) {
    state_.check(H5Tenum_insert(type.get(), name, &value) >= 0, path);
  }
  state_.name_type(path, std::move(type));
}

void NetcdfWriter::ragged_type(const std::string& path) {
  if (state_.failed()) return;
  Hdf5Handle type(H5Tvlen_create(H5T_IEEE_F32LE), H5Tclose);
  state_.name_type(path, std::move(type));
}

void NetcdfWriter::variable(const NetcdfVariable& variable) {
  if (state_.failed()) return;
  std::vector<hsize_t> shape;
  for (const std::string& dimension : variable.dimensions) {
    shape.push_back(state_.lengths.at(dimension));
  }
  state_.make(variable, shape);
  for (std::size_t i = 0; i < shape.size() && !state_.failed(); ++i) {
    const hid_t set = state_.arrays.at(variable.path).set.get();
    const hid_t scale = state_.arrays.at(variable.dimensions[i]).set.get();
    state_.check(H5DSattach_scale(set, scale, static_cast<unsigned>(i)) >= 0, variable.path);
  }
}

void NetcdfWriter::write(const std::string& path, const void* values) {
  if (state_.failed()) return;
  const State::Array& array = state_.arrays.at(path);
  state_.check(
      H5Dwrite(array.set.get(), array.type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0,
      path);
}

void NetcdfWriter::write_texts(const std::string& path, const std::vector<std::string>& texts) {
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  write(path, pointers.data());
}

void NetcdfWriter::write_at(const std::string& path, std::uint64_t at, const void* values) {
  if (state_.failed()) return;
  state_.write_part(path, at, state_.arrays.at(path).type.get(), values);
}

void NetcdfWriter::write_text_at(const std::string& path, std::uint64_t at,
                                 const std::string& text) {
  const char* pointer = text.c_str();
  write_at(path, at, &pointer);
}

void NetcdfWriter::write_ragged_at(const std::string& path, std::uint64_t at,
                                   std::span<const float> values, std::uint64_t rows) {
  ENSONIFY_ASSERT(rows > 0 && values.size() % rows == 0);
  const std::size_t length = values.size() / rows;
  std::vector<hvl_t> pointers(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    // HDF5 only reads what it writes, but its structure has no const.
    pointers[i] = {length, const_cast<float*>(values.data()) + i * length};
  }
  const Hdf5Handle type(H5Tvlen_create(H5T_NATIVE_FLOAT), H5Tclose);
  state_.write_part(path, at, type.get(), pointers.data());
}

Status NetcdfWriter::close() {
  state_.arrays.clear();
  state_.types.clear();
  const hid_t file = std::exchange(state_.file, -1);
  if (file >= 0) state_.check(H5Fclose(file) >= 0, "the end of the file");
  if (!state_.failed()) return {};
  return Error{ErrorKind::io, state_.path.string() + ": HDF5 cannot write " + state_.failure +
                                  "; is the disk full?"};
}

}  // namespace

NetcdfFile* new_netcdf_file(const std::filesystem::path& path) { return new NetcdfWriter(path); }

}  // namespace ensonify
