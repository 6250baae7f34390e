#include "scenario/tables.h"

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

// A band of 90 to 110 kHz.
Sonar sonar_of_100_khz() {
  Sonar sonar;
  sonar.frequency_hz = 100e3;
  sonar.bandwidth_hz = 20e3;
  return sonar;
}

Result<std::vector<PulseTableRow>> load_pulse(const std::string& text) {
  const test::TemporaryFolder folder;
  return load_pulse_table(folder.write("t.csv", text), sonar_of_100_khz());
}

Result<BackscatterTable> load_backscatter(const std::string& text) {
  const test::TemporaryFolder folder;
  return load_backscatter_table(folder.write("t.csv", text));
}

// The faults without the folder before the file's name.
template <class T>
std::vector<std::string> lines_of(const Result<T>& result) {
  std::vector<std::string> lines = ensonify::lines_of(message_of(result));
  for (std::string& line : lines) {
    if (const std::size_t name = line.find("/t.csv:"); name != std::string::npos)
      line.erase(0, name + 1);
  }
  return lines;
}

struct TableCase {
  std::string text, begin, essential;
};

template <class Load>
void check_single(const std::vector<TableCase>& cases, Load load) {
  for (const TableCase& c : cases) {
    const auto result = load(c.text);
    const auto lines = lines_of(result);
    INFO(c.text << "\n" << joined_lines(lines));
    REQUIRE_FALSE(result.ok());
    CHECK(result.error().kind == ErrorKind::usage);
    CHECK(lines.size() == 1);
    CHECK(testing::tells(lines, c.begin, c.essential));
  }
}

const std::string kPulse = "frequency_hz,amplitude,phase_deg\n";
const std::string kSand = "grazing_deg,strength_db\n";

// A whole table, for a test to spoil.
const std::string kWholeSand =
    kSand + "0,-40\n10,-30\n20,-28\n30,-26\n40,-24\n50,-22\n60,-20\n70,-18\n80,-16\n90,-10\n";

TEST_CASE("a pulse table is read in radians") {
  const auto rows = value_of(load_pulse(kPulse + "90e3,0,0\n100000, 2.5 ,-90\n110000,1,-179.5\n"));
  REQUIRE(rows.size() == 3);
  CHECK(rows[0].frequency_hz == 90e3);
  CHECK(rows[1].amplitude == 2.5);
  CHECK(rows[1].phase_rad == Approx(-kPi / 2));
  CHECK(rows[2].phase_rad == Approx(-179.5 * kPi / 180));
}

// Protects files as spreadsheets write them: byte order mark, CRLF, columns in another order.
TEST_CASE("a table may have marks, comments, blank lines and columns in any order") {
  const auto rows = value_of(
      load_pulse("\xEF\xBB\xBF# measured in a tank\r\n\r\n phase_deg , frequency_hz,amplitude\r\n"
                 "  # a remark\r\n0,95e3,+1\r\n\t\r\n10,105e3,1e-1"));
  REQUIRE(rows.size() == 2);
  CHECK(rows[1].frequency_hz == 105e3);
  CHECK(rows[1].amplitude == 0.1);
  CHECK(rows[1].phase_rad == Approx(10 * kPi / 180));
}

// Protects tables whose names or cells stand in quotes.
TEST_CASE("a table may have quotes") {
  const auto rows = value_of(
      load_pulse("\"frequency_hz\",\"amplitude\", \"phase_deg\"\n\"95e3\",1,0\n105e3,\" 2 \",0\n"));
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].frequency_hz == 95e3);
  CHECK(rows[1].amplitude == 2);
  check_single({{"\"f\",amplitude,phase_deg,frequency_hz\n", "t.csv:1: unknown column `f`", ""}},
               load_pulse);
}

TEST_CASE("a backscatter table is read in radians, to the quarter turn") {
  const auto table = value_of(load_backscatter(kWholeSand));
  REQUIRE(table.grazing_rad.size() == 10);
  CHECK(table.grazing_rad.front() == 0);
  CHECK(table.grazing_rad[3] == Approx(kPi / 6));
  CHECK(table.grazing_rad.back() == kPi / 2);
  CHECK(table.strength_db.front() == -40);
  CHECK(table.strength_db.back() == -10);
}

