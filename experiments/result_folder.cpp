// Atomic output.
#include "experiments/result_folder.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include <unistd.h>

#include "models/errors.hpp"

namespace polhode {
namespace fs = std::filesystem;
namespace {

void write_whole(const fs::path& file, const std::string& text) {
  errno = 0;
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw OutputError("cannot write '" + file.string() + "': " + std::strerror(errno ? errno : EIO));
}

/// A folder of ours carries a run.json that names the program.
bool made_by_us(const fs::path& folder) {
  std::ifstream in(folder / "run.json");
  std::string head(4096, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head.find("\"program\": \"polhode\"") != std::string::npos;
}

}  // namespace

ResultFolder::ResultFolder(const fs::path& folder, bool force) {
  std::error_code failed;
  final_ = fs::absolute(folder, failed).lexically_normal();
  if (final_.filename().empty()) final_ = final_.parent_path();
  if (final_ == final_.root_path() || final_.filename() == "." || final_.filename() == "..")
    throw OutputError("'" + folder.string() + "' cannot be a result folder: give it a name of its own");
  if (fs::exists(final_, failed)) {
    if (!fs::is_directory(final_, failed))
      throw OutputError("'" + folder.string() + "' is a file; results of an experiment need a folder");
    if (!fs::is_empty(final_, failed) && !made_by_us(final_) && !force)
      throw OutputError("'" + folder.string() +
                        "' is not empty and was not made by polhode; choose another folder or say --force");
    if (access(final_.c_str(), W_OK) != 0)
      throw OutputError("cannot write to '" + folder.string() + "': " + std::strerror(errno));
  }
  fs::create_directories(final_.parent_path(), failed);
  std::string name = (final_.parent_path() / ("." + final_.filename().string() + ".XXXXXX")).string();
  if (!mkdtemp(name.data()))
    throw OutputError("cannot make a folder in '" + final_.parent_path().string() +
                      "': " + std::strerror(errno));
  draft_ = name;
  fs::permissions(draft_, fs::perms(0755), failed);
}

ResultFolder::~ResultFolder() {
  std::error_code ignored;
  if (!draft_.empty()) fs::remove_all(draft_, ignored);
}

void ResultFolder::write(const std::string& name, const std::string& text) const {
  write_whole(draft_ / name, text);
}

void ResultFolder::commit() {
  std::error_code failed;
  // A folder cannot be renamed over a full one: the old one steps aside first and is removed last.
  fs::path old;
  if (fs::exists(final_, failed)) {
    old = draft_;
    old += ".old";
    fs::rename(final_, old, failed);
    if (failed) throw OutputError("cannot replace '" + final_.string() + "': " + failed.message());
  }
  fs::rename(draft_, final_, failed);
  if (failed) {
    std::error_code ignored;
    if (!old.empty()) fs::rename(old, final_, ignored);
    throw OutputError("cannot put results at '" + final_.string() + "': " + failed.message());
  }
  draft_.clear();
  if (!old.empty()) fs::remove_all(old, failed);
}

void write_file(const fs::path& file, const std::string& text) {
  std::error_code failed;
  if (fs::is_directory(file, failed))
    throw OutputError("'" + file.string() + "' is a folder; a file name is needed");
  if (fs::exists(file, failed) && !fs::is_regular_file(file, failed)) {  // /dev/null and its kind
    write_whole(file, text);
    return;
  }
  fs::path draft = file;
  draft += "." + std::to_string(getpid()) + ".part";
  try {
    write_whole(draft, text);
  } catch (const OutputError&) {
    fs::remove(draft, failed);
    throw;
  }
  fs::rename(draft, file, failed);
  if (failed) {
    std::error_code ignored;
    fs::remove(draft, ignored);
    throw OutputError("cannot write '" + file.string() + "': " + failed.message());
  }
}

void write_stdout(const std::string& text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
    throw OutputError(std::string("cannot write to standard output: ") + std::strerror(errno ? errno : EIO));
}

}  // namespace polhode
