// SIGINT and SIGTERM: the ping in hand is finished, then the run ends.
#pragma once

namespace ensonify {

void listen_for_interrupts();
bool interrupted();

}  // namespace ensonify
