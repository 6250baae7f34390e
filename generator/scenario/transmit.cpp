// The keys of groups of beams that transmit by themselves.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenario/sections.h"

namespace ensonify {
namespace {

// Their weights are a matrix [beams x beams].
constexpr int kMaxGroupedBeams = 1024;
// From the carrier of the sonar to those of groups, as a share.
constexpr double kFurthestCarrier = 0.25;

std::vector<int> ascending(int count) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

std::vector<int> divisors_of(int number) {
  std::vector<int> divisors;
  for (int i = 1; i <= number; ++i) {
    if (number % i == 0) divisors.push_back(i);
  }
  return divisors;
}

void check_count(Fields& f, int groups, int beams) {
  if (beams > kMaxGroupedBeams) {
    f.fault("groups",
            fmt::format("there are {} beams; groups need at most {}", beams, kMaxGroupedBeams));
  } else if (groups > 0 && beams > 0 && beams % groups != 0) {
    f.fault("groups", fmt::format("{} groups do not divide {} beams; expected one of {}", groups,
                                  beams, fmt::join(divisors_of(beams), ", ")));
  }
}

void check_sectors(Fields& f, const TransmitGroups& groups, int beams) {
  const int sum = std::accumulate(groups.sector_beams.begin(), groups.sector_beams.end(), 0);
  if (beams > kMaxGroupedBeams) {
    f.fault("sectors",
            fmt::format("there are {} beams; sectors need at most {}", beams, kMaxGroupedBeams));
  } else if (beams > 0 && sum != beams) {
    f.fault("sectors", fmt::format("the sectors have {} beams, but the sonar has {}; expected "
                                   "numbers whose sum is {}",
                                   sum, beams, beams));
  }
}

// Groups are a number of interleaved ones or the beams of sectors.
void group_fields(Fields& f, TransmitGroups& groups, int beams, Need need) {
  constexpr std::string_view kKeys[] = {"groups", "sectors"};
  const auto which =
      f.only_key(kKeys, groups.sector_beams.empty() ? 0 : 1,
                 "groups, their number, or sectors, the beams of each", Need::optional);
  if (!f.writing() && need == Need::required && f.peek(kKeys[0]) == nullptr &&
      f.peek(kKeys[1]) == nullptr) {
    f.fault(kKeys[0], "missing; expected groups, their number, or sectors, the beams of each");
  }
  if (which == 0u &&
      f.integer({kKeys[0], "Groups",
                 "Number of interleaved groups: beam j belongs to group j modulo this; it divides "
                 "the number of beams; in place of sectors"},
                groups.count, 1, kMaxGroupedBeams, {.has_default = false})) {
    check_count(f, groups.count, beams);
  }
  const ReadWatch watch(f);
  if (which != 1u ||
      !f.list({kKeys[1], "Sectors",
               "Number of beams of each sector, a group of neighboring beams, from starboard on; "
               "their sum is the number of beams; in place of groups"},
              groups.sector_beams, {"", "the beams of each sector", 1}, {.has_default = false},
              [&](const std::string& at, int& count) {
                f.integer(at, count, 1, kMaxGroupedBeams, kRequired);
              }) ||
      !watch.is_well()) {
    return;
  }
  groups.count = static_cast<int>(groups.sector_beams.size());
  check_sectors(f, groups, beams);
}

// A list with a number for each group.
void group_list(Fields& f, const KeyText& key, std::vector<double>& values, int groups,
                const NumberRange& range) {
  const ReadWatch watch(f);
  const bool is_given =
      f.list(key, values, {"", "one for each group", 1},
             written_if(!values.empty(), {.has_default = false}),
             [&](const std::string& at, double& value) { f.number(at, value, range, kRequired); });
  if (f.writing() || !is_given || !watch.is_well()) return;
  if (std::cmp_not_equal(values.size(), groups)) {
    f.fault(key.key, fmt::format("the number of values is {}, but there are {} groups; expected "
                                 "one for each group",
                                 values.size(), groups));
  }
}

void frequency_field(Fields& f, TransmitGroups& groups, const SonarSpec& sonar) {
  const ReadWatch watch(f);
  group_list(f,
             {"frequency_hz", "Carrier frequencies",
              "Carrier of each group, within a quarter of sonar.frequency_hz; left out: "
              "sonar.frequency_hz"},
             groups.frequency_hz, groups.count, above_up_to(0, 1e9));
  if (f.writing() || !watch.is_well() || !(sonar.frequency_hz > 0)) return;
  for (const double carrier_hz : groups.frequency_hz) {
    const double share = std::abs(carrier_hz / sonar.frequency_hz - 1);
    if (share <= kFurthestCarrier) continue;
    f.fault("frequency_hz",
            fmt::format("{:g} is more than a quarter away from the {:g} of sonar.frequency_hz, "
                        "at which materials and objects scatter; expected {:g} to {:g}",
                        carrier_hz, sonar.frequency_hz, (1 - kFurthestCarrier) * sonar.frequency_hz,
                        (1 + kFurthestCarrier) * sonar.frequency_hz));
    return;
  }
}

void order_field(Fields& f, TransmitGroups& groups) {
  const Rule rule =
      written_if(f.writing() && groups.order != ascending(groups.count), {.has_default = false});
  const ReadWatch watch(f);
  if (!f.writing()) groups.order.clear();
  const bool is_given = f.list(
      {"order", "Order", "The groups in the order in which they fire; left out: 0, 1, 2 and so on"},
      groups.order, {"", "every group once", 1}, rule, [&](const std::string& at, int& group) {
        f.integer(at, group, 0, kMaxGroupedBeams - 1, kRequired);
      });
  if (f.writing()) return;
  std::vector<int> sorted = groups.order;
  std::ranges::sort(sorted);
  if (is_given && watch.is_well() && sorted != ascending(groups.count)) {
    f.fault("order", fmt::format("this is no order of {0} groups; expected each number from 0 to "
                                 "{1} once",
                                 groups.count, groups.count - 1));
  }
  if (!is_given) groups.order = ascending(groups.count);
}

}  // namespace

void transmit_fields(Fields& f, SonarSpec& sonar, Need need) {
  const Rule rule = written_if(sonar.transmit.has_value(), {.has_default = false});
  if (!f.begin({"transmit", "Groups of beams",
                "Groups of beams that transmit and listen by themselves; left out: all beams "
                "transmit together"},
               rule)) {
    return;
  }
  TransmitSpec spec = sonar.transmit.value_or(TransmitSpec{});
  TransmitGroups& groups = spec.groups;
  group_fields(f, groups, sonar.beam_count, need);
  order_field(f, groups);
  f.number({"interval_s", "Interval",
            "Time from one group's transmission to the next one's; 0: all at the time of the ping. "
            "All groups fit into the time between two pings; left out: the travel time to "
            "sonar.range_max_m and back, plus turnaround_s"},
           spec.interval_s, from_to(0, 100));
  f.number({"turnaround_s", "Turnaround",
            "Time from the last echo of a group to the transmission of the next one, where "
            "interval_s is left out"},
           spec.turnaround_s, from_to(0, 100),
           written_if(!spec.interval_s && spec.turnaround_s > 0));
  frequency_field(f, groups, sonar);
  f.number({"width_deg", "Transmit width",
            "-3 dB width in azimuth of the lobe that a group transmits about each of its beams; "
            "left out: the receive width of the beam"},
           spec.width_deg, kAngle);
  group_list(f,
             {"level_db", "Level",
              "Source level of each group relative to source_level_db, the same in all pings; left "
              "out: 0"},
             groups.level_db, groups.count, from_to(-100, 40));
  f.number({"level_error_db", "Level error",
            "Standard deviation of the source level of a group, sampled anew in each ping"},
           groups.level_error_db, from_to(0, 40));
  f.end();
  sonar.transmit = std::move(spec);
}

void check_transmit(Faults& faults, const Value& root, const Scenario& scenario) {
  if (!scenario.sonar.transmit || !scenario.sonar.array) return;
  const Value sonar = child_or_empty(root, "sonar");
  const Value transmit = child_or_empty(sonar, "transmit");
  add_fault(faults, transmit.place, path_of(sonar, "transmit"),
            "the elements of an array hear all groups alike; expected sonar.receiver.mode: beams");
}

}  // namespace ensonify
