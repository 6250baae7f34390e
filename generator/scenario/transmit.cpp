// The keys of groups of beams that transmit in turn.
#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenario/sections.h"

namespace ensonify {
namespace {

// Their weights are a matrix [beams x beams].
constexpr int kMaxGroupedBeams = 1024;

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

void level_field(Fields& f, TransmitGroups& groups) {
  const Rule rule = written_if(!groups.level_db.empty(), {.has_default = false});
  const ReadWatch watch(f);
  const bool is_given =
      f.list({"level_db", "Level",
              "Source level of each group relative to source_level_db, the same in all pings; left "
              "out: 0"},
             groups.level_db, {"", "one for each group", 1}, rule,
             [&](const std::string& at, double& level_db) {
               f.number(at, level_db, from_to(-100, 40), kRequired);
             });
  if (f.writing() || !is_given || !watch.is_well()) return;
  if (std::cmp_not_equal(groups.level_db.size(), groups.count)) {
    f.fault("level_db", fmt::format("the number of values is {}, but there are {} groups; expected "
                                    "one for each group",
                                    groups.level_db.size(), groups.count));
  }
}

}  // namespace

void transmit_fields(Fields& f, SonarSpec& sonar) {
  const Rule rule = written_if(sonar.transmit.has_value(), {.has_default = false});
  if (!f.begin({"transmit", "Groups of beams",
                "Beams that transmit and listen in turn, in interleaved groups: beam j belongs to "
                "group j modulo the number of groups; left out: all beams transmit together"},
               rule)) {
    return;
  }
  TransmitSpec spec = sonar.transmit.value_or(TransmitSpec{});
  TransmitGroups& groups = spec.groups;
  const bool counted =
      f.integer({"groups", "Groups", "Number of groups; it divides the number of beams"},
                groups.count, 1, kMaxGroupedBeams, {.need = Need::required, .unless = "preset"});
  if (counted) check_count(f, groups.count, sonar.beam_count);
  order_field(f, groups);
  f.number({"interval_s", "Interval",
            "Time from one group's transmission to the next one's; 0: all at the time of the ping. "
            "All groups fit into the time between two pings"},
           groups.interval_s, from_to(0, 100));
  f.number({"width_deg", "Transmit width",
            "-3 dB width in azimuth of the lobe that a group transmits about each of its beams; "
            "left out: the receive width of the beam"},
           spec.width_deg, kAngle);
  level_field(f, groups);
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
