// The interrupt flag.
#include "experiments/interrupt.hpp"

#include <csignal>
#include <initializer_list>

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
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;  // a write of results goes on
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM}) sigaddset(&action.sa_mask, signal);
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

bool interrupted() { return raised != 0; }

}  // namespace polhode
