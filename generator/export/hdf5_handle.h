// An identifier of HDF5 that its destructor closes. Private to export/: only sources that write
// HDF5 include it.
//
//   Hdf5Handle
//   text_type    of texts with a fixed length, padded with zeros
//   timeless     a property list of a new object, without time stamps
#pragma once

#include <hdf5.h>

#include <algorithm>
#include <utility>

namespace ensonify {

class Hdf5Handle {
 public:
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  Hdf5Handle(Hdf5Handle&& other) noexcept
      : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&&) = delete;

  hid_t get() const { return id_; }
  bool ok() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

inline Hdf5Handle text_type(std::size_t bytes) {
  Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), std::max<std::size_t>(bytes, 1));
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

// `kind` is H5P_FILE_CREATE, H5P_GROUP_CREATE, H5P_DATASET_CREATE or H5P_DATATYPE_CREATE.
inline Hdf5Handle timeless(hid_t kind) {
  Hdf5Handle list(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(list.get(), false);
  return list;
}

}  // namespace ensonify
