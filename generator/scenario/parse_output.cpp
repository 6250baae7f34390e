// What `output` says of each kind of file; parse_output goes through them.
#include "scenario/parse.h"

namespace ensonify {

void parse_timeseries(Faults& faults, const Value& output, OutputSelection& selection) {
  struct Formats {
    bool npy = true, exr = false;
  } formats;
  const bool given = read_choice<Formats>(faults, output, "timeseries",
                                          {{"npy", {true, false}},
                                           {"exr", {false, true}},
                                           {"both", {true, true}},
                                           {"none", {false, false}}},
                                          formats);
  if (!given) return;
  selection.timeseries = formats.npy;
  selection.timeseries_exr = formats.exr;
}

}  // namespace ensonify
