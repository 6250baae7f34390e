#include "dataset/croissant.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "core/counted.h"
#include "core/image_planes.h"
#include "dataset/catalogue.h"
#include "dataset/layout.h"
#include "formats/json.h"

namespace ensonify {
namespace {

constexpr char kVersion[] = "http://mlcommons.org/croissant/1.1";
constexpr char kRaiVersion[] = "http://mlcommons.org/croissant/RAI/1.0";
constexpr char kUnspecified[] = "unspecified";

bool is_address(std::string_view text) { return text.find("://") != std::string_view::npos; }

std::string license_of(const PublicationInfo& publication) {
  const std::string& license = publication.license;
  if (license.empty()) return kUnspecified;
  return is_address(license) ? license : "https://spdx.org/licenses/" + license;
}

// Appendix 1 of the specification: terms of Croissant without a prefix.
Json context() {
  Json context = {{"@language", "en"},
                  {"@vocab", "https://schema.org/"},
                  {"sc", "https://schema.org/"},
                  {"cr", "http://mlcommons.org/croissant/"},
                  {"rai", "http://mlcommons.org/croissant/RAI/"},
                  {"dct", "http://purl.org/dc/terms/"},
                  {"conformsTo", "dct:conformsTo"},
                  {"data", {{"@id", "cr:data"}, {"@type", "@json"}}},
                  {"examples", {{"@id", "cr:examples"}, {"@type", "@json"}}},
                  {"dataType", {{"@id", "cr:dataType"}, {"@type", "@vocab"}}}};
  for (const char* term : {"annotation",    "arrayShape",   "citeAs",
                           "column",        "containedIn",  "equivalentProperty",
                           "excludes",      "extract",      "field",
                           "fileObject",    "fileProperty", "fileSet",
                           "format",        "includes",     "isArray",
                           "isLiveDataset", "jsonPath",     "key",
                           "md5",           "parentField",  "path",
                           "readLines",     "recordSet",    "references",
                           "regex",         "repeated",     "replace",
                           "sdVersion",     "separator",    "source",
                           "subField",      "transform",    "unArchive",
                           "value"}) {
    context[term] = std::string("cr:") + term;
  }
  return context;
}

const char* media_type(FileCodec codec) {
  switch (codec) {
    case FileCodec::csv:
      return "text/csv";
    case FileCodec::json:
      return "application/json";
    case FileCodec::json_lines:
      return "application/jsonlines";
    case FileCodec::png:
      return "image/png";
    case FileCodec::exr:
    case FileCodec::group_exr:
    case FileCodec::front_exr:
    case FileCodec::camera_exr:
    case FileCodec::series_exr:
      return "image/x-exr";
    case FileCodec::text:
    case FileCodec::tum:
      return "text/plain";
    case FileCodec::glb:
      return "model/gltf-binary";
    case FileCodec::npy:
    case FileCodec::ply:
    case FileCodec::mesh_ply:
    case FileCodec::vdb:
      break;
  }
  return "application/octet-stream";
}

Json file_object(const FileEntry& file) {
  const CatalogueRow* row = find_file(FileScope::dataset, file.path);
  return {{"@type", "cr:FileObject"},
          {"@id", file.path},
          {"name", file.path},
          {"contentUrl", file.path},
          {"contentSize", fmt::format("{} B", file.bytes)},
          {"encodingFormat", row != nullptr ? media_type(row->codec) : media_type(FileCodec::npy)},
          {"sha256", file.sha256}};
}

// polar/{ping}_instance.png: polar-instance-png.
std::string set_id(std::string_view name_template) {
  std::string id;
  std::string name(name_template);
  const std::string mark = "{ping}";
  if (const auto at = name.find(mark); at != std::string::npos) name.erase(at, mark.size());
  for (const char c : name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (plain) id += c;
    if (!plain && !id.empty() && id.back() != '-') id += '-';
  }
  return id;
}

// Files of sequences; the name of a ping ends with a digit, so that polar/*.exr holds no
// polar/*_surfaces.exr.
Json file_set(std::string_view name_template, FileCodec codec) {
  std::string pattern(name_template);
  const std::string mark = "{ping}";
  if (const auto at = pattern.find(mark); at != std::string::npos) {
    pattern.replace(at, mark.size(), "*[0-9]");
  }
  return {{"@type", "cr:FileSet"},
          {"@id", set_id(name_template)},
          {"name", set_id(name_template)},
          {"encodingFormat", media_type(codec)},
          {"includes", "sequences/*/" + pattern}};
}

Json distribution(const CroissantInput& input) {
  Json all = Json::array();
  for (const FileEntry& file : input.files) {
    // It names the build, which the bytes of data sets do not depend on.
    if (file.path != layout::kWorkJson) all.push_back(file_object(file));
  }
  const FileSelection selection = selection_of(input.first);
  for (const CatalogueRow& row : catalogue()) {
    if (row.scope == FileScope::sequence && is_wanted(row, selection)) {
      all.push_back(file_set(row.file, row.codec));
    }
    if (is_ping_file(row, selection)) all.push_back(file_set(row.file, row.codec));
    if (is_array(row, selection)) all.push_back(file_set(row.array, FileCodec::npy));
  }
  return all;
}

Json reference(const std::string& id) { return {{"@id", id}}; }

Json field(const std::string& set, const std::string& name, const Json& type) {
  return {{"@type", "cr:Field"}, {"@id", set + "/" + name}, {"name", name}, {"dataType", type}};
}

Json column(const std::string& set, const std::string& name, const Json& type) {
  Json json = field(set, name, type);
  json["source"] = {{"fileObject", reference("index.csv")}, {"extract", {{"column", name}}}};
  return json;
}

Json record_set(const std::string& id, const Json& keys, Json fields) {
  return {{"@type", "cr:RecordSet"},
          {"@id", id},
          {"name", id},
          {"key", keys},
          {"field", std::move(fields)}};
}

Json split_records() {
  Json set = record_set("splits", reference("splits/name"),
                        {field("splits", "name", "sc:Text"), field("splits", "url", "sc:URL")});
  set["dataType"] = "cr:Split";
  set["data"] = Json::array();
  const std::pair<const char*, const char*> splits[] = {
      {"train", "cr:TrainingSplit"}, {"val", "cr:ValidationSplit"}, {"test", "cr:TestSplit"}};
  for (const auto& [name, url] : splits) {
    set["data"].push_back({{"splits/name", name}, {"splits/url", url}});
  }
  return set;
}

Json class_records(std::span<const std::string> classes) {
  Json set =
      record_set("classes", reference("classes/id"),
                 {field("classes", "id", "sc:Integer"), field("classes", "name", "sc:Text")});
  set["dataType"] = "sc:Enumeration";
  set["data"] = Json::array();
  for (std::size_t k = 0; k < classes.size(); ++k) {
    set["data"].push_back({{"classes/id", k + 1}, {"classes/name", classes[k]}});
  }
  return set;
}

Json ping_records() {
  Json split = column("pings", "split", "sc:Text");
  split["references"] = {{"field", reference("splits/name")}};
  return record_set("pings", reference("pings/stem"),
                    {column("pings", "stem", "sc:Text"), column("pings", "sequence", "sc:Integer"),
                     column("pings", "ping", "sc:Integer"), column("pings", "time_s", "sc:Float"),
                     std::move(split)});
}

// Numbers from the path of a file of a ping.
Json number_of_path(const std::string& set, const std::string& name, const std::string& regex) {
  Json json = field(set, name, "sc:Integer");
  json["source"] = {{"fileSet", reference(set)},
                    {"extract", {{"fileProperty", "fullpath"}}},
                    {"transform", {{"regex", regex}}}};
  return json;
}

// Ids of instances or classes; the other planes of integers are bits or states.
bool is_mask(const CatalogueRow& row) {
  const std::string_view plane = plane_facts(row).name;
  return plane == "semantic" || (!plane.empty() && row.type == kNpyUint16);
}

Json image_records(const CatalogueRow& row) {
  const std::string files = set_id(row.file), id = "images-" + files;
  Json pixels = field(id, "pixels", "sc:ImageObject");
  if (is_mask(row)) pixels["dataType"] = {"sc:ImageObject", "cr:SegmentationMask"};
  pixels["source"] = {{"fileSet", reference(files)}, {"extract", {{"fileProperty", "content"}}}};
  Json sequence = number_of_path(id, "sequence", ".*sequences/([0-9]+)/");
  Json ping = number_of_path(id, "ping", ".*/([0-9]+)[^/]*$");
  for (Json* number : {&sequence, &ping}) (*number)["source"]["fileSet"] = reference(files);
  return record_set(id, {reference(id + "/sequence"), reference(id + "/ping")},
                    {std::move(sequence), std::move(ping), std::move(pixels)});
}

Json record_sets(const CroissantInput& input) {
  Json sets = Json::array({split_records()});
  if (!input.classes.empty()) sets.push_back(class_records(input.classes));
  sets.push_back(ping_records());
  const FileSelection selection = selection_of(input.first);
  for (const CatalogueRow& row : catalogue()) {
    if (row.codec == FileCodec::png && is_ping_file(row, selection)) {
      sets.push_back(image_records(row));
    }
  }
  return sets;
}

// The vocabulary for responsible AI, as far as the program knows the answers.
void add_responsible_ai(const CroissantInput& input, Json& json) {
  const bool is_recording = input.first.recording.has_value();
  json["rai:hasSyntheticData"] = !is_recording;
  if (is_recording) {
    json["rai:dataCollection"] =
        "Counts of a real imaging sonar, imported from its log without a change.";
    json["rai:dataLimitations"] = "There are no labels.";
    return;
  }
  json["rai:dataCollection"] =
      "Simulated: scenario.yaml is the complete input, and sequence.json holds the model of the "
      "signals with every number.";
  json["rai:dataCollectionType"] = "Software Collection";
  json["rai:machineAnnotationTools"] = "ensonify " + input.version;
  json["rai:dataAnnotationProtocol"] =
      "Labels follow from the simulated scene: the instance with the most expected energy of the "
      "direct echoes of a pixel.";
  json["rai:personalSensitiveInformation"] = "None, unless the scenario or its files hold any.";
  json["rai:dataLimitations"] =
      "No recording: conclusions about real sonars need a check on recordings.";
  json["rai:dataBiases"] =
      "Objects, seabeds and trajectories have the distributions that scenario.yaml states.";
  json["rai:dataUseCases"] =
      "Training and testing of methods for forward-looking sonars: detection, segmentation, "
      "tracking, denoising, reconstruction.";
  json["rai:dataSocialImpact"] =
      "Models for sonars serve inspection and research, and can serve surveillance.";
}

std::string description(const CroissantInput& input) {
  const std::string what =
      counted(input.pings, "ping") + " in " + counted(input.sequences, "sequence");
  if (input.first.recording) {
    return fmt::format("Recording of a real imaging sonar, imported by ensonify {}: {}.",
                       input.version, what);
  }
  if (!is_sonar(input.first)) {
    return fmt::format("Simulated {} of a rig, generated by ensonify {}: {}.",
                       input.first.instrument == InstrumentKind::camera ? "images of a camera"
                                                                        : "navigation sensors",
                       input.version, what);
  }
  return fmt::format("Simulated multibeam sonar data with labels, generated by ensonify {}: {}.",
                     input.version, what);
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

const char* size_category(std::uint64_t pings) {
  if (pings < 1000) return "n<1K";
  if (pings < 10'000) return "1K<n<10K";
  if (pings < 100'000) return "10K<n<100K";
  if (pings < 1'000'000) return "100K<n<1M";
  return pings < 10'000'000 ? "1M<n<10M" : "10M<n<100M";
}

}  // namespace

std::string croissant_text(const CroissantInput& input) {
  const PublicationInfo& publication = input.publication;
  Json json = {{"@context", context()},
               {"@type", "sc:Dataset"},
               {"conformsTo", {kVersion, kRaiVersion}},
               {"name", input.name},
               {"description", description(input)},
               {"license", license_of(publication)},
               {"creator",
                {{"@type", "sc:Organization"},
                 {"name", publication.creator.empty() ? kUnspecified : publication.creator}}},
               {"url", publication.url.empty() ? "./" : publication.url}};
  if (!publication.published.empty()) json["datePublished"] = publication.published;
  if (!publication.citation.empty()) json["citeAs"] = publication.citation;
  json["keywords"] = {"sonar", "forward-looking sonar", "multibeam", "imaging sonar"};
  json["isLiveDataset"] = false;
  add_responsible_ai(input, json);
  json["distribution"] = distribution(input);
  json["recordSet"] = record_sets(input);
  return json_text(json);
}

std::string card_header(const PublicationInfo& publication, const std::string& name,
                        bool is_recording, std::uint64_t pings) {
  const std::string& license = publication.license;
  std::string text = fmt::format("---\npretty_name: {}\n", quoted_text(name));
  if (license.empty() || is_address(license)) {
    text += "license: other\n";
    if (!license.empty()) text += fmt::format("license_link: {}\n", quoted_text(license));
  } else {
    text += fmt::format("license: {}\n", quoted_text(lower(license)));
  }
  if (!is_recording) {
    text += "task_categories:\n- object-detection\n- image-segmentation\n";
  }
  text +=
      fmt::format("size_categories:\n- {}\ntags:\n- sonar\n- multibeam\n", size_category(pings));
  if (!is_recording) text += "- synthetic\n";
  return text + "---\n\n";
}

}  // namespace ensonify
