// Lists of members that manifests share, and the words and formulas of sequence.json. Every symbol
// in them is a number of sequence.json or a field of scatterers/*.npy. Private to dataset/.
//
//   sonar_members  recorder_members  instance_members   in the order of the file, for a writer and for a reader
//   placed_class_members
//   model_json                        the beam model, or that of an element-level array
//   axes_json                         rows and columns, units and frames
//   display_members  is_plain         of 8-bit images
//   grey_formula                      how they follow from levels
#pragma once

#include <optional>
#include <string>

#include "core/ping.h"
#include "dataset/json_members.h"
#include "formats/json.h"

namespace ensonify {

void sonar_members(MemberWriter& io, const SequenceInfo& info);
void sonar_members(MemberReader& io, SequenceInfo& info);

void recorder_members(MemberWriter& io, const Recorder& recorder);
void recorder_members(MemberReader& io, Recorder& recorder);

// `classes` and `instances`.
void instance_members(MemberWriter& io, const SequenceInfo& info);
void instance_members(MemberReader& io, SequenceInfo& info);

// Of a Placement and of PlacementTotals.
template <class Io, class Value>
void placed_class_members(Io& io, Value& placed) {
  io("class", placed.class_name);
  io("first", placed.first);
  io("kept", placed.kept);
}

Json model_json(const SequenceInfo& info);
Json axes_json(const OutputSelection& output);

// The settings of a display and the counts of its pixels. A plain display, without gains, has only
// scale, limits, resampling and counts. With `absorption_db_m`, of a sequence, tvg holds this
// number instead of a truth value.
void display_members(MemberWriter& io, const Display& display, const DisplayCounts& counts,
                     std::optional<double> absorption_db_m = {});
void display_members(MemberReader& io, Display& display, DisplayCounts& counts,
                     std::optional<double> absorption_db_m = {});
bool is_plain(const Display& display);
// `absorption`: the member that holds alpha.
std::string grey_formula(const Display& display, const char* absorption);

}  // namespace ensonify
