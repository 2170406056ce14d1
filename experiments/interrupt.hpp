// Ctrl-C: a flag that loops over runs look at. The current run ends, what there is is kept.
#pragma once

namespace polhode {

/// Makes SIGINT and SIGTERM raise the flag; a second one ends the program at once.
void watch_interrupts();
bool interrupted();

}  // namespace polhode
