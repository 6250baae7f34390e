// The draw of a sequence that can be built: objects that are placed at random may find no room, and
// the whole sequence is drawn again then.
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
  // prepare_session, or what takes its place.
  std::function<Result<Session>(Scenario, std::uint32_t sequence)> session;
};

// The session of the first draw that both steps take, with its `placement`. Errors: those of the
// steps; ErrorKind::redraw is never among them: after kMostRedraws draws more, it is usage.
Result<Session> drawn_session(const DrawSteps& steps, std::uint32_t sequence);

}  // namespace ensonify
