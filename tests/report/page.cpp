#include "report/page.h"

#include <webp/decode.h>

#include <fstream>
#include <iterator>

#include "catch.h"
#include "results.h"
#include "run/options.h"
#include "run/runs.h"

namespace ensonify::test {
namespace {

std::string from_base64(std::string_view text) {
  std::string bytes;
  std::uint32_t word = 0;
  int digits = 0;
  for (const char c : text) {
    int value = -1;
    if (c >= 'A' && c <= 'Z') value = c - 'A';
    if (c >= 'a' && c <= 'z') value = c - 'a' + 26;
    if (c >= '0' && c <= '9') value = c - '0' + 52;
    if (c == '+') value = 62;
    if (c == '/') value = 63;
    if (value < 0) break;
    word = word << 6 | static_cast<std::uint32_t>(value);
    if (++digits % 4 == 0) {
      for (const int shift : {16, 8, 0}) bytes += static_cast<char>(word >> shift & 0xff);
      word = 0;
    }
  }
  if (digits % 4 == 2) bytes += static_cast<char>(word >> 4 & 0xff);
  if (digits % 4 == 3) {
    bytes += static_cast<char>(word >> 10 & 0xff);
    bytes += static_cast<char>(word >> 2 & 0xff);
  }
  return bytes;
}

// What an HTML parser takes for the contents: up to the first end tag.
std::optional<std::string> script(const std::string& text, const std::string& opening) {
  const auto at = text.find(opening);
  if (at == std::string::npos) return std::nullopt;
  const auto begin = at + opening.size();
  return text.substr(begin, text.find("</script", begin) - begin);
}

}  // namespace

std::filesystem::path make_set(const TemporaryFolder& folder, const std::string& name,
                               const std::string& scene, const std::vector<Override>& overrides) {
  GenerateOptions options;
  options.input.scenario = folder.write(name + ".yaml", scene);
  options.input.overrides = overrides;
  options.output = folder.path() / name;
  options.threads = 2;
  options.quiet = true;
  require_ok(generate(options));
  return options.output;
}

Page read_page(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  Page page;
  page.text = std::string(std::istreambuf_iterator<char>(stream), {});
  const auto json = script(page.text, "<script type=\"application/json\" id=\"report\">");
  REQUIRE(json);
  page.json = nlohmann::json::parse(*json);
  for (int i = 0;; ++i) {
    const auto chunk =
        script(page.text, "<script type=\"text/plain\" id=\"chunk-" + std::to_string(i) + "\">");
    if (!chunk) break;
    page.chunks.push_back(from_base64(*chunk));
  }
  return page;
}

Page page_of(const std::filesystem::path& set, int max_pings, int threads) {
  ReportOptions options;
  options.dataset = set;
  options.max_pings = max_pings;
  options.threads = threads;
  const auto summary = value_of(write_report(options));
  Page page = read_page(summary.output);
  CHECK(page.text.size() == summary.bytes);
  CHECK(page.json.at("shown").at("pings") == summary.shown);
  return page;
}

Picture decode(const std::string& webp) {
  Picture picture;
  std::vector<std::uint8_t> bytes(webp.begin(), webp.end());
  std::uint8_t* rgb = WebPDecodeRGB(bytes.data(), bytes.size(), &picture.width, &picture.height);
  REQUIRE(rgb != nullptr);
  for (int i = 0; i < picture.width * picture.height; ++i) {
    picture.pixels.push_back({rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]});
  }
  WebPFree(rgb);
  return picture;
}

Picture picture_at(const Page& page, const nlohmann::json& number) {
  REQUIRE(number.is_number_unsigned());
  return decode(page.chunks.at(number.get<std::size_t>()));
}

OpenSet open_set(const std::filesystem::path& set) {
  OpenSet open{value_of(open_dataset(set)), {}};
  for (const StoredSequenceRow& row : open.dataset.sequences) {
    open.sequences.push_back(value_of(read_sequence(open.dataset, row)));
  }
  return open;
}

}  // namespace ensonify::test
