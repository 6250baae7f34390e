#include "report/page_text.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/error.h"
#include "dataset/layout.h"
#include "figure/drawing.h"
#include "formats/bytes.h"
#include "formats/json.h"

namespace ensonify {
namespace {

std::string_view text_of(std::string_view name) {
  for (const PageFile& file : page_files()) {
    if (file.name == name) return file.text;
  }
  ENSONIFY_ASSERT(!"a file of the page is not in the program");
  return {};
}

// All files of a list with this ending, one after another.
std::string files_with(std::string_view extension, std::string_view listed_in) {
  std::istringstream order{std::string(text_of(listed_in))};
  std::string all;
  for (std::string line; std::getline(order, line);) {
    if (!std::string_view(line).ends_with(extension)) continue;
    all += text_of(std::string_view(line).substr(0, line.size() - extension.size()));
    all += '\n';
  }
  return all;
}

struct Cut {
  std::string_view before, after;
};

// At the line that holds only the mark.
Cut cut_at(std::string_view text, std::string_view mark) {
  const auto at = text.find(mark);
  ENSONIFY_ASSERT(at != std::string_view::npos);
  return {text.substr(0, at), text.substr(at + mark.size())};
}

// Limits texts of a hostile data set.
constexpr std::size_t kScenarioBytes = std::size_t{1} << 20;

// Digits that the page does not show would take a tenth of it.
Json short_number(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  const double scale = std::pow(10.0, digits);
  const double scaled = std::round(value * scale) / scale;
  return std::isfinite(scaled) ? scaled : value;
}

constexpr int kMetreDigits = 4, kRadianDigits = 7, kQuaternionDigits = 7;

Json vector_json(Vec3 v) {
  return {short_number(v.x, kMetreDigits), short_number(v.y, kMetreDigits),
          short_number(v.z, kMetreDigits)};
}

void append_pose(const Pose& pose, Json& list) {
  for (const Json& x : vector_json(pose.position_m)) list.push_back(x);
  const Quat& q = pose.rotation;
  for (const double x : {q.w, q.x, q.y, q.z}) list.push_back(short_number(x, kQuaternionDigits));
}

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json instances_json(const ShownSequence& sequence, const std::vector<std::string>& classes) {
  Json list = Json::array();
  for (const StoredInstance& instance : sequence.stored.instances) {
    const InstanceFacts& facts = sequence.facts.instances[instance.id - 1];
    list.push_back({{"id", instance.id},
                    {"name", instance.name},
                    {"class", classes[instance.class_id - 1]},
                    {"class_id", instance.class_id},
                    {"kind", facts.kind},
                    {"size_m", facts.size_m ? vector_json(*facts.size_m) : Json(nullptr)}});
  }
  return list;
}

Json sequence_json(const ShownSequence& sequence, const std::vector<std::string>& classes) {
  const StoredSequence& stored = sequence.stored;
  Json azimuth = Json::array(), path = Json::array(), sonar = Json::object();
  for (const double a : sequence.facts.azimuth_rad) {
    azimuth.push_back(short_number(a, kRadianDigits));
  }
  for (const Vec3 p : sequence.path) path.push_back(vector_json(p));
  for (const auto& [name, value] : sequence.facts.numbers) sonar[name] = value;
  Json draws = nullptr;
  for (const auto& [key, value] : sequence.facts.draws) {
    const Json number = parse_shallow(value);
    draws[key] = number.is_number() ? number : Json(value);
  }
  return {{"sequence", stored.row.sequence},
          {"seed", stored.seed},
          {"split", stored.row.split},
          {"pings", stored.row.pings()},
          {"beams", stored.beams},
          {"samples", stored.samples},
          {"azimuth_rad", std::move(azimuth)},
          {"range_step_m", stored.range_step_m},
          {"first_range_m", stored.first_range_m},
          {"recorded", stored.manifest.info.recording.has_value()},
          {"sonar", std::move(sonar)},
          {"instances", instances_json(sequence, classes)},
          {"path", std::move(path)},
          {"draws", std::move(draws)}};
}

Json ping_json(const ShownPing& ping, const CodedPing& coded, const StoredSequence& sequence) {
  Json pose = Json::array(), boxes = Json::array(), seen = Json::array();
  append_pose(ping.sonar_in_world, pose);
  for (const StoredBox& box : ping.boxes) {
    Json row = {box.instance};
    for (const Json& x : vector_json(box.size_m)) row.push_back(x);
    append_pose(box.in_world, row);
    boxes.push_back(std::move(row));
  }
  for (const SeenInstance& instance : ping.seen) {
    seen.push_back({instance.instance, instance.pixels,
                    instance.occlusion ? short_number(*instance.occlusion, 4) : Json(nullptr)});
  }
  Json beam = nullptr;
  if (coded.beam_level) {
    beam = {{"beam", coded.beam},
            {"level_db", *coded.beam_level},
            {"clean_db", or_null(coded.beam_clean)}};
  }
  return {{"sequence", ping.sequence},
          {"ping", ping.ping},
          {"time_s", ping.time_s},
          {"stem", layout::index_stem(sequence.row.sequence, ping.ping)},
          {"split", sequence.row.split},
          {"pose", std::move(pose)},
          {"boxes", std::move(boxes)},
          {"seen", std::move(seen)},
          {"pictures",
           {{"level", or_null(coded.level)},
            {"clean", or_null(coded.clean)},
            {"elevation", or_null(coded.elevation)},
            {"labels", or_null(coded.labels)},
            {"shadow", or_null(coded.shadow)},
            {"multipath", or_null(coded.multipath)}}},
          {"beam", std::move(beam)}};
}

Json counts_json(const PageContents& page) {
  Json list = Json::array();
  for (std::size_t i = 0; i < page.survey.classes.size(); ++i) {
    const ClassCount& count = page.survey.classes[i];
    list.push_back({{"class", page.dataset.classes[i]},
                    {"instances", count.instances},
                    {"pictures", count.images},
                    {"pixels", count.pixels},
                    {"hidden", count.hidden}});
  }
  return list;
}

Json ranges_json(const PageContents& page) {
  if (page.survey.view != "polar") return nullptr;
  Json edges = Json::array(), counts = Json::object();
  for (const double edge : page.survey.range_edges_m) {
    edges.push_back(short_number(edge, kMetreDigits));
  }
  for (std::size_t i = 0; i < page.survey.classes.size(); ++i) {
    counts[page.dataset.classes[i]] = page.survey.classes[i].ranges;
  }
  return {{"edges_m", std::move(edges)}, {"counts", std::move(counts)}};
}

Json speckle_json(const PageContents& page) {
  if (!page.look.speckle) return nullptr;
  const Speckle& speckle = *page.look.speckle;
  Json edges = Json::array();
  for (int i = 0; i <= kSpeckleSteps; ++i) {
    edges.push_back(short_number(i * kSpeckleEnd / kSpeckleSteps, 6));
  }
  return {{"edges", std::move(edges)},
          {"counts", speckle.counts},
          {"over", speckle.over},
          {"pixels", speckle.pixels},
          {"pings", speckle.pings},
          {"mean", speckle.mean},
          {"contrast", speckle.contrast},
          {"contrast_standard_error", speckle.contrast_standard_error},
          {"what",
           "intensity relative to the expected level with noise, of the shown pings: pixels of "
           "surfaces without a coherent part, in rows without side lobes of coherent echoes, at "
           "least 15 dB above the noise and at most 40 dB below the strongest level of the ping"}};
}

Json statistics_json(const PageContents& page) {
  if (page.statistics.empty()) return nullptr;
  Json list = Json::array();
  for (const CodedStatistics& statistics : page.statistics) {
    Json arrays = Json::array();
    for (const CodedArray& array : statistics.arrays) {
      arrays.push_back({{"name", array.name},
                        {"min", array.min},
                        {"max", array.max},
                        {"unit", array.unit},
                        {"what", array.what},
                        {"chunk", array.chunk}});
    }
    list.push_back({{"sequence", statistics.sequence},
                    {"realisations", statistics.realisations},
                    {"arrays", std::move(arrays)}});
  }
  return list;
}

Json head_json(const PageContents& page) {
  const PictureScale& scale = page.look.scale;
  std::uint64_t split_sequences = 0;
  Json splits = Json::array();
  for (const SplitCount& split : page.survey.splits) {
    splits.push_back(
        {{"name", split.name}, {"sequences", split.sequences}, {"pings", split.pings}});
    split_sequences += split.sequences;
  }
  Json elevation = nullptr;
  if (scale.min_rad) elevation = {{"min_rad", *scale.min_rad}, {"max_rad", *scale.max_rad}};
  return {{"page", 1},
          {"preview", page.preview},
          {"program", page.facts.program},
          {"name", page.dataset.name},
          {"seed", page.facts.seed},
          {"scenario_sha256", page.facts.scenario_sha256},
          {"scenario_yaml", page.facts.scenario.substr(0, kScenarioBytes)},
          {"bytes", page.facts.bytes},
          {"totals", {{"sequences", split_sequences}, {"pings", page.survey.pings}}},
          {"shown", {{"pings", page.survey.shown.size()}}},
          {"classes", page.dataset.classes},
          {"splits", std::move(splits)},
          {"scale",
           {{"min_db", scale.min_db},
            {"max_db", scale.max_db},
            {"show_min_db", scale.show_min_db},
            {"show_max_db", scale.show_max_db}}},
          {"elevation", std::move(elevation)},
          {"colour_maps", colour_maps_json()},
          {"counts_view", page.survey.view.empty() ? Json(nullptr) : Json(page.survey.view)},
          {"counts", counts_json(page)},
          {"ranges", ranges_json(page)}};
}

}  // namespace

std::string without_angles(const std::string& text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) safe += c == '<' ? "\\u003c" : std::string(1, c);
  return safe;
}

