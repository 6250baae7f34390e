#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::faults_of;
using testing::kHead;
using testing::parse;

const std::string kSurface = "multipath: {surface: {z_m: 2, reflection: -1}}\n";

bool is_one_fault(const std::string& text, const std::string& what) {
  const auto faults = faults_of(kHead + text);
  CAPTURE(text, faults);
  return faults.size() == 1 && faults[0].find(what) != std::string::npos;
}

}  // namespace

TEST_CASE("multipath is read with its defaults and written back") {
  CHECK_FALSE(parse(kHead)->multipath);
  CHECK(emit(*parse(kHead)).find("multipath") == std::string::npos);
  const auto scenario = parse(kHead + kSurface);
  REQUIRE(scenario.ok());
  const Multipath& plain = *scenario->multipath;
  CHECK(plain.surface->z_m == 2);
  CHECK(plain.surface->reflection == -1);
  CHECK(plain.surface->roughness_rms_m == 0);
  CHECK_FALSE(plain.bottom);
  CHECK_FALSE(plain.objects);
  CHECK(plain.bounces == 2);
  const auto full = parse(kHead +
                          "multipath: {surface: {z_m: 2, reflection: -0.9, roughness_rms_m: 0.01}, "
                          "bottom: {z_m: -7.5, reflection: 0.25}, objects: true, bounces: 4}\n"
                          "output: {multipath: false}\n");
  REQUIRE(full.ok());
  const auto again = parse(emit(*full));
  REQUIRE(again.ok());
  CHECK(emit(*again) == emit(*full));
  CHECK(again->multipath->surface->roughness_rms_m == 0.01);
  CHECK(again->multipath->bottom->z_m == -7.5);
  CHECK(again->multipath->objects);
  CHECK(again->multipath->bounces == 4);
  CHECK_FALSE(again->output.selection.multipath);
}

TEST_CASE("numbers of multipath may be drawn") {
  const auto drawn =
      parse(kHead + "multipath: {surface: {z_m: {uniform: [4, 4]}, reflection: -1}}\n");
  REQUIRE(drawn.ok());
  CHECK(drawn->multipath->surface->z_m == 4);
  CHECK(drawn->has_draws);
  CHECK(parse(emit(*drawn))->multipath->surface->z_m == 4);
}

TEST_CASE("the mask of bounced echoes goes with multipath and pictures") {
  const auto has_mask = [](const std::string& text) {
    const auto scenario = parse(kHead + text);
    REQUIRE(scenario.ok());
    return scenario->output.selection.multipath;
  };
  CHECK_FALSE(has_mask(""));
  CHECK_FALSE(has_mask("output: {multipath: false}\n"));
  CHECK(has_mask(kSurface));
  CHECK(has_mask(kSurface + "output: {multipath: on}\n"));
  CHECK(has_mask(kSurface + "output: {polar: false}\n"));
  CHECK_FALSE(has_mask(kSurface + "output: {multipath: false}\n"));
  CHECK_FALSE(has_mask(kSurface + "output: {polar: false, cartesian: false}\n"));
  CHECK(is_one_fault("output: {multipath: true}\n", "output.multipath: nothing bounces"));
  CHECK(is_one_fault(kSurface + "output: {multipath: true, polar: false, cartesian: false}\n",
                     "output.multipath: there are no pictures for it"));
}

TEST_CASE("mirrors that cannot be are faults") {
  CHECK(is_one_fault("multipath: {}\n", "multipath: there is nothing to bounce off"));
  CHECK(is_one_fault("multipath: {objects: false}\n", "multipath: there is nothing to bounce off"));
  CHECK(is_one_fault("multipath: {surface: {z_m: 1}}\n", "multipath.surface.reflection: missing"));
  CHECK(is_one_fault("multipath: {bottom: {reflection: 1}}\n", "multipath.bottom.z_m: missing"));
  CHECK(is_one_fault("multipath: {surface: {z_m: 1, reflection: -1.5}}\n",
                     "multipath.surface.reflection"));
  CHECK(is_one_fault("multipath: {objects: true, bounces: 5}\n", "multipath.bounces"));
  CHECK(is_one_fault("multipath: {objects: true, bounces: 0}\n", "multipath.bounces"));
  CHECK(is_one_fault(
      "multipath: {surface: {z_m: -3, reflection: -1}, bottom: {z_m: -3, reflection: 1}}\n",
      "multipath.bottom.z_m: not below the surface"));
}

}  // namespace ensonify
