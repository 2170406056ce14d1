// What the command line can be told to do. Each verb takes the options and returns the exit code; errors are
// thrown.
#pragma once
#include <vector>

#include "experiments/options.hpp"

namespace polhode {

struct Verb {
  const char *id, *operands, *summary;  // operands: what it works on, as in a usage line
  int (*run)(const Options&);
};

/// Every verb, in the order of the help: study, the questions, then the rest.
const std::vector<Verb>& all_verbs();

}  // namespace polhode
