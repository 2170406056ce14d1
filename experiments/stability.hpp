// The parts of the question of stability, one file and one table each.
#pragma once
#include "experiments/question.hpp"

namespace polhode {

/// stability.csv: steps that are stable and steps that are right, on scenes with a dial (stability.cpp).
Table dial_table(const Plan& plan);

/// stability_map.csv: growth of the energy of a free body over step size and shape (gyroscopic_map.cpp).
Table gyroscopic_map(const Plan& plan);

/// extremes.csv: a verdict for every solver on inputs at the edge of what can be computed (extremes.cpp).
Table extremes(const Plan& plan);

/// tolerance.csv and tolerance_verdict.csv: does the error follow the tolerance? (tolerances.cpp)
std::vector<Table> tolerances(const Plan& plan);

}  // namespace polhode
