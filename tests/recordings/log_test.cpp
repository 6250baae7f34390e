// Protects the parsers of logs against what the layouts leave open: frames without counts, streams
// read piece by piece, and the headers that exporters write.
#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

#include "core/units.h"
#include "recordings/aris.h"
#include "recordings/oculus.h"
#include "recordings/open_log.h"
#include "recordings/sequences.h"
#include "results.h"

namespace ensonify {
namespace {

ArisHead aris_head(std::uint32_t frame) {
  ArisHead head;
  head.frame = frame;
  head.time_us = 1'000'000 + 50'000 * frame;
  head.ping_mode = 1;
  head.samples = 3;
  head.sample_period_us = 8;
  head.sample_start_us = 2000;
  head.sound_speed_m_s = 1450;
  head.system = kAris1200;
  return head;
}

std::string aris_log(int frames) {
  std::string log = aris_file_header(aris_head(0), static_cast<std::uint32_t>(frames));
  for (int i = 0; i < frames; ++i) {
    log += aris_frame_header(aris_head(static_cast<std::uint32_t>(i)));
    log += std::string(3 * 48, static_cast<char>(i));
  }
  return log;
}

// The largest piece that a reader asks for.
std::uint64_t largest_piece(const std::string& bytes) {
  LogBytes log = memory_log("log", bytes);
  std::uint64_t largest = 0;
  const auto whole = log.read;
  log.read = [&](std::uint64_t offset, std::uint64_t count) {
    largest = std::max(largest, count);
    return whole(offset, count);
  };
  const auto format = value_of(log_format_of(log));
  const auto end = value_of(read_log(format, log,
                                     {[](std::uint64_t) { return true; },
                                      [](std::uint64_t, const LogFrame&) { return Status(); }}));
  return largest;
}

OculusPing oculus_ping() {
  OculusPing ping;
  ping.frequency_hz = 1.2e6;
  ping.sound_speed_m_s = 1500;
  ping.range_step_m = 0.02;
  ping.samples = 2;
  ping.beams = 3;
  ping.bearing_cdeg = {-2000, 100, 2500};
  return ping;
}

LogFrame only_frame(const std::string& bytes) {
  const LogBytes log = memory_log("log", bytes);
  const auto format = value_of(log_format_of(log));
  std::vector<LogFrame> frames;
  const auto end = value_of(read_log(format, log,
                                     {[](std::uint64_t) { return true; },
                                      [&](std::uint64_t, const LogFrame& frame) -> Status {
                                        frames.push_back(frame);
                                        return {};
                                      }}));
  REQUIRE(frames.size() == 1);
  return frames.front();
}

}  // namespace

TEST_CASE("memory does not grow with the frames of a log") {
  CHECK(largest_piece(aris_log(2)) == largest_piece(aris_log(50)));
}

TEST_CASE("counts are read of the wanted frames only") {
  const std::string bytes = aris_log(4);
  std::vector<std::size_t> sizes;
  const auto end = value_of(read_log(LogFormat::aris, memory_log("log", bytes),
                                     {[](std::uint64_t frame) { return frame == 2; },
                                      [&](std::uint64_t, const LogFrame& frame) -> Status {
                                        sizes.push_back(frame.counts.size());
                                        return {};
                                      }}));
  CHECK(sizes == std::vector<std::size_t>{0, 0, 3 * 48, 0});
}

TEST_CASE("reading a log ends with the first error of its user") {
  const std::string bytes = aris_log(4);
  std::uint64_t used = 0;
  const auto end = read_log(LogFormat::aris, memory_log("log", bytes),
                            {[](std::uint64_t) { return false; },
                             [&](std::uint64_t frame, const LogFrame&) -> Status {
                               ++used;
                               if (frame == 1) return Error{ErrorKind::io, "full"};
                               return {};
                             }});
  REQUIRE_FALSE(end);
  CHECK(end.error().message == "full");
  CHECK(used == 2);
}

TEST_CASE("beams of every lens and mode have a table that rises, or none") {
  for (const std::uint32_t system : {kAris1200, kAris1800, kAris3000}) {
    for (const bool lens : {false, true}) {
      for (const int beams : {48, 64, 96, 128}) {
        const auto table = aris_azimuths_deg(system, beams, lens);
        if (table.empty()) continue;
        CHECK(table.size() == static_cast<std::size_t>(beams));
        for (std::size_t i = 1; i < table.size(); ++i) CHECK(table[i - 1] < table[i]);
        CHECK(std::abs(table.front() + table.back()) < 0.2);
      }
    }
  }
  CHECK(aris_azimuths_deg(kAris1200, 96, false).empty());
  CHECK(aris_azimuths_deg(kAris3000, 128, true).empty());
}

TEST_CASE("an Oculus ping is written as it is read") {
  OculusPing ping = oculus_ping();
  ping.gamma = 127 / 255.0;
  ping.bytes_per_count = 2;
  ping.attitude = {10, -5, 3};
  const std::string counts("\1\0\2\0\3\0\4\0\5\0\6\0", 12);
  const LogFrame frame =
      only_frame(oculus_file_header(7) + oculus_ping_item(ping, 9, 1234.5, counts, {4, 16}));
  CHECK(frame.counts == std::string("\3\0\2\0\1\0\6\0\5\0\4\0", 12));  // starboard first
  CHECK(frame.row_gain == std::vector<float>{4, 16});
  CHECK(frame.time_us == 1'234'500'000);
  CHECK(frame.settings.gamma == ping.gamma);
  CHECK(frame.settings.azimuth_rad ==
        std::vector<double>{radians(-25.0), radians(-1.0), radians(20.0)});
  REQUIRE(frame.attitude);
  CHECK(frame.attitude->pitch_deg == -5);
}

TEST_CASE("levels follow from counts by the formula of the recorder") {
  OculusPing ping = oculus_ping();
  const LogFrame frame = only_frame(
      oculus_file_header(0) + oculus_ping_item(ping, 0, 0, std::string("\xff\x7f\1\0\2\3", 6), {}));
  const std::vector<float> level_db = log_levels_db(frame);
  CHECK(level_db[0] == Approx(20 * std::log10(1 / 255.0)).margin(0.04));
  CHECK(level_db[1] == Approx(20 * std::log10(127 / 255.0)).margin(0.01));
  CHECK(level_db[2] == 0);
  CHECK(level_db[5] == kNoEnergyDb);
}

// Protects memory: a log whose frames all differ makes a sequence of each.
TEST_CASE("a log of too many sequences is refused") {
  const auto survey_of = [](std::uint64_t frames) {
    Log log;
    log.name = "log";
    log.read = [frames](const LogFrames& use) -> Result<LogEnd> {
      LogFrame frame;
      frame.settings = only_frame(aris_log(1)).settings;
      for (std::uint64_t i = 0; i < frames; ++i) {
        frame.serial = i + 1;
        if (i == 0) frame.counts.assign(3 * 48, 'x');
        if (const Status used = use.use(i, frame); !used) return used.error();
      }
      return LogEnd{frames, ""};
    };
    return survey_log(log, std::nullopt, {});
  };
  const auto most = value_of(survey_of(100'000));
  CHECK(most.sequences.size() == 100'000);
  check_fails(survey_of(100'001), {"frame 100000: more than 100000 sequences"});
}

// Protects memory: a chunk of a few bytes can hold a name of many megabytes.
TEST_CASE("a topic with a long name is refused") {
  const auto little = [](std::uint64_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i));
    return text;
  };
  const auto text = [&](const std::string& of) { return little(of.size(), 4) + of; };
  const auto record = [&](char opcode, const std::string& content) {
    return opcode + little(content.size(), 8) + content;
  };
  const auto error_of = [&](std::size_t length) {
    const std::string bytes =
        "\x89MCAP0\r\n" + record(3, little(1, 2) + text("marine_acoustic_msgs/msg/RawSonarImage")) +
        record(4, little(7, 2) + little(1, 2) + text(std::string(length, 'a')) + text("cdr")) +
        record(15, little(0, 4));
    const auto end = read_log(LogFormat::mcap, memory_log("log", bytes),
                              {[](std::uint64_t) { return true; },
                               [](std::uint64_t, const LogFrame&) { return Status(); }});
    REQUIRE_FALSE(end);
    return end.error().message;
  };
  CHECK(contains(error_of(1024), "no message of type"));
  CHECK(contains(error_of(1025), "a topic whose name has 1025 bytes"));
}

TEST_CASE("a sequence ends where ranges differ by more than half a sample") {
  LogSettings a;
  a.beams = 2;
  a.samples = 1000;
  a.range_step_m = 0.01;
  a.azimuth_rad = {-0.1, 0.1};
  LogSettings b = a;
  b.range_step_m *= 1 + 0.4 / 1000;
  CHECK(same_sequence(a, b));
  b.range_step_m = a.range_step_m * (1 + 0.6 / 1000);
  CHECK_FALSE(same_sequence(a, b));
  b = a;
  b.azimuth_rad[1] += 1e-4;
  CHECK_FALSE(same_sequence(a, b));
}

}  // namespace ensonify
