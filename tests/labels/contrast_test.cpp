#include "labels/annotations.h"

#include <cmath>
#include <limits>

#include "catch.h"

using namespace ensonify;

namespace {

// Instance 2 fills rows 20 to 23 and columns 20 to 21; instance 1 is the ground around it.
struct ContrastBed {
  LabelledImage image;
  std::vector<float> power;  // [columns x rows]
  std::vector<double> size_m = {0, std::numeric_limits<double>::infinity(), 1, 9};

  ContrastBed() {
    image.rows = image.columns = 48;
    image.instance.assign(48 * 48, 1);
    power.assign(48 * 48, 1e-6f);
    for (int row = 20; row < 24; ++row) {
      for (int column : {20, 21}) set(row, column, 2, 4e-5f);
    }
  }
  void set(int row, int column, std::uint16_t instance, float power_pa2) {
    image.instance[row * 48 + column] = instance;
    power[column * 48 + row] = power_pa2;
  }
  std::vector<double> contrasts() const {
    return contrasts_db(instance_runs(image), power, annotations(instance_runs(image)), size_m);
  }
};

}  // namespace

// Protects the ratio: 40 times the ground's power are 16.02 dB; the ground has no contrast.
TEST_CASE("contrast is the ratio of mean expected powers") {
  ContrastBed bed;
  const std::vector<double> contrast = bed.contrasts();
  REQUIRE(contrast.size() == 2);
  CHECK(std::isnan(contrast[0]));
  CHECK(contrast[1] == Approx(10 * std::log10(40)).margin(1e-4));
  for (int row = 20; row < 24; ++row) bed.set(row, 20, 2, 0);  // half as much in the mean
  CHECK(bed.contrasts()[1] == Approx(10 * std::log10(20)).margin(1e-4));
}

// Protects the ring: the box and 8 pixels to each side; what belongs to no ground does not count.
TEST_CASE("contrast takes the ground of the enlarged box") {
  ContrastBed bed;
  bed.set(11, 20, 1, 1);  // a row too far
  bed.set(22, 30, 1, 1);  // a column too far
  bed.set(18, 18, 3, 1);  // another object
  bed.set(18, 24, 0, 1);  // nothing
  CHECK(bed.contrasts()[1] == Approx(10 * std::log10(40)).margin(1e-4));
  bed.set(12, 29, 1, 1);  // its corner
  CHECK(bed.contrasts()[1] < -10);
}

// Protects seabeds of meshes, which are ground by their size.
TEST_CASE("what is ten times as large is ground") {
  ContrastBed bed;
  bed.size_m = {0, 10.1, 1, 9};
  CHECK(bed.contrasts()[1] == Approx(10 * std::log10(40)).margin(1e-4));
  bed.size_m[1] = 9.9;
  CHECK(std::isnan(bed.contrasts()[1]));
}

// Protects the missing number: no ground around, or no power of one of the two.
TEST_CASE("contrast is NaN without ground") {
  ContrastBed mid_water;
  mid_water.size_m[1] = 9;
  for (const double contrast : mid_water.contrasts()) CHECK(std::isnan(contrast));
  ContrastBed silent;
  silent.power.assign(silent.power.size(), 0);
  CHECK(std::isnan(silent.contrasts()[1]));
}