TEST_CASE("a wrong line of column names is told") {
  check_single(
      {{"", "t.csv:1:", "the file is empty; expected a first line with frequency_hz, amplitude"},
       {"# nothing\n\n", "t.csv:1:", "empty"},
       {"amplitude,phase_deg", "t.csv:1:", "column frequency_hz is missing"},
       {"\n# x\nfrequency_hz,amplitude\n1,1\n", "t.csv:3:", "phase_deg is missing"},
       {"frequency_hz,amplitude,phase_deg,phase_deg\n", "t.csv:1:", "given twice"},
       {"frequency_hz,amplitude,phase_deg,q\n", "t.csv:1:", "unknown column `q`"}},
      load_pulse);
  const auto lines = lines_of(load_pulse("frequency,amplitude,phase_deg\n1,2,3\n"));
  CHECK(lines.size() == 2);
  CHECK(testing::tells(lines, "t.csv:1:", "`frequency` (did you mean frequency_hz?)"));
  CHECK(testing::tells(lines, "t.csv:1:", "column frequency_hz is missing"));
}

TEST_CASE("wrong fields of a table are told with their line") {
  check_single(
      {{kPulse + "95e3,1,0\n105e3,1\n", "t.csv:3:", "the row has 2 fields; expected 3"},
       {kPulse + "95e3,1,0\n105e3,1,0,\n", "t.csv:3:", "the row has 4 fields"},
       {kPulse + "95e3,1,0\n105e3,,0\n", "t.csv:3:", "amplitude: the field is empty"},
       {kPulse + "95e3,1,0\n105e3,x,0\n", "t.csv:3:", "amplitude: `x` is not a finite number"},
       {kPulse + "95e3,1,0\n105e3,1 2,0\n", "t.csv:3:", "`1 2` is not a finite number"},
       {kPulse + "95e3,1,0\n105e3,inf,0\n", "t.csv:3:", "`inf` is not a finite number"},
       {kPulse + "95e3,1,0\n105e3,1,nan\n", "t.csv:3:", "phase_deg: `nan` is not a finite number"},
       {kPulse + "95e3,1,0\n105e3,1e999,0\n", "t.csv:3:", "`1e999` is not a finite number"},
       {kPulse + "95e3,1,0\n105e3,0x10,0\n", "t.csv:3:", "`0x10` is not a finite number"},
       {kPulse + "95e3,1,0\n105e3,+-1,0\n", "t.csv:3:", "`+-1` is not a finite number"},
       {kPulse + "95e3,1,0\n105e3,-1,0\n", "t.csv:3:", "amplitude: `-1` is out of range"},
       {kPulse + "-95e3,1,0\n105e3,1,0\n", "t.csv:2:", "frequency_hz: `-95e3` is out of range"}},
      load_pulse);
  check_single({{kWholeSand + "91,0\n", "t.csv:12:", "grazing_deg: `91` is out of range"},
                {kWholeSand + "90,-201\n", "t.csv:12:", "strength_db: `-201` is out of range"}},
               load_backscatter);
}

TEST_CASE("a pulse table must make a pulse in the band") {
  check_single(
      {{kPulse, "t.csv:1:", "the number of rows is 0; expected 2 or more"},
       {kPulse + "100e3,1,0\n", "t.csv:1:", "the number of rows is 1; expected 2 or more"},
       {kPulse + "100e3,1,0\n100e3,1,0\n", "t.csv:3:", "100000 is not above the 100000"},
       {kPulse + "100e3,1,0\n95e3,1,0\n", "t.csv:3:", "frequencies that increase"},
       {kPulse + "95e3,0,0\n105e3,0,0\n",
        "t.csv:1:", "all amplitudes are zero in the sonar's band"},
       {kPulse + "80e3,1,0\n95e3,0,0\n", "t.csv:1:", "all amplitudes are zero in the sonar's band"},
       {kPulse + "80e3,1,0\n120e3,1,0\n", "t.csv:1:", "there is no row in the sonar's band"},
       {kPulse + "90e3,1,0\n110e3,1,0\n", "t.csv:1:", "band of 90000 to 110000 Hz"},
       {kPulse + "95e3,1,0\n105e3,1,180\n", "t.csv:3:", "a step of 180 degrees is ambiguous"},
       {kPulse + "95e3,1,0\n100e3,1,-179\n105e3,1,-400\n", "t.csv:4:", "a step of -221 degrees"}},
      load_pulse);
}

// Protects measured phases, which come within one turn: a jump over its seam is no fault.
TEST_CASE("a phase may be wrapped or run on") {
  CHECK(load_pulse(kPulse + "95e3,1,170\n100e3,1,-170\n105e3,1,-150\n").ok());
  CHECK(load_pulse(kPulse + "95e3,1,1000\n100e3,1,1170\n105e3,1,1340\n107e3,1,1500\n").ok());
}

