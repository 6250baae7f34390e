// Boxes and masks: annotations.jsonl of a sequence, and coco.json, which is made from all of these
// with only one line in memory. All except CocoFile is private to dataset/.
//
// annotations.jsonl has one line per ping:
//   {"ping", "time_s", "images": [{"view": polar | cartesian, "file", "width", "height",
//    "annotations": [{"instance", "bbox": [x, y, width, height], "area", "counts", "truncated",
//    "contrast_db", "occlusion", "amodal_bbox", "amodal_area", "amodal_counts"}], "hidden":
//    [{"instance", "occlusion", "amodal_bbox", "amodal_area", "amodal_counts"}]}]}
// `file` is relative to the sequence's folder, and `counts` is COCO's compressed run-length code.
// Without output.amodal, the last four members are absent and `hidden` is empty. Packed pings have
// "array" and "index" in place of "file"; masks without an image have none of the three.
//
//   for_each_annotated_ping
//   categories_json  write_coco  coco_bytes
//   CocoImage  CocoFile   some images and annotations, in another file
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {

// Calls use(ping, time_s) for the lines of a sequence's annotations.jsonl, in order. Error (io): it
// cannot be read; (damage): a line does not have the form above.
Status for_each_annotated_ping(const std::filesystem::path& dir, std::uint32_t sequence,
                               const std::function<void(std::uint32_t, double)>& use);

// Category k is classes[k - 1]; `isthing` is 1 or 0, as in COCO's panoptic files.
Json categories_json(const std::vector<std::string>& classes, const std::vector<ClassKind>& kinds);

// Writes coco.json, of the masks with an image. Images are numbered from 1 in the order sequence,
// ping, polar before Cartesian; annotations from 1 in the order of their images. Fully hidden
// instances are in a separate list, `hidden`: readers of COCO expect masks with pixels. All
// sequences are finished. Errors (damage): a sequence.json or a line cannot be read; (io).
Result<FileEntry> write_coco(const std::filesystem::path& dir, const std::string& name,
                             const std::vector<std::uint32_t>& sequences, const Json& categories,
                             bool recorded = false);

// The bytes that a line of annotations.jsonl adds to coco.json. Error (bug): the line is not valid.
Result<std::uint64_t> coco_bytes(const SequenceInfo& info, std::string_view line);

// One image of a ping, with the selected annotations.
struct CocoImage {
  std::string view;  // polar or cartesian
  std::string file_name;
  std::vector<std::uint16_t> instances;
  std::string more = {};  // members of the image in addition, as `,"name":value`
};

// A file as write_coco makes it, without the list `hidden`.
class CocoFile {
 public:
  CocoFile(const std::filesystem::path& path, const std::string& name, const Json& categories);
  ~CocoFile();
  CocoFile(const CocoFile&) = delete;
  CocoFile& operator=(const CocoFile&) = delete;

  // `line` is the ping's, of annotations.jsonl. Error (damage): it lacks a member; (bug): it names
  // an instance that the sequence does not have.
  Status add(const SequenceInfo& info, std::string_view line, const CocoImage& image);
  // Completes the file and gives it its final name. Error (io).
  Status close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ensonify
