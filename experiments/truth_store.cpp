// Blobs on disk. A file is written under another name and renamed, so that a reader sees a whole one or none;
// what it holds is compared with the key and a checksum, so that neither a collision nor a disk can make a
// wrong truth.
#include "experiments/truth_store.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace polhode {
namespace {

namespace fs = std::filesystem;

// Changes when the layout of the file does.
constexpr std::string_view magic = "polhode truth 1\n";
constexpr std::string_view temporary = ".writing-";
constexpr std::time_t stray_after = 3600;  // s: no writer takes that long
constexpr std::uint64_t seed = 0xcbf29ce484222325U, other_seed = 0x9e3779b97f4a7c15U;

/// FNV-1a of 64 bits.
std::uint64_t hash_of(std::string_view bytes, std::uint64_t hash) {
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

std::string bytes_of(std::uint64_t x) {
  std::string bytes(sizeof x, '\0');
  std::memcpy(bytes.data(), &x, sizeof x);
  return bytes;
}

/// Takes parts off the front of what a file holds; false from the first one that is not there.
class Reader {
 public:
  explicit Reader(std::string_view rest) : rest_(rest) {}
  bool take(std::string_view expected) {
    const bool there = rest_.starts_with(expected);
    if (there) rest_.remove_prefix(expected.size());
    return there;
  }
  bool take_sized(std::string_view& part) {
    std::uint64_t size = 0;
    if (rest_.size() < sizeof size) return false;
    std::memcpy(&size, rest_.data(), sizeof size);
    rest_.remove_prefix(sizeof size);
    if (rest_.size() < size) return false;
    part = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return true;
  }
  bool take_sized_of(std::string_view expected) {
    std::string_view part;
    return take_sized(part) && part == expected;
  }
  bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

std::string sized(std::string_view part) { return bytes_of(part.size()) + std::string(part); }

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return fd_; }

 private:
  int fd_;
};

bool write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

std::optional<std::string> read_all(int fd, std::size_t size) {
  std::string bytes(size, '\0');
  for (std::size_t at = 0; at < size;) {
    const ssize_t n = ::read(fd, bytes.data() + at, size - at);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return std::nullopt;
    at += static_cast<std::size_t>(n);
  }
  return bytes;
}

/// Each missing folder is made for the user alone.
bool make_folder(const fs::path& folder) {
  fs::path so_far;
  for (const fs::path& part : folder) {
    so_far /= part;
    if (::mkdir(so_far.c_str(), 0700) == 0 || errno == EEXIST) continue;
    struct stat there {};
    if (::stat(so_far.c_str(), &there) != 0 || !S_ISDIR(there.st_mode)) return false;
  }
  return ::access(folder.c_str(), W_OK | X_OK) == 0;
}

/// Thirty-two hexadecimal digits: what we name a blob. Other files are not ours to remove.
bool is_blob(const std::string& name) {
  return name.size() == 32 && name.find_first_not_of("0123456789abcdef") == std::string::npos;
}

/// The numbers that tell this build from others; two builds of one commit differ by their file.
std::string version_of_this_program() {
  std::string text = POLHODE_VERSION "\n" POLHODE_COMMIT "\n" POLHODE_COMPILER "\n" POLHODE_FLAGS;
  struct stat self {};
  if (::stat("/proc/self/exe", &self) == 0)
    text += fmt::format("\n{} bytes of {}.{:09}", self.st_size, self.st_mtim.tv_sec, self.st_mtim.tv_nsec);
  return text;
}

}  // namespace

TruthStore::TruthStore(fs::path folder, std::string version, Limits limits)
    : folder_(std::move(folder)), version_(std::move(version)), limits_(limits) {}