TEST_CASE("a backscatter table leaves no gap") {
  const std::string rest = kWholeSand.substr(kWholeSand.find("20,"));
  check_single(
      {{kSand, "t.csv:1:", "there are no rows"},
       {kSand + "5,-40\n15,0\n" + rest, "t.csv:2:", "the first row is at 5 degrees"},
       {kSand + "0,-40\n8,0\n" + rest, "t.csv:4:", "there are 12 degrees between"},
       {kWholeSand.substr(0, kWholeSand.find("90,")), "t.csv:10:", "the last row is at 80 degrees"},
       {kSand + "0,-40\n10,0\n10,0\n" + rest, "t.csv:4:", "10 is not above the 10"},
       {kSand + "0,-40\n10,0\n9,0\n19,0\n" + rest, "t.csv:4:", "angles that increase"}},
      load_backscatter);
}

TEST_CASE("all lines of a table are told at once, a hundred at most") {
  const auto lines = lines_of(load_backscatter(kSand + "1,x\n2,,\n30,-500\n20,0\n45,0\n"));
  INFO(joined_lines(lines));
  CHECK(lines.size() == 5);
  CHECK(testing::tells(lines, "t.csv:2:", "`x`"));
  CHECK(testing::tells(lines, "t.csv:3:", "3 fields"));
  CHECK(testing::tells(lines, "t.csv:4:", "`-500`"));
  CHECK(testing::tells(lines, "t.csv:6:", "25 degrees"));
  CHECK(testing::tells(lines, "t.csv:6:", "the last row is at 45 degrees"));
  std::string many = kPulse;
  for (int i = 0; i < 150; ++i) many += "x,1,1\n";
  const auto cut = lines_of(load_pulse(many));
  CHECK(cut.size() == 101);
  CHECK(cut.back() == "and 50 more");
}

TEST_CASE("a table that cannot be read is an error of reading") {
  const test::TemporaryFolder folder;
  check_fails(load_backscatter_table(folder.path() / "none.csv"), ErrorKind::io);
  check_fails(load_pulse_table(folder.path(), sonar_of_100_khz()), ErrorKind::io);
  const auto large = load_backscatter(kWholeSand + std::string(1u << 20, '#'));
  REQUIRE_FALSE(large.ok());
  CHECK(large.error().kind == ErrorKind::usage);
  CHECK(large.error().message.ends_with(":1: larger than 1 MiB"));
}

// Bytes that no one chose: half of them any, half of them from what a table is made of.
std::string random_text(std::uint64_t key, std::uint32_t index) {
  const std::string usual =
      "0123456789.,,,\n\n\n-+e#\r \xEF\xBB\xBF"
      "nan";
  std::string text = index % 4 < 2 ? kSand : "";
  const std::uint32_t size = random_words(key, 0, index, 0).v[0] % 400;
  for (std::uint32_t i = 0; i < size; ++i) {
    const Philox4 word = random_words(key, 1, index, i);
    text += index % 2 == 0 ? usual[word.v[0] % usual.size()] : static_cast<char>(word.v[1] & 0xFF);
  }
  return text;
}

// Protects the program against any file: each is read or refused, with one printable line a fault.
// 600 texts by the keyed generator, seed 1.
TEST_CASE("random bytes are refused or read, never more") {
  const std::uint64_t key = stream_key(1, Stream::noise, 0);
  const test::TemporaryFolder folder;
  int refused = 0;
  for (std::uint32_t i = 0; i < 600; ++i) {
    const auto file = folder.write("t.csv", random_text(key, i));
    const auto sand = load_backscatter_table(file);
    const auto pulse = load_pulse_table(file, sonar_of_100_khz());
    refused += (sand.ok() ? 0 : 1) + (pulse.ok() ? 0 : 1);
    for (const std::string& line : lines_of(sand)) {
      CHECK(line.starts_with("t.csv:"));
      CHECK(line.find_first_of("\r\t\x1B") == std::string::npos);
    }
  }
  CHECK(refused == 1200);  // none happens to run from 0 to 90 degrees
}

// Protects against a damaged file that is half right: 300 whole tables with one byte changed.
TEST_CASE("a table with one byte changed is refused or read as rising angles") {
  const std::uint64_t key = stream_key(2, Stream::noise, 0);
  const test::TemporaryFolder folder;
  int read = 0;
  for (std::uint32_t i = 0; i < 300; ++i) {
    std::string text = kWholeSand;
    const Philox4 word = random_words(key, 0, i, 0);
    text[word.v[0] % text.size()] = "0123456789,.-\n\r#\xFF"[word.v[1] % 17];
    const auto table = load_backscatter_table(folder.write("t.csv", text));
    if (!table.ok()) continue;
    ++read;
    CHECK(std::is_sorted(table->grazing_rad.begin(), table->grazing_rad.end()));
    CHECK(table->grazing_rad.front() == 0);
    CHECK(table->grazing_rad.back() == kPi / 2);
    CHECK(table->strength_db.size() == table->grazing_rad.size());
  }
  CHECK(read > 0);
  CHECK(read < 300);
}

}  // namespace
}  // namespace ensonify
