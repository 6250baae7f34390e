#include "export/netcdf_file.h"

#include <hdf5_hl.h>

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

}  // namespace

struct NetcdfFile::Impl {
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

NetcdfAttributes described(const char* long_name, const char* units, NetcdfAttributes more) {
  NetcdfAttributes all = {{"long_name", std::string(long_name)}, {"units", std::string(units)}};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

NetcdfFile::NetcdfFile(std::filesystem::path path) : impl_(std::make_unique<Impl>()) {
  impl_->path = std::move(path);
  // As in hdf5_file.cpp.
  H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Hdf5Handle list = ordered(H5P_FILE_CREATE);
  impl_->file = H5Fcreate(impl_->path.c_str(), H5F_ACC_EXCL, list.get(), H5P_DEFAULT);
  impl_->check(impl_->file >= 0, "the file");
}

NetcdfFile::~NetcdfFile() {
  impl_->arrays.clear();
  impl_->types.clear();
  if (impl_->file >= 0) H5Fclose(impl_->file);
}

void NetcdfFile::group(const std::string& path, const NetcdfAttributes& attributes) {
  if (impl_->failed()) return;
  const Hdf5Handle list = ordered(H5P_GROUP_CREATE);
  const Hdf5Handle made(H5Gcreate2(impl_->file, path.c_str(), H5P_DEFAULT, list.get(), H5P_DEFAULT),
                        H5Gclose);
  impl_->check(made.ok(), path);
  for (const NetcdfAttribute& one : attributes) {
    if (!impl_->failed()) impl_->put(made.get(), one);
  }
}

void NetcdfFile::attribute(const std::string& group, const NetcdfAttribute& attribute) {
  if (impl_->failed()) return;
  const Hdf5Handle object(H5Gopen2(impl_->file, group.c_str(), H5P_DEFAULT), H5Gclose);
  impl_->check(object.ok(), group);
  if (!impl_->failed()) impl_->put(object.get(), attribute);
}

void NetcdfFile::enumerated(const std::string& group, const std::string& key,
                            const std::string& type, std::int8_t value) {
  if (impl_->failed()) return;
  const Hdf5Handle object(H5Gopen2(impl_->file, group.c_str(), H5P_DEFAULT), H5Gclose);
  impl_->check(object.ok(), group);
  if (!impl_->failed()) impl_->put(object.get(), key, impl_->types.at(type).get(), 1, &value);
}

void NetcdfFile::dimension(const std::string& path, std::uint64_t length) {
  if (impl_->failed()) return;
  // No values: the type is what the netCDF library itself takes.
  const Hdf5Handle list = ordered(H5P_DATASET_CREATE);
  const hsize_t count = length;
  const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  Hdf5Handle set(H5Dcreate2(impl_->file, path.c_str(), H5T_IEEE_F32BE, space.get(), H5P_DEFAULT,
                            list.get(), H5P_DEFAULT),
                 H5Dclose);
  char label[80];
  std::snprintf(label, sizeof label, kOnlyDimension, static_cast<unsigned long long>(length));
  impl_->check(set.ok() && H5DSset_scale(set.get(), label) >= 0, path);
  if (impl_->failed()) return;
  impl_->lengths[path] = length;
  impl_->arrays.emplace(
      path, Impl::Array{std::move(set), Hdf5Handle(H5Tcopy(H5T_IEEE_F32BE), H5Tclose), {count}});
}

void NetcdfFile::coordinate(const NetcdfVariable& variable, std::uint64_t length) {
  if (impl_->failed()) return;
  impl_->make(variable, {length});
  if (impl_->failed()) return;
  const std::string name = variable.path.substr(variable.path.rfind('/') + 1);
  const hid_t set = impl_->arrays.at(variable.path).set.get();
  impl_->check(H5DSset_scale(set, name.c_str()) >= 0, variable.path);
  impl_->lengths[variable.path] = length;
}

void NetcdfFile::enumeration(const std::string& path,
                             const std::vector<std::pair<const char*, std::int8_t>>& members) {
  if (impl_->failed()) return;
  Hdf5Handle type(H5Tenum_create(H5T_STD_I8LE), H5Tclose);
  for (const auto& [name, value] : members) {
    impl_->check(H5Tenum_insert(type.get(), name, &value) >= 0, path);
  }
  impl_->name_type(path, std::move(type));
}

void NetcdfFile::ragged_type(const std::string& path) {
  if (impl_->failed()) return;
  Hdf5Handle type(H5Tvlen_create(H5T_IEEE_F32LE), H5Tclose);
  impl_->name_type(path, std::move(type));
}

void NetcdfFile::variable(const NetcdfVariable& variable) {
  if (impl_->failed()) return;
  std::vector<hsize_t> shape;
  for (const std::string& dimension : variable.dimensions) {
    shape.push_back(impl_->lengths.at(dimension));
  }
  impl_->make(variable, shape);
  for (std::size_t i = 0; i < shape.size() && !impl_->failed(); ++i) {
    const hid_t set = impl_->arrays.at(variable.path).set.get();
    const hid_t scale = impl_->arrays.at(variable.dimensions[i]).set.get();
    impl_->check(H5DSattach_scale(set, scale, static_cast<unsigned>(i)) >= 0, variable.path);
  }
}

void NetcdfFile::write(const std::string& path, const void* values) {
  if (impl_->failed()) return;
  const Impl::Array& array = impl_->arrays.at(path);
  impl_->check(
      H5Dwrite(array.set.get(), array.type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0,
      path);
}

void NetcdfFile::write_texts(const std::string& path, const std::vector<std::string>& texts) {
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  write(path, pointers.data());
}

void NetcdfFile::write_at(const std::string& path, std::uint64_t at, const void* values) {
  if (impl_->failed()) return;
  impl_->write_part(path, at, impl_->arrays.at(path).type.get(), values);
}

void NetcdfFile::write_text_at(const std::string& path, std::uint64_t at, const std::string& text) {
  const char* pointer = text.c_str();
  write_at(path, at, &pointer);
}

void NetcdfFile::write_ragged_at(const std::string& path, std::uint64_t at,
                                 std::span<const float> values, std::uint64_t rows) {
  ENSONIFY_ASSERT(rows > 0 && values.size() % rows == 0);
  const std::size_t length = values.size() / rows;
  std::vector<hvl_t> pointers(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    // HDF5 only reads what it writes, but its structure has no const.
    pointers[i] = {length, const_cast<float*>(values.data()) + i * length};
  }
  const Hdf5Handle type(H5Tvlen_create(H5T_NATIVE_FLOAT), H5Tclose);
  impl_->write_part(path, at, type.get(), pointers.data());
}

Status NetcdfFile::close() {
  impl_->arrays.clear();
  impl_->types.clear();
  const hid_t file = std::exchange(impl_->file, -1);
  if (file >= 0) impl_->check(H5Fclose(file) >= 0, "the end of the file");
  if (!impl_->failed()) return {};
  return Error{ErrorKind::io, impl_->path.string() + ": HDF5 cannot write " + impl_->failure +
                                  "; is the disk full?"};
}

}  // namespace ensonify
