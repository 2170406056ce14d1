// Typed access to a scene file: every value that is asked for is checked, and every complaint says file,
// line, key, what was found and what is needed. What a scene means is decided in models/scene.cpp; here is
// only how to read.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "models/attitude.hpp"
#include "models/scene.hpp"

namespace polhode {

enum class Sign { any, positive, not_negative };

/// One table of the file. Copies are cheap; the document must outlive them.
class SceneTable {
 public:
  /// path: how messages name the table, "body" or "load[2]" (from 0); "" for the top level.
  SceneTable(const toml::table& table, std::string file, std::string path, std::size_t line)
      : table_(&table), file_(std::move(file)), path_(std::move(path)), line_(line) {}

  bool has(const std::string& key) const { return table_->contains(key); }
  /// Refuses every key that is not in the list, and names the nearest one that is.
  void allow(const std::vector<std::string>& keys) const;
  /// The one key of several that is there, "" if none is; two of them are an error.
  std::string one_of(const std::vector<std::string>& keys) const;

  /// Each reads a key that must be there; the message for a missing one says what is needed.
  double number(const std::string& key, Sign sign) const;
  Vec3 vec3(const std::string& key, Sign sign = Sign::any) const;
  std::vector<double> numbers(const std::string& key, const std::vector<std::size_t>& lengths,
                              Sign sign) const;
  Quaternion quaternion(const std::string& key) const;
  std::int64_t integer(const std::string& key, std::int64_t low, std::int64_t high) const;
  std::string text(const std::string& key) const;
  std::string choice(const std::string& key, const std::vector<std::string>& choices) const;
  bool flag(const std::string& key) const;
  SceneTable table(const std::string& key) const;
  SceneTable table_or_empty(const std::string& key) const;
  std::vector<SceneTable> tables(const std::string& key) const;

  /// "FILE:LINE: KEY: got GOT, need NEED"; without `got`, what the file has there.
  [[noreturn]] void fail(const std::string& key, const std::string& need) const;
  [[noreturn]] void fail(const std::string& key, const std::string& got, const std::string& need) const;

 private:
  const toml::node* find(const std::string& key, const std::string& need) const;
  double real(const toml::node& node, const std::string& key, const std::string& need, Sign sign) const;
  std::size_t line_of(const std::string& key) const;
  std::string name_of(const std::string& key) const;

  const toml::table* table_;
  std::string file_, path_;
  std::size_t line_;
};

/// Sets the numbers of a document that a dial turns (models/scene.hpp); `file` is how messages name it.
/// Throws InputError if one of its places is no number or vector in the document.
void turn_dial(toml::table& document, const std::string& file, const Dial& dial, double value);

/// Reads and parses a file of at most 1 MB. Throws InputError if it is missing, not a regular file (a pipe is
/// not even opened), too large, or not TOML in UTF-8.
toml::table parse_scene_file(const std::filesystem::path& file);

}  // namespace polhode
