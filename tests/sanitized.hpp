#pragma once
// Under the sanitizers everything takes ten times as long: a test may look at fewer examples of one kind
// there.

namespace polhode {

#ifdef POLHODE_SANITIZED
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

}  // namespace polhode
