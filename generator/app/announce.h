// What `check` announces of a run's time, disk and memory.
//
//   announce_run
#pragma once

#include "app/commands.h"
#include "app/cost.h"
#include "app/measure.h"

namespace ensonify {

// Prints files, disk, free space, peak memory and time of a run of all sequences of the job, of
// which it makes a few pings. `start`: what the run takes before its first ping. Error kinds: those
// of measure_pings.
Status announce_run(const CheckOptions& options, const Session& session, const Cost& cost,
                    const MeasureJob& job, const RunTime& start);

}  // namespace ensonify
