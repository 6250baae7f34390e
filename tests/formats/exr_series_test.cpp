// Time series as EXR files.
#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfStringAttribute.h>

#include <complex>
#include <string>
#include <vector>

#include "catch.h"
#include "dataset/sample.h"
#include "dataset/write_ping.h"
#include "formats/exr.h"
#include "results.h"

using namespace ensonify;

namespace {

std::vector<float> read_channel(Imf::InputFile& file, const char* channel) {
  const auto window = file.header().dataWindow();
  std::vector<float> pixels(std::size_t(window.max.x + 1) * std::size_t(window.max.y + 1));
  Imf::FrameBuffer frame;
  frame.insert(channel, Imf::Slice::Make(Imf::FLOAT, pixels.data(), window));
  file.setFrameBuffer(frame);
  file.readPixels(0, window.max.y);
  return pixels;
}

}  // namespace

// Protects every number's place: rows are samples, columns beams, and floats keep all their bits.
// More rows than one block of the turning, and not a whole number of blocks.
TEST_CASE("a series reads back from EXR as OpenEXR sees it") {
  constexpr int kBeams = 7, kSamples = 37;
  std::vector<std::complex<float>> series;
  for (int i = 0; i < kBeams * kSamples; ++i) {
    series.emplace_back(1e-9f * static_cast<float>(i * i), -1.0f / static_cast<float>(i + 1));
  }
  const auto bytes = value_of(encode_series_exr(
      series, kSamples, kBeams, {{{"axes", "rows: samples"}}, {{"range_step_m", 0.025}}}));
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "a.exr", bytes);

  Imf::InputFile file((folder.path() / "a.exr").c_str());
  CHECK(file.isComplete());
  CHECK(file.header().dataWindow().max.x == kBeams - 1);
  CHECK(file.header().dataWindow().max.y == kSamples - 1);
  const auto re = read_channel(file, "p.re"), im = read_channel(file, "p.im");
  int wrong = 0;
  for (int n = 0; n < kSamples; ++n) {
    for (int j = 0; j < kBeams; ++j) {
      const std::size_t pixel = std::size_t(n) * kBeams + j;
      wrong += std::complex<float>(re[pixel], im[pixel]) != series[std::size_t(j) * kSamples + n];
    }
  }
  CHECK(wrong == 0);
}

// Protects the header: units, axes and scales, in a file of one part.
TEST_CASE("a series in EXR says its units and scales") {
  const sample::TemporaryFolder folder;
  auto info = sample::sequence_info(0);
  info.output.timeseries_exr = true;
  REQUIRE(write_ping(folder.path(), info, sample::ping_result(info, 1), Workers(1)).ok());
  const auto path = folder.path() / "sequences/000000/timeseries/000001.exr";
  const Imf::InputFile file(path.c_str());
  const Imf::Header& header = file.header();
  const auto text = [&](const char* name) {
    return header.typedAttribute<Imf::StringAttribute>(name).value();
  };
  const auto number = [&](const char* name) {
    return header.typedAttribute<Imf::DoubleAttribute>(name).value();
  };
  CHECK(contains(text("units"), "Pa (rms)"));
  CHECK(contains(text("axes"), "rows: samples"));
  CHECK(contains(text("beam_order"), "starboard"));
  CHECK(number("sample_interval_s") == 1 / 29.9e3);
  CHECK(number("carrier_frequency_hz") == 900e3);
  CHECK(number("range_step_m") == Approx(1500 / (2 * 29.9e3)));
  CHECK(number("beam_spacing_rad") == 0.3);
  const auto parts = value_of(read_exr_parts(path));
  REQUIRE(parts.size() == 1);
  CHECK(parts[0].float_channels == std::vector<std::string>{"p.im", "p.re"});
}

// Protects the choice of the format: either, both or none.
TEST_CASE("the series is written in the formats that are asked for") {
  for (const bool npy : {false, true}) {
    for (const bool exr : {false, true}) {
      const sample::TemporaryFolder folder;
      auto info = sample::sequence_info(0);
      info.output.timeseries = npy;
      info.output.timeseries_exr = exr;
      auto result = sample::ping_result(info, 0);
      if (!npy && !exr) result.series.clear();
      REQUIRE(write_ping(folder.path(), info, result, Workers(1)).ok());
      const auto files = sample::contents(folder.path());
      CHECK(files.contains("sequences/000000/timeseries/000000.npy") == npy);
      CHECK(files.contains("sequences/000000/timeseries/000000.exr") == exr);
    }
  }
}
