// The errors that users meet, each with the exit code that the command line ends with.
// A message says what was wrong, where, and what is needed: "what: got X, need Y".
#pragma once
#include <charconv>
#include <stdexcept>
#include <string>
#include <vector>

namespace polhode {

struct Error : std::runtime_error {
  Error(int code, const std::string& message) : std::runtime_error(message), exit_code(code) {}
  int exit_code;
};
/// The command line asks for something that is not there or makes no sense.
struct UsageError : Error {
  explicit UsageError(const std::string& message) : Error(2, message) {}
};
/// A file that was read is not what it should be.
struct InputError : Error {
  explicit InputError(const std::string& message) : Error(65, message) {}
};
/// Something that is needed is not installed.
struct MissingError : Error {
  explicit MissingError(const std::string& message) : Error(69, message) {}
};
/// Results cannot be written.
struct OutputError : Error {
  explicit OutputError(const std::string& message) : Error(73, message) {}
};

/// The shortest text that reads back as the same double, for messages.
inline std::string number_text(double x) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, x).ptr;
  return std::string(text, end);
}

/// "a, b, c"
inline std::string name_list(const std::vector<std::string>& names) {
  std::string all;
  for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

}  // namespace polhode
