// The interrupt flag.
#include "experiments/interrupt.hpp"

#include <csignal>

#include <unistd.h>

namespace polhode {
namespace {

volatile std::sig_atomic_t raised = 0;

void on_signal(int) {
  if (raised) _exit(130);
  raised = 1;
}

}  // namespace

void watch_interrupts() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

bool interrupted() { return raised != 0; }

}  // namespace polhode
