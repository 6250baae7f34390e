#include <fmt/format.h>

#include "scenario/parse.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr double kMaxVertices = 64e6;

// 1 GiB while the waves are summed.
constexpr double kMaxPeriodCells = 1 << 26;

// Coarser ones would be drawn as zigzags.
constexpr double kMinCellsPerRipple = 4;

// Under the trochoid's cusp at 1/pi; sand of more than 0.16 would slide.
constexpr double kMaxSteepness = 0.3;

void parse_roughness(Faults& faults, const Value& map, HeightfieldSpec& field) {
  if (!open_map(faults, map, {"rms_m", "exponent", "outer_scale_m"})) return;
  RoughnessSpec roughness;
  read_number(faults, map, "rms_m", from_to(0, 1e3), roughness.rms_m, Need::required);
  // At 2 the mean square of a surface with ever shorter waves has no limit.
  read_number(faults, map, "exponent", above_up_to(2, 8), roughness.exponent);
  read_number(faults, map, "outer_scale_m", kLength, roughness.outer_scale_m);
  field.roughness = roughness;
}

void parse_ripple(Faults& faults, const Value& map, double cell_m, RippleSpec& ripple) {
  if (!open_map(faults, map, {"height_m", "wavelength_m", "direction_deg"})) return;
  const bool has_height =
      read_number(faults, map, "height_m", from_to(0, 1e3), ripple.height_m, Need::required);
  const bool has_length =
      read_number(faults, map, "wavelength_m", kLength, ripple.wavelength_m, Need::required);
  read_number(faults, map, "direction_deg", from_to(-360, 360), ripple.direction_deg);
  if (!has_length) return;
  if (ripple.wavelength_m < kMinCellsPerRipple * cell_m) {
    const Value value = *child(map, "wavelength_m");
    add_fault(faults, value.place, value.path,
              fmt::format("{} m is less than {} cells of {} m, accepted are longer ripples or a "
                          "smaller cell_m",
                          ripple.wavelength_m, kMinCellsPerRipple, cell_m));
  }
  if (has_height && ripple.height_m > kMaxSteepness * ripple.wavelength_m) {
    const Value value = *child(map, "height_m");
    add_fault(faults, value.place, value.path,
              fmt::format("{} m is too steep for a wavelength of {} m, accepted are heights up to "
                          "{} of it",
                          ripple.height_m, ripple.wavelength_m, kMaxSteepness));
  }
}

void check_size(Faults& faults, const Value& map, const HeightfieldSpec& field) {
  const auto refuse = [&](const std::string& trouble) {
    const Value value = *child(map, "cell_m");
    add_fault(faults, value.place, value.path, trouble + "; take larger cells or a smaller size_m");
  };
  const auto [size_x, size_y] = field.size_m;
  const double vertices = (size_x / field.cell_m + 1) * (size_y / field.cell_m + 1);
  if (vertices > kMaxVertices) {
    refuse(fmt::format("{} m over {} m x {} m makes {:.4g} vertices, accepted are {:.0f} at most",
                       field.cell_m, size_x, size_y, vertices, kMaxVertices));
    return;
  }
  if (!field.roughness) return;
  const auto [period_x, period_y] = roughness_period(field);
  if (static_cast<double>(period_x) * static_cast<double>(period_y) > kMaxPeriodCells) {
    refuse(
        fmt::format("{} m for roughness over {} m x {} m makes {} x {} waves, accepted are "
                    "{:.0f} at most",
                    field.cell_m, size_x, size_y, period_x, period_y, kMaxPeriodCells));
  }
}

void parse_procedural(Faults& faults, const Value& map, HeightfieldSpec& field) {
  refuse_useless(faults, map, {"height_scale", "height_offset_m"}, "without a file");
  const bool has_size = read_numbers(faults, map, "size_m", kLength, field.size_m, Need::required);
  const bool has_cell = read_number(faults, map, "cell_m", kLength, field.cell_m, Need::required);
  if (const auto roughness = child(map, "roughness")) parse_roughness(faults, *roughness, field);
  if (has_size && has_cell) check_size(faults, map, field);
  const auto ripples = child(map, "ripples");
  if (!ripples || !open_list(faults, *ripples)) return;
  field.ripples.resize(ripples->node->items.size());
  for (std::size_t i = 0; i < field.ripples.size(); ++i) {
    parse_ripple(faults, item(*ripples, i), field.cell_m, field.ripples[i]);
  }
}

void parse_height_file(const InputFolder& input, const Value& map, HeightfieldSpec& field) {
  Faults& faults = input.faults;
  refuse_useless(faults, map, {"roughness", "ripples"}, "beside a file");
  const bool found = parse_input_file(input, map, "file", {".npy", ".png", ".asc"}, field.file);
  if (found && equals_ignoring_case(field.file.extension().string(), ".asc")) {
    refuse_useless(faults, map, {"cell_m"}, "beside an .asc file, which brings its own");
  } else {
    read_number(faults, map, "cell_m", kLength, field.cell_m,
                found ? Need::required : Need::optional);
  }
  read_number(faults, map, "height_scale", from_to(-1e6, 1e6), field.height_scale);
  read_number(faults, map, "height_offset_m", from_to(-kMaxLengthM, kMaxLengthM),
              field.height_offset_m);
}

}  // namespace

void parse_heightfield(const InputFolder& input, const Value& map, HeightfieldSpec& field) {
  Faults& faults = input.faults;
  if (!open_map(faults, map,
                {"file", "size_m", "cell_m", "height_scale", "height_offset_m", "roughness",
                 "ripples", "normals", "reflectivity_map"})) {
    return;
  }
  const auto source =
      only_key_of(faults, map, {"file", "size_m"}, "a file of heights or the size_m of a made one");
  if (source == "file") parse_height_file(input, map, field);
  if (source == "size_m") parse_procedural(faults, map, field);
  read_choice<bool>(faults, map, "normals", {{"face", false}, {"smooth", true}},
                    field.smooth_normals);
  if (child(map, "reflectivity_map")) {
    parse_input_file(input, map, "reflectivity_map", {".npy", ".png"}, field.reflectivity_map);
  }
}

}  // namespace ensonify
