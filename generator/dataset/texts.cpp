#include "dataset/texts.h"

#include <algorithm>
#include <iterator>

#include "core/camera_planes.h"
#include "core/error.h"
#include "core/front_planes.h"
#include "core/image_planes.h"
#include "dataset/catalogue.h"
#include "dataset/manifest_json.h"
#include "dataset/ping_record.h"
#include "dataset/render_manifest.h"
#include "formats/json.h"

namespace ensonify {
namespace {

Json blank_json(PlaneBlank blank) {
  if (blank == PlaneBlank::nan) return nullptr;
  return blank == PlaneBlank::no_energy ? static_cast<int>(kNoEnergyDb) : 0;
}

Json flags_json(bool OutputSelection::*wanted) {
  Json names = Json::array();
  for (const OutputFlag* flag = wanted == nullptr ? nullptr : flag_of(wanted); flag != nullptr;
       flag = flag->needs == nullptr ? nullptr : flag_of(flag->needs)) {
    names.push_back(flag->name);
  }
  return names;
}

template <class Plane>
Json plane_json(const Plane& plane, const std::string& type) {
  return {{"name", plane.name},
          {"type", type.substr(1, type.size() - 2)},
          {"unit", plane.unit},
          {"blank", blank_json(plane.blank)},
          {"meaning", plane.meaning}};
}

std::string lines_of(const Json& rows) {
  std::string text;
  for (const Json& row : rows) text += (text.empty() ? "\n    " : ",\n    ") + json_line(row);
  return "[" + text + "\n  ]";
}

struct DescribedFile {
  std::string_view name;
  Json (*schema)();
};
constexpr DescribedFile kDescribedFiles[] = {{"sequence", sequence_schema},
                                             {"dataset", dataset_schema},
                                             {"annotations", annotations_schema},
                                             {"render", render_schema}};

}  // namespace

std::string outputs_text() {
  Json planes = Json::array(), front = Json::array(), camera = Json::array();
  for (const ImagePlane& plane : kImagePlanes) {
    Json row = plane_json(plane, plane_row(ImageView::polar, plane.name).type);
    row["group"] = plane.group();
    row["needs"] = flags_json(plane.wanted);
    planes.push_back(std::move(row));
  }
  for (const FrontPlane& plane : kFrontPlanes) {
    const CatalogueRow* array = find_array("front_" + std::string(plane.name) + ".npy");
    front.push_back(plane_json(plane, array->type));
  }
  for (const CameraPlane& plane : kCameraPlanes) {
    const CatalogueRow* array = find_array("camera_" + std::string(plane.name) + ".npy");
    Json row = plane_json(plane, array->type);
    row["file"] = plane.file;
    row["needs"] = flags_json(plane.wanted);
    camera.push_back(std::move(row));
  }
  return "{\n  \"planes\": " + lines_of(planes) + ",\n  \"front\": " + lines_of(front) +
         ",\n  \"camera\": " + lines_of(camera) + "\n}\n";
}

std::vector<std::string> described_files() {
  std::vector<std::string> names;
  for (const DescribedFile& file : kDescribedFiles) names.emplace_back(file.name);
  return names;
}

std::string members_text(std::string_view name) {
  const auto* file = std::ranges::find(kDescribedFiles, name, &DescribedFile::name);
  ENSONIFY_ASSERT(file != std::end(kDescribedFiles));
  return json_text(file->schema());
}

std::string sequence_text(const SequenceInfo& info) { return sequence_head(info, {}, 0).dump(); }

std::string annotations_text(const SequenceInfo& info, const PingResult& result) {
  return record_of(info, result, {}).annotations;
}

}  // namespace ensonify
