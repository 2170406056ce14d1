// Results on disk: a folder or a file, replaced whole or not at all.
#pragma once
#include <filesystem>
#include <string>

namespace polhode {

/// A folder being filled beside its final place, moved there by `commit`. Destroyed before that, it leaves
/// nothing.
class ResultFolder {
 public:
  /// Throws OutputError if the place cannot be written, or is a non-empty folder that polhode did not make
  /// and `force` is false. Nothing at the final place is touched yet.
  ResultFolder(const std::filesystem::path& folder, bool force);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  const std::filesystem::path& draft() const { return draft_; }
  void write(const std::string& name, const std::string& text) const;
  void commit();

 private:
  std::filesystem::path final_, draft_;
};

/// Writes a file beside its final place and moves it there. A folder in its place, or a missing parent,
/// throws OutputError.
void write_file(const std::filesystem::path& file, const std::string& text);

/// Writes to stdout; throws OutputError if that fails (a closed pipe, a full disk).
void write_stdout(const std::string& text);

}  // namespace polhode
