// Texts of what a data set would hold, without one.
//
//   outputs_text      the planes
//   described_files   the files whose members are listed once for writer, reader and schema
//   members_text      the JSON Schema of one of them, as far as the program knows it
//   sequence_text     sequence.json without its list of files
//   annotations_text  the ping's line of annotations.jsonl
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/ping.h"

namespace ensonify {

// The planes of images and front views as JSON, from which scripts/ensonify_dataset makes its
// arrays: NPY type of a packed cell, blank of a pixel without content (null: NaN), group (the
// EXR file of its own; empty: none), and needs, the outputs of a scenario that bring it.
std::string outputs_text();

// sequence, dataset, annotations, render.
std::vector<std::string> described_files();

// Of sequence.json anyOf recordings and simulations; oneOf the variants of an object by a word. It
// has titles, meanings and limits only where scenarios have the same keys; scripts/make_reference.py
// adds the others and makes output_schema/NAME.schema.json from it.
std::string members_text(std::string_view name);

std::string sequence_text(const SequenceInfo& info);

// Needs a result that fits `info`.
std::string annotations_text(const SequenceInfo& info, const PingResult& result);

}  // namespace ensonify
