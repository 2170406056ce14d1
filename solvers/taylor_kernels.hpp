// Which of the loops of solvers/taylor_kernel.cpp this machine can run, and for which scenes they are.
#pragma once
#include <optional>
#include <vector>

#include "models/scene.hpp"
#include "solvers/taylor_kernel.hpp"

namespace polhode {

/// In increasing order of speed; the first runs everywhere.
std::vector<const TaylorKernel*> taylor_kernels();

/// The scene's body, if it is free or turned by gravity about a pivot alone; tolerances and order are left.
std::optional<TaylorBody> taylor_body(const Scene& scene);

}  // namespace polhode