Json colour_maps_json() {
  Json maps = Json::object();
  for (const ColourMap& map : colour_maps()) maps[map.name] = map.stops;
  return maps;
}

void append_data(const std::string& json, const Chunks& chunks, StreamedFile& output) {
  output.append("<script type=\"application/json\" id=\"report\">");
  output.append(json);
  output.append("</script>\n");
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    output.append("<script type=\"text/plain\" id=\"chunk-" + std::to_string(i) + "\">" +
                  base64(chunks[i]) + "</script>\n");
  }
}

PageFrame page_frame(std::string_view page, std::string_view order) {
  const Cut styles = cut_at(text_of(page), "@styles@\n");
  const Cut data = cut_at(styles.after, "@data@\n");
  const Cut scripts = cut_at(data.after, "@scripts@\n");
  PageFrame frame;
  frame.before = std::string(kPageMark);
  frame.before += styles.before;
  frame.before += files_with(".css", order);
  frame.before += data.before;
  frame.after = scripts.before;
  frame.after += files_with(".js", order);
  frame.after += scripts.after;
  return frame;
}

std::string page_json(const PageContents& page) {
  Json json = head_json(page);
  Json& sequences = json["sequences"] = Json::array();
  for (const ShownSequence& sequence : page.survey.sequences) {
    sequences.push_back(sequence_json(sequence, page.dataset.classes));
  }
  Json& pings = json["pings"] = Json::array();
  for (std::size_t i = 0; i < page.survey.shown.size(); ++i) {
    const ShownPing& ping = page.survey.shown[i];
    pings.push_back(
        ping_json(ping, page.pictures.pings[i], page.survey.sequences[ping.sequence].stored));
  }
  json["speckle"] = speckle_json(page);
  json["statistics"] = statistics_json(page);
  // Replaces invalid UTF-8, since names are untrusted.
  return without_angles(json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace ensonify
