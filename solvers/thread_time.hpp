// The CPU clock of the calling thread: on a shared machine it repeats where the wall clock does not.
#pragma once
#include <time.h>

namespace polhode {

/// Seconds that this thread has computed.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace polhode
