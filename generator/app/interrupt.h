// SIGINT, SIGTERM and SIGHUP: the ping in hand is finished, then the run ends. Before there is one,
// nothing is written either, and the first two end the program with 130 at once.
#pragma once

namespace ensonify {

void expect_interrupts();
void listen_for_interrupts();
bool interrupted();

}  // namespace ensonify