TruthStore TruthStore::of_user() {
  // A relative path means nothing there, says the XDG Base Directory Specification.
  const auto absolute = [](const char* variable) {
    const char* const value = std::getenv(variable);
    return value && fs::path(value).is_absolute() ? fs::path(value) : fs::path();
  };
  fs::path cache = absolute("XDG_CACHE_HOME");
  if (cache.empty() && !absolute("HOME").empty()) cache = absolute("HOME") / ".cache";
  if (cache.empty()) return {};
  static const std::string version = version_of_this_program();
  return {cache / "polhode" / "truths", version};
}

fs::path TruthStore::place_of(std::string_view key) const {
  return folder_ / fmt::format("{:016x}{:016x}", hash_of(key, seed), hash_of(key, other_seed));
}

std::optional<std::string> TruthStore::read(std::string_view key) const {
  if (folder_.empty()) return std::nullopt;
  // What another user has put there, or a link, is no truth.
  const Descriptor file(::open(place_of(key).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  struct stat there {};
  if (file < 0 || ::fstat(file, &there) != 0 || !S_ISREG(there.st_mode) || there.st_uid != ::geteuid())
    return std::nullopt;
  const auto size = static_cast<std::uintmax_t>(there.st_size);
  const std::size_t around = magic.size() + 4 * sizeof(std::uint64_t) + version_.size() + key.size();
  if (size < around || size - around > limits_.one) return std::nullopt;
  const auto bytes = read_all(file, static_cast<std::size_t>(size));
  if (!bytes) return std::nullopt;
  const std::string_view body = std::string_view(*bytes).substr(0, bytes->size() - sizeof(std::uint64_t));
  Reader reader(*bytes);
  std::string_view payload;
  if (!reader.take(magic) || !reader.take_sized_of(version_) || !reader.take_sized_of(key) ||
      !reader.take_sized(payload) || !reader.take(bytes_of(hash_of(body, seed))) || !reader.at_end())
    return std::nullopt;
  (void)::futimens(file, nullptr);  // used now: others go first
  return std::string(payload);
}

void TruthStore::write(std::string_view key, std::string_view payload) const {
  if (folder_.empty() || payload.size() > limits_.one || !make_folder(folder_)) return;
  std::string bytes = std::string(magic) + sized(version_) + sized(key) + sized(payload);
  bytes += bytes_of(hash_of(bytes, seed));
  std::string name = (folder_ / (std::string(temporary) + "XXXXXX")).string();
  bool whole = false;
  {
    const Descriptor file(::mkostemp(name.data(), O_CLOEXEC));  // O_EXCL, and for the user alone
    if (file < 0) return;
    whole = write_all(file, bytes);
  }
  // A link in its place is replaced, not followed.
  if (!whole || ::rename(name.c_str(), place_of(key).c_str()) != 0) ::unlink(name.c_str());
  make_room();
}

void TruthStore::make_room() const {
  struct Blob {
    fs::path place;
    timespec used;
    std::uintmax_t size;
  };
  std::vector<Blob> blobs;
  std::uintmax_t all = 0;
  std::error_code ended;
  for (fs::directory_iterator i(folder_, ended), end; !ended && i != end; i.increment(ended)) {
    const std::string name = i->path().filename().string();
    struct stat there {};
    if (::lstat(i->path().c_str(), &there) != 0 || !S_ISREG(there.st_mode)) continue;
    if (name.starts_with(temporary)) {
      // Its writer was killed. Others of now are at work.
      if (std::time(nullptr) - there.st_mtim.tv_sec > stray_after) ::unlink(i->path().c_str());
    } else if (is_blob(name)) {
      blobs.push_back({i->path(), there.st_mtim, static_cast<std::uintmax_t>(there.st_size)});
      all += blobs.back().size;
    }
  }
  std::ranges::sort(blobs, [](const Blob& a, const Blob& b) {
    return std::pair(a.used.tv_sec, a.used.tv_nsec) < std::pair(b.used.tv_sec, b.used.tv_nsec);
  });
  for (const Blob& blob : blobs) {
    if (all <= limits_.all) break;
    ::unlink(blob.place.c_str());
    all -= blob.size;
  }
}

}  // namespace polhode
