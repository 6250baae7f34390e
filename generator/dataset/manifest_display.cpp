#include "dataset/manifest_members.h"

namespace ensonify {


static const char* name_of(Resampling value) { return resampling_name(value); }

namespace {

template <class Io, class Shown, class Counts>
void members(Io& io, Shown& display, Counts& counts, std::optional<double> absorption_db_m) {
  io.word("scale", display.scale, GreyScale::amplitude);
  io("db", display.limits_db);
  io.word("resampling", display.resampling, Resampling::nearest);
  io.group("pixels", [&](Io& pixels) {
    pixels("all", counts.all);
    pixels("white", counts.white);
    pixels("echo", counts.echo);
    pixels("black", counts.black);
  });
  if (Io::kWrites && is_plain(display)) return;
  io("gamma", display.gamma);
  io("gain_db", display.gain_db);
  io.group("tvg", [&](Io& tvg) {
    tvg("spreading", display.spreading);
    if constexpr (Io::kWrites) {
      if (absorption_db_m) return tvg("absorption_db_m", display.absorption ? *absorption_db_m : 0);
      tvg("absorption", display.absorption);
    } else {
      double alpha_db_m = 0;
      tvg("absorption", display.absorption);
      tvg("absorption_db_m", alpha_db_m);
      display.absorption = display.absorption || alpha_db_m != 0;
    }
  });
  io("automatic_gain", display.automatic_gain);
}

}  // namespace

void display_members(MemberWriter& io, const Display& display, const DisplayCounts& counts,
                     std::optional<double> absorption_db_m) {
  members(io, display, counts, absorption_db_m);
}

void display_members(MemberReader& io, Display& display, DisplayCounts& counts,
                     std::optional<double> absorption_db_m) {
  members(io, display, counts, absorption_db_m);
}

bool is_plain(const Display& display) {
  Display plain;
  plain.limits_db = display.limits_db;
  plain.color_map = display.color_map;
  plain.flip = display.flip;
  plain.resampling = display.resampling;
  return display == plain;
}

}  // namespace ensonify
