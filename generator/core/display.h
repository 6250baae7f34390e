// How levels become 8-bit images.
//
//   GreyScale  Flip  Resampling  Display   the settings, of original and rendered images
//   DisplayCounts                          number of pixels beyond the limits
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace ensonify {

enum class GreyScale { db, amplitude };
constexpr const char* name_of(GreyScale scale) {
  return scale == GreyScale::db ? "db" : "amplitude";
}
enum class Flip { none, horizontal, vertical, both };
constexpr const char* flip_name(Flip flip) {
  constexpr const char* kNames[] = {"none", "horizontal", "vertical", "both"};
  return kNames[static_cast<int>(flip)];
}

// How a Cartesian pixel follows from the polar image: it shows the mean intensity over its
// footprint (labels/cartesian_display.h), or the polar pixel that is nearest to its center.
enum class Resampling { bilinear, nearest };
constexpr const char* resampling_name(Resampling resampling) {
  return resampling == Resampling::bilinear ? "bilinear" : "nearest";
}

// A pixel shows its level plus a gain: s = level + spreading log10(r / 1 m) + 2 alpha r + gain_db,
// the third term with `absorption`. labels/display.h defines the gray level of s.
struct Display {
  GreyScale scale = GreyScale::db;
  double gamma = 1;                             // power of the amplitude; of GreyScale::amplitude
  double gain_db = 0;                           // constant
  double spreading = 0;                         // dB per tenfold of range
  bool absorption = false;                      // two-way, by the water's alpha
  bool automatic_gain = false;                  // of each ping
  std::array<double, 2> limits_db = {60, 120};  // black and white, dB re 1 uPa
  std::string color_map = {};                   // name of figure/drawing.h; empty: gray
  Flip flip = Flip::none;                       // of the rows and columns of an image
  Resampling resampling = Resampling::bilinear;
  friend bool operator==(const Display&, const Display&) = default;
};

// Whether both have the same time-varied gain, on which default limits depend.
inline bool same_tvg(const Display& a, const Display& b) {
  return a.spreading == b.spreading && a.absorption == b.absorption;
}

// Pixels of polar images.
struct DisplayCounts {
  std::uint64_t all = 0;
  std::uint64_t white = 0;  // show 255
  std::uint64_t echo = 0;   // hold an echo: their elevation is known
  std::uint64_t black = 0;  // ... and show 0

  DisplayCounts& operator+=(const DisplayCounts& more) {
    all += more.all;
    white += more.white;
    echo += more.echo;
    black += more.black;
    return *this;
  }
  friend bool operator==(const DisplayCounts&, const DisplayCounts&) = default;
};

}  // namespace ensonify
