// The speckle that a page shows, against theory: intensities over their expectation are
// exponential.
#include "catch.h"
#include "report/look.h"
#include "report/page.h"

namespace ensonify {
namespace {

using test::Page;
using test::TemporaryFolder;
using PageJson = nlohmann::json;

// The standard error is the page's own, by leaving out parts; of some 10,000 pixels, of which some
// dozen are correlated, it is of the order of 0.03.
void check_speckle(const PageJson& speckle) {
  const double contrast = speckle.at("contrast"), error = speckle.at("contrast_standard_error");
  INFO(contrast << " +- " << error << " of " << speckle.at("pixels") << " pixels");
  CHECK(speckle.at("pixels") > 3000);
  CHECK(error > 0.002);
  CHECK(error < 0.1);
  CHECK(contrast == Approx(1).margin(3 * error));
  CHECK(speckle.at("mean").get<double>() == Approx(1).margin(3 * error));
  std::uint64_t counted = speckle.at("over");
  for (const PageJson& count : speckle.at("counts")) counted += count.get<std::uint64_t>();
  CHECK(counted == speckle.at("pixels"));
  CHECK(speckle.at("edges").size() == speckle.at("counts").size() + 1);
}

TEST_CASE("the contrast of rough surfaces is 1") {
  const TemporaryFolder folder;
  const Page page =
      test::page_of(test::make_set(folder, "set", test::kScene, {{"trajectory.pings", "20"}}));
  check_speckle(page.json.at("speckle"));
  CHECK(page.json.at("speckle").at("pings") == 20);
}

// Draws that stay the same are no new evidence: the standard error must not fall with the pings.
TEST_CASE("one pattern in many pings counts once") {
  const TemporaryFolder folder;
  std::string quiet = test::kScene;  // noise is drawn anew each time
  const std::string noise = "noise: {spectrum_level_db: 30}\n";
  quiet.erase(quiet.find(noise), noise.size());
  const auto error_of = [&](const char* name, const char* pings) {
    const Page page = test::page_of(test::make_set(
        folder, name, quiet, {{"trajectory.pings", pings}, {"scattering.speckle", "per_ray"}}));
    return page.json.at("speckle").at("contrast_standard_error").get<double>();
  };
  CHECK(error_of("many", "8") == Approx(error_of("one", "1")).epsilon(1e-6));
}

// 48 x 40 pixels of a level that does not vary: no speckle at all, but where it must not be looked
// for it is not.
struct Flat {
  StoredPixels pixels;
  ShownSequence sequence;

  Flat() {
    pixels.rows = 40;
    pixels.columns = 48;
    pixels.level_db.assign(40 * 48, 100);
    pixels.clean_db.assign(40 * 48, 100);
    pixels.instance.assign(40 * 48, 1);
    sequence.facts.instances = {{"surface", {}, true}, {"point_target", {}, false}};
  }
  double pixels_used() const {
    double n = 0;
    for (const SpeckleSum& sum : speckle_of(pixels, sequence).groups) n += sum.pixels;
    return n;
  }
};

TEST_CASE("speckle is taken from fit pixels alone") {
  Flat flat;
  CHECK(flat.pixels_used() == 40 * 48);
  flat.pixels.instance[10 * 48 + 7] = 2;  // and two rows on either side
  CHECK(flat.pixels_used() == 35 * 48);
  flat.pixels.clean_db[20 * 48] = 59;  // more than 40 dB under the highest
  flat.pixels.instance[20 * 48 + 1] = 0;
  CHECK(flat.pixels_used() == 35 * 48 - 2);
  flat.sequence.facts.noise_power_pa2 = 1e-12 * 1e9;  // 90 dB
  CHECK(flat.pixels_used() == 0);
  flat.sequence.facts.noise_power_pa2 = 0;
  flat.sequence.facts.instances[0].rough = false;
  CHECK(flat.pixels_used() == 0);
}

TEST_CASE("without masks all pixels are used, or none") {
  Flat flat;
  flat.pixels.instance.clear();
  CHECK(speckle_of(flat.pixels, flat.sequence).groups.empty());
  flat.sequence.facts.instances.pop_back();
  CHECK(flat.pixels_used() == 40 * 48);
}

}  // namespace
}  // namespace ensonify
