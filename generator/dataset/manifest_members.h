// Lists of members that manifests share, and the words and formulas of sequence.json. Every symbol
// in them is a number of sequence.json or a field of scatterers/*.npy. Private to dataset/.
//
//   sonar_members  recorder_members  instance_members  display_members
//                                     in the order of the file, for each class of json_members.h
//   placed_class_members  files_member
//   model_json                        the beam model, or that of an element-level array
//   axes_json                         rows and columns, units and frames
//   is_plain  grey_formula            of 8-bit images: without gains; how they follow from levels
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/ping.h"
#include "dataset/json_members.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {

// Of const structs for a writer.
template <class Io, class Info>
void sonar_members(Io& io, Info& info);
template <class Io, class Value>
void recorder_members(Io& io, Value& recorder);
// `classes` and `instances`.
template <class Io, class Info>
void instance_members(Io& io, Info& info);

// Of a Placement and of PlacementTotals.
template <class Io, class Value>
void placed_class_members(Io& io, Value& placed) {
  io("class", placed.class_name);
  io("first", placed.first);
  io("kept", placed.kept);
}

template <class Io>
void files_member(Io& io, const std::vector<FileEntry>& files) {
  io.list("files", files, [](Io& file, auto& entry) {
    file("path", entry.path);
    file("bytes", entry.bytes);
    file("sha256", entry.sha256);
  });
}

Json model_json(const SequenceInfo& info);
Json axes_json(const SequenceInfo& info);

// The settings of a display and the counts of its pixels. A plain display, without gains, has only
// scale, limits, resampling and counts. With `absorption_db_m`, of a sequence, tvg holds this
// number instead of a truth value.
template <class Io, class Shown, class Counts>
void display_members(Io& io, Shown& display, Counts& counts,
                     std::optional<double> absorption_db_m = {});
bool is_plain(const Display& display);
// `absorption`: the member that holds alpha.
std::string grey_formula(const Display& display, const char* absorption);

}  // namespace ensonify
