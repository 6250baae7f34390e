// The keys of what lies on terrain: stones and patches of other sediment.
#include <cmath>

#include <fmt/format.h>

#include "core/units.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

// Smaller stones and patches would be spikes at single grid points.
constexpr double kMinCells = 2;

constexpr double kMaxStones = 1e6;

// With either sign this gives factors from 1e-3 to 1e3, the range of a reflectivity map.
constexpr NumberRange kRelativeDb = from_to(-30, 30);

constexpr NumberRange kShare = from_to(0, 1);

std::string below_cells(double length_m, double cell_m, std::string_view what) {
  return fmt::format("{} m is less than {} cells of {} m; expected larger {} or a smaller cell_m",
                     length_m, kMinCells, cell_m, what);
}

// Mean square of the diameter, from the density b D^(-b-1) / (1 - q) with D in units of the
// smallest diameter and q = (smallest / largest)^b.
double mean_square_m2(const StoneSpec& stones) {
  const auto [smallest, largest] = stones.diameter_m;
  const double b = stones.exponent, ratio = largest / smallest;
  if (ratio == 1) return smallest * smallest;
  const double integral =
      std::abs(b - 2) < 1e-9 ? std::log(ratio) : (std::pow(ratio, 2 - b) - 1) / (2 - b);
  return smallest * smallest * b * integral / (1 - std::pow(ratio, -b));
}

bool range_field(Fields& f, const KeyText& text, std::array<double, 2>& range,
                 const NumberRange& accepted, Rule rule = {}) {
  const bool read = f.numbers(text, range, accepted, rule);
  if (!read || range[0] <= range[1]) return read;
  f.fault(text.key, fmt::format("{} is more than {}; expected [least, most]", range[0], range[1]));
  return false;
}

void stone_fields(Fields& f, StoneSpec& stones, const HeightfieldSpec& field) {
  const bool has_density =
      f.number({"density_per_m2", "Density", "Mean number of stones per area", "1/m²"},
               stones.density_per_m2, from_to(0, 1e6), kRequired);
  const bool has_diameter =
      range_field(f,
                  {"diameter_m", "Diameter",
                   "[smallest, largest] diameter, at least 2 times cell_m; the longer axis of a "
                   "stone as seen from above"},
                  stones.diameter_m, kLength, kRequired);
  f.number({"exponent", "Exponent of the diameters",
            "b: the number of stones with a diameter above D follows the power law D^-b"},
           stones.exponent, from_to(0.01, 20));
  range_field(f,
              {"aspect", "Aspect ratio",
               "[least, most] ratio of the shorter axis to the longer one, as seen from above"},
              stones.aspect, from_to(0.1, 1));
  range_field(f, {"height_ratio", "Height", "[least, most] ratio of the height to the diameter"},
              stones.height_ratio, from_to(0.01, 2));
  range_field(f,
              {"buried_fraction", "Buried fraction",
               "[least, most] share of the height of a stone that is below the bed"},
              stones.buried_fraction, kShare);
  f.number({"reflectivity_db", "Relative reflectivity",
            "Reflectivity of the stones relative to that of the material"},
           stones.reflectivity_db, kRelativeDb);
  if (!has_density || !has_diameter || !(field.cell_m > 0)) return;
  if (const auto fault = stone_fault(stones, field.cell_m, field.size_m)) {
    f.fault(fault->key, fault->what);
  }
}

void patch_fields(Fields& f, PatchSpec& patch, const HeightfieldSpec& field) {
  f.number({"share", "Share", "Expected share of the area that the patches cover"}, patch.share,
           kShare, kRequired);
  const bool has_length = f.number(
      {"correlation_m", "Correlation length",
       "Standard deviation of the Gaussian correlation function of the random field that makes the "
       "patches, at least 2 times cell_m; patches are a few times as large"},
      patch.correlation_m, kLength, kRequired);
  f.number({"border_m", "Border width", "Width over which one sediment turns into the other"},
           patch.border_m, from_to(0, kMaxLengthM));
  f.number({"reflectivity_db", "Relative reflectivity",
            "Reflectivity within the patches relative to that of the material"},
           patch.reflectivity_db, kRelativeDb);
  f.number({"relief_factor", "Relief factor",
            "Factor applied, within the patches, to the heights of ripples and to waves of the "
            "roughness that are shorter than the smallest correlation_m of all patches"},
           patch.relief_factor, from_to(0, 100), useless_if(!field.file.empty(), "with a file"));
  if (!has_length || !(field.cell_m > 0)) return;
  if (const auto fault = patch_fault(patch, field.cell_m)) f.fault(fault->key, fault->what);
}

}  // namespace

void cover_fields(Fields& f, HeightfieldSpec& field) {
  f.list({"patches", "Patches",
          "Patches of other sediment with soft borders; later ones lie over earlier ones; left "
          "out: none"},
         field.patches, {}, written_if(!field.patches.empty()),
         [&](const std::string& at, PatchSpec& patch) {
           if (!f.begin(at)) return;
           patch_fields(f, patch, field);
           f.end();
         });
  f.list({"stones", "Stones",
          "Populations of stones or shells on the bed, as part of its heights; left out: none"},
         field.stones, {}, written_if(!field.stones.empty()),
         [&](const std::string& at, StoneSpec& stones) {
           if (!f.begin(at)) return;
           stone_fields(f, stones, field);
           f.end();
         });
}

bool is_random(const HeightfieldSpec& field) {
  return field.file.empty() || !field.patches.empty() || !field.stones.empty();
}

std::optional<CoverFault> stone_fault(const StoneSpec& stones, double cell_m,
                                      std::array<double, 2> size_m) {
  const auto [smallest, largest] = stones.diameter_m;
  if (smallest < kMinCells * cell_m) {
    return CoverFault{"diameter_m", below_cells(smallest, cell_m, "stones")};
  }
  const double covered = stones.density_per_m2 * mean_square_m2(stones) * kPi / 4 *
                         (stones.aspect[0] + stones.aspect[1]) / 2;
  if (covered > 1) {
    return CoverFault{"density_per_m2",
                      fmt::format("{} stones per m² of these sizes cover the bed {:.3g} times; "
                                  "expected at most once",
                                  stones.density_per_m2, covered)};
  }
  const double count = stones.density_per_m2 * (size_m[0] + largest) * (size_m[1] + largest);
  if (count > kMaxStones) {
    return CoverFault{"density_per_m2",
                      fmt::format("{} stones per m² make about {:.3g} stones; expected at most "
                                  "{:.0f}",
                                  stones.density_per_m2, count, kMaxStones)};
  }
  return std::nullopt;
}

std::optional<CoverFault> patch_fault(const PatchSpec& patch, double cell_m) {
  if (patch.correlation_m >= kMinCells * cell_m) return std::nullopt;
  return CoverFault{"correlation_m", below_cells(patch.correlation_m, cell_m, "patches")};
}

}  // namespace ensonify
