#include "export/hdf5_file.h"

#include <hdf5_hl.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "core/units.h"
#include "export/hdf5_handle.h"
#include "formats/files.h"

namespace ensonify {

namespace {

// IEEE half precision, for which the library has no name.
Hdf5Handle half_type() {
  Hdf5Handle type(H5Tcopy(H5T_IEEE_F32LE), H5Tclose);
  H5Tset_fields(type.get(), 15, 10, 5, 0, 10);
  H5Tset_size(type.get(), 2);
  H5Tset_ebias(type.get(), 15);
  return type;
}

Hdf5Handle complex_type() {
  Hdf5Handle type(H5Tcreate(H5T_COMPOUND, 8), H5Tclose);
  H5Tinsert(type.get(), "r", 0, H5T_IEEE_F32LE);
  H5Tinsert(type.get(), "i", 4, H5T_IEEE_F32LE);
  return type;
}

Hdf5Handle type_of(Hdf5Type type) {
  switch (type) {
    case Hdf5Type::u8:
      return Hdf5Handle(H5Tcopy(H5T_STD_U8LE), H5Tclose);
    case Hdf5Type::u16:
      return Hdf5Handle(H5Tcopy(H5T_STD_U16LE), H5Tclose);
    case Hdf5Type::u32:
      return Hdf5Handle(H5Tcopy(H5T_STD_U32LE), H5Tclose);
    case Hdf5Type::u64:
      return Hdf5Handle(H5Tcopy(H5T_STD_U64LE), H5Tclose);
    case Hdf5Type::f16:
      return half_type();
    case Hdf5Type::f32:
      return Hdf5Handle(H5Tcopy(H5T_IEEE_F32LE), H5Tclose);
    case Hdf5Type::f64:
      return Hdf5Handle(H5Tcopy(H5T_IEEE_F64LE), H5Tclose);
    case Hdf5Type::complex64:
      return complex_type();
  }
  return Hdf5Handle(-1, H5Tclose);
}

double fill_value(Hdf5Fill fill) {
  if (fill == Hdf5Fill::zero) return 0;
  return fill == Hdf5Fill::nan ? std::numeric_limits<double>::quiet_NaN() : kNoEnergyDb;
}

Hdf5Handle creation(const Hdf5ArraySpec& spec) {
  Hdf5Handle list = timeless(H5P_DATASET_CREATE);
  const bool empty = std::find(spec.shape.begin(), spec.shape.end(), 0U) != spec.shape.end();
  if (spec.shape.size() > 1 && !empty) {
    std::vector<hsize_t> chunk(spec.shape.begin(), spec.shape.end());
    chunk[0] = 1;
    H5Pset_chunk(list.get(), static_cast<int>(chunk.size()), chunk.data());
    if (spec.deflate) H5Pset_deflate(list.get(), 1);
  }
  if (spec.fill != Hdf5Fill::zero) {
    const double fill = fill_value(spec.fill);
    H5Pset_fill_value(list.get(), H5T_NATIVE_DOUBLE, &fill);
  }
  return list;
}

// Rows are written once and whole, so caching their chunks would only take memory.
Hdf5Handle uncached() {
  Hdf5Handle list(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(list.get(), 1, 0, 1);
  return list;
}

Hdf5Handle parents_made() {
  Hdf5Handle list(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(list.get(), 1);
  return list;
}

struct Hdf5WriterState {
  std::filesystem::path path;
  hid_t file = -1;
  std::string failure;
  struct Array {
    Hdf5Handle set, type;
    std::size_t rank;
  };
  std::map<std::string, Array> arrays;

  void check(bool ok, const std::string& what) {
    if (!ok && failure.empty()) failure = what;
  }
  bool failed() const { return !failure.empty(); }

  void put_attribute(hid_t object, const std::string& key, hid_t type, const void* value) {
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle attribute(
        H5Acreate2(object, key.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(attribute.ok() && H5Awrite(attribute.get(), type, value) >= 0, "attribute " + key);
  }
  // Creates the group if it does not exist.
  Hdf5Handle group(const std::string& name) {
    const bool there = name == "/" || H5Lexists(file, name.c_str(), H5P_DEFAULT) > 0;
    if (there) return Hdf5Handle(H5Gopen2(file, name.c_str(), H5P_DEFAULT), H5Gclose);
    const Hdf5Handle parents = parents_made();
    const Hdf5Handle list = timeless(H5P_GROUP_CREATE);
    return Hdf5Handle(H5Gcreate2(file, name.c_str(), parents.get(), list.get(), H5P_DEFAULT),
                      H5Gclose);
  }
  // Creates every parent with group(), since groups created automatically have time stamps.
  void make_groups_of(const std::string& array) {
    for (auto slash = array.find('/', 1); slash != std::string::npos && !failed();
         slash = array.find('/', slash + 1)) {
      const std::string name = array.substr(0, slash);
      check(group(name).ok(), name);
    }
  }
  void attach_axes(const Hdf5ArraySpec& spec, hid_t set) {
    for (std::size_t i = 0; i < spec.axes.size(); ++i) {
      if (spec.axes[i].empty()) continue;
      const auto axis = arrays.find(spec.axes[i]);
      check(axis != arrays.end(), spec.axes[i]);
      if (failed()) return;
      const hid_t scale = axis->second.set.get();
      if (H5DSis_scale(scale) <= 0) {
        const std::string label = spec.axes[i].substr(spec.axes[i].rfind('/') + 1);
        check(H5DSset_scale(scale, label.c_str()) >= 0, spec.axes[i]);
      }
      check(H5DSattach_scale(set, scale, static_cast<unsigned>(i)) >= 0, spec.path);
    }
  }
};

class Hdf5Writer final : public Hdf5File {
 public:
  explicit Hdf5Writer(std::filesystem::path path);
  ~Hdf5Writer() override;

  void make_array(const Hdf5ArraySpec& spec) override;
  void write_row(const std::string& path, std::uint64_t row, const void* data,
                 const std::vector<std::uint64_t>& shape) override;
  void write_all(const std::string& path, const void* data) override;
  void release_arrays() override;
  void write_texts(const std::string& path, const std::vector<std::string>& texts) override;
  void set_text(const std::string& group, const std::string& key,
                const std::string& value) override;
  void set_number(const std::string& group, const std::string& key, std::uint64_t value) override;
  void set_number(const std::string& group, const std::string& key, double value) override;
  Status close() override;

 private:
  using State = Hdf5WriterState;
  State state_;
};

Hdf5Writer::Hdf5Writer(std::filesystem::path path) {
  state_.path = std::move(path);
  // After a write that failed the library would try again when the program ends, and crash.
  H5dont_atexit();
  // The program reports errors itself; the library would print them on stderr.
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Hdf5Handle list = timeless(H5P_FILE_CREATE);
  state_.file = H5Fcreate(state_.path.c_str(), H5F_ACC_EXCL, list.get(), H5P_DEFAULT);
  state_.check(state_.file >= 0, "the file");
}

Hdf5Writer::~Hdf5Writer() {
  state_.arrays.clear();
  if (state_.file >= 0) H5Fclose(state_.file);
}

void Hdf5Writer::make_array(const Hdf5ArraySpec& spec) {
  if (state_.failed()) return;
  state_.make_groups_of(spec.path);
  Hdf5Handle type = type_of(spec.type);
  const std::vector<hsize_t> shape(spec.shape.begin(), spec.shape.end());
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                         H5Sclose);
  const Hdf5Handle list = creation(spec);
  const Hdf5Handle access = uncached();
  Hdf5Handle set(H5Dcreate2(state_.file, spec.path.c_str(), type.get(), space.get(), H5P_DEFAULT,
                            list.get(), access.get()),
                 H5Dclose);
  state_.check(set.ok(), spec.path);
  if (state_.failed()) return;
  for (const Hdf5Text& text : spec.attributes) {
    const Hdf5Handle text_kind = text_type(text.value.size());
    state_.put_attribute(set.get(), text.key, text_kind.get(), text.value.data());
  }
  state_.attach_axes(spec, set.get());
  state_.arrays.emplace(spec.path, State::Array{std::move(set), std::move(type), shape.size()});
}

void Hdf5Writer::write_row(const std::string& path, std::uint64_t row, const void* data,
                           const std::vector<std::uint64_t>& shape) {
  if (state_.failed()) return;
  const State::Array& array = state_.arrays.at(path);
  ENSONIFY_ASSERT(shape.size() + 1 == array.rank);
  std::vector<hsize_t> start(array.rank, 0), count(1, 1);
  start[0] = row;
  count.insert(count.end(), shape.begin(), shape.end());
  const Hdf5Handle file_space(H5Dget_space(array.set.get()), H5Sclose);
  const Hdf5Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                          H5Sclose);
  const bool written = H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start.data(), nullptr,
                                           count.data(), nullptr) >= 0 &&
                       H5Dwrite(array.set.get(), array.type.get(), memory.get(), file_space.get(),
                                H5P_DEFAULT, data) >= 0;
  state_.check(written, path);
}

void Hdf5Writer::write_all(const std::string& path, const void* data) {
  if (state_.failed()) return;
  const State::Array& array = state_.arrays.at(path);
  state_.check(
      H5Dwrite(array.set.get(), array.type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0, path);
}

void Hdf5Writer::release_arrays() { state_.arrays.clear(); }

void Hdf5Writer::write_texts(const std::string& path, const std::vector<std::string>& texts) {
  if (state_.failed()) return;
  state_.make_groups_of(path);
  std::size_t longest = 1;
  for (const std::string& text : texts) longest = std::max(longest, text.size());
  std::string padded;
  for (const std::string& text : texts) {
    padded += text;
    padded.append(longest - text.size(), '\0');
  }
  const Hdf5Handle type = text_type(longest);
  const hsize_t count = texts.size();
  const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  const Hdf5Handle list = timeless(H5P_DATASET_CREATE);
  const Hdf5Handle set(H5Dcreate2(state_.file, path.c_str(), type.get(), space.get(), H5P_DEFAULT,
                                  list.get(), H5P_DEFAULT),
                       H5Dclose);
  state_.check(set.ok() && H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                                    padded.data()) >= 0,
               path);
}

void Hdf5Writer::set_text(const std::string& group, const std::string& key,
                          const std::string& value) {
  if (state_.failed()) return;
  state_.make_groups_of(group + "/");
  const Hdf5Handle object = state_.group(group);
  const Hdf5Handle type = text_type(value.size());
  state_.put_attribute(object.get(), key, type.get(), value.data());
}

void Hdf5Writer::set_number(const std::string& group, const std::string& key, std::uint64_t value) {
  if (state_.failed()) return;
  state_.make_groups_of(group + "/");
  state_.put_attribute(state_.group(group).get(), key, H5T_STD_U64LE, &value);
}

void Hdf5Writer::set_number(const std::string& group, const std::string& key, double value) {
  if (state_.failed()) return;
  state_.make_groups_of(group + "/");
  state_.put_attribute(state_.group(group).get(), key, H5T_IEEE_F64LE, &value);
}

Status Hdf5Writer::close() {
  state_.arrays.clear();
  const hid_t file = std::exchange(state_.file, -1);
  if (file >= 0) state_.check(H5Fclose(file) >= 0, "the end of the file");
  if (!state_.failed()) return {};
  return Error{ErrorKind::io, state_.path.string() + ": HDF5 cannot write " + state_.failure +
                                  "; is the disk full?"};
}

}  // namespace

Hdf5File* new_hdf5_file(const std::filesystem::path& path) { return new Hdf5Writer(path); }

}  // namespace ensonify
