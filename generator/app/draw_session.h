// Samples a sequence that can be built: objects that are placed at random may find no room, and
// then the whole sequence is sampled again.
//
//   kMostRedraws  DrawSteps  drawn_session
#pragma once

#include <cstdint>
#include <functional>

#include "app/session.h"
#include "core/error.h"
#include "core/random.h"
#include "scenario/scenario.h"

namespace ensonify {

inline constexpr std::uint32_t kMostRedraws = 100;

struct DrawSteps {
  std::function<Result<Scenario>(SequenceDraw)> scenario;
  // prepare_session, or a replacement for it.
  std::function<Result<Session>(Scenario, std::uint32_t sequence)> session;
};

// The session of the first sample for which both steps succeed, with its `placement`. Errors: those
// of the steps; ErrorKind::redraw becomes usage after kMostRedraws further samples.
Result<Session> drawn_session(const DrawSteps& steps, std::uint32_t sequence);

}  // namespace ensonify
