// Announcements of `check` about the time, disk space and memory of a run.
//
//   announce_run
#pragma once

#include "app/commands.h"
#include "app/cost.h"
#include "app/measure.h"

namespace ensonify {

// Prints files, disk space, free space, peak memory and time of a run of all sequences of the job,
// measured on a few of its pings. `start`: the time before the first ping. Error kinds: those of
// measure_pings.
Status announce_run(const CheckOptions& options, const Session& session, const Cost& cost,
                    const MeasureJob& job, const RunTime& start);

}  // namespace ensonify
