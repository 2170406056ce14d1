// What truths cost is paid once: bytes on disk that later commands go on with.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace polhode {

/// A folder of blobs, one file a key. Whatever is wrong with it (not there, not writable, full, damaged)
/// means that nothing is kept, silently: the truth is then found again. Safe with several processes at once.
class TruthStore {
 public:
  struct Limits {
    std::uintmax_t all = 200'000'000, one = 50'000'000;  // bytes
  };

  /// Keeps nothing.
  TruthStore() = default;
  /// folder    made where it is missing
  /// version   of the program: what another one has written is not read
  TruthStore(std::filesystem::path folder, std::string version, Limits limits);
  TruthStore(std::filesystem::path folder, std::string version)
      : TruthStore(std::move(folder), std::move(version), Limits()) {}

  /// Of this user and this build of the program: $XDG_CACHE_HOME/polhode/truths, else the same below
  /// $HOME/.cache; keeps nothing where neither is set.
  static TruthStore of_user();

  /// What was written under this key; nothing where any byte of it is doubtful.
  std::optional<std::string> read(std::string_view key) const;

  /// Replaces what is there, then removes what was not used for longest until all fits. A blob beyond the
  /// limit of one is not kept.
  void write(std::string_view key, std::string_view payload) const;

  /// Where the blob of a key lies.
  std::filesystem::path place_of(std::string_view key) const;

 private:
  void make_room() const;

  std::filesystem::path folder_;  // empty: none
  std::string version_;
  Limits limits_;
};

}  // namespace polhode
