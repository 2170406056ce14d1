// Owners of SUNDIALS objects: each is freed once, in the reverse order of making, whatever throws in between.
//
// One source serves SUNDIALS 6.4 and 7: they differ in how a context is made and in how errors are silenced.
#pragma once
#include <memory>
#include <new>
#include <type_traits>

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

namespace polhode::sundials {

struct Deleter {
  void operator()(std::remove_pointer_t<SUNContext>* context) const { SUNContext_Free(&context); }
  void operator()(std::remove_pointer_t<N_Vector>* v) const { N_VDestroy(v); }
  void operator()(std::remove_pointer_t<SUNMatrix>* m) const { SUNMatDestroy(m); }
  void operator()(std::remove_pointer_t<SUNLinearSolver>* s) const { SUNLinSolFree(s); }
  void operator()(std::remove_pointer_t<SUNNonlinearSolver>* s) const { SUNNonlinSolFree(s); }
};
struct CvodeDeleter {
  void operator()(void* memory) const { CVodeFree(&memory); }
};

/// Owner of an object that SUNDIALS hands out by a pointer type of its own.
template <class Pointer>
using Owned = std::unique_ptr<std::remove_pointer_t<Pointer>, Deleter>;
using OwnedCvode = std::unique_ptr<void, CvodeDeleter>;

/// The object, or std::bad_alloc: creation fails for want of memory alone.
template <class Owner, class Pointer>
Owner owned(Pointer made) {
  if (made == nullptr) throw std::bad_alloc();
  return Owner(made);
}

/// A context without MPI. From version 7 on it also carries the error handlers; none is wanted, because a
/// failure is reported by the outcome of the run.
inline Owned<SUNContext> make_context() {
  SUNContext context = nullptr;
#if SUNDIALS_VERSION_MAJOR < 7
  SUNContext_Create(nullptr, &context);
#else
  SUNContext_Create(SUN_COMM_NULL, &context);
  SUNContext_ClearErrHandlers(context);
#endif
  return owned<Owned<SUNContext>>(context);
}

/// Makes a CVODE object print nothing; below version 7 each object has its own handler.
inline void silence([[maybe_unused]] void* cvode) {
#if SUNDIALS_VERSION_MAJOR < 7
  CVodeSetErrHandlerFn(
      cvode, [](int, const char*, const char*, char*, void*) {}, nullptr);
#endif
}

}  // namespace polhode::sundials
