// Navigation sensors of a session.
//
//   write_sensor_tables   for dataset/finish.h
//   check_navigation  navigation_warnings
//   navigation_bytes      of the tables of a sequence, about
#pragma once

#include <string>
#include <vector>

#include "core/error.h"
#include "dataset/finish.h"
#include "ping/session.h"
#include "trace/tracer.h"

namespace ensonify {

inline constexpr double kMostSensorRows = 2e8;

// Rows from the time of the first ping of `info` to that of its last one, of an instrument of a rig
// to the next one or the end of the run; a row is the same in any range of pings. Empty without
// info.navigation. Session, tracer and info must outlive it.
WriteTables write_sensor_tables(const Session& session, const Tracer& tracer,
                                const SequenceInfo& info);

// Error (usage): a sensor has more than kMostSensorRows samples in all pings.
Status check_navigation(const Session& session);

// Sensors without a sample between the first ping and the last one; a DVL or altimeter without a
// surface within range, and a GPS below the surface, at the first, the middle and the last ping.
std::vector<std::string> navigation_warnings(const Session& session, const Tracer& tracer);

double navigation_bytes(const Session& session);

}  // namespace ensonify
