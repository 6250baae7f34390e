// croissant.json, which describes the data set to catalogs and to loaders (Croissant 1.1 and its
// vocabulary for responsible AI,
// https://docs.mlcommons.org/croissant/docs/croissant-spec-1.1.html), and the header of README.md
// for the Hugging Face Hub.
//
//   PublicationInfo   what only the author knows
//   croissant_text    the file
//   card_header       YAML between lines of ---
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/ping.h"
#include "formats/files.h"

namespace ensonify {

// Empty: not stated.
struct PublicationInfo {
  std::string license;  // SPDX identifier or address
  std::string creator, citation, url;
  std::string published;  // YYYY-MM-DD
};

struct CroissantInput {
  const PublicationInfo& publication;
  const std::string& name;
  const std::string& version;  // of the program
  const SequenceInfo& first;   // whose kinds of files all sequences have
  std::span<const std::string> classes;
  std::span<const FileEntry> files;  // of the top level, with hashes
  std::uint64_t sequences = 0, pings = 0;
};

// The files of the top level are FileObjects with their hashes, each kind of file of a ping is a
// FileSet. Record sets: splits, classes, pings (the rows of index.csv), and one of each kind of
// PNG image, with sequence, ping and pixels. A member whose value is not stated is left out where
// Croissant permits it; `license`, `creator` and `url` are then "unspecified" or the folder itself,
// and `datePublished` is missing, since no date would be true.
std::string croissant_text(const CroissantInput& input);

std::string card_header(const PublicationInfo& publication, const std::string& name,
                        bool is_recording, std::uint64_t pings);

}  // namespace ensonify
