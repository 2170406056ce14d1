// Runs the built program as a user would: exit code, standard output and standard error.
#pragma once
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

namespace polhode {

struct CommandResult {
  int exit_code = -1;  // 128 + signal if it was killed
  std::string out, err;
};

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A folder that goes when it does.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "polhode-test-XXXXXX").string();
    if (!mkdtemp(name.data())) std::abort();
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

/// arguments  as typed in a shell, in the folder `where`
inline CommandResult polhode_command(const std::string& arguments, const std::filesystem::path& where = ".") {
  const TemporaryFolder scratch;
  const auto out = scratch.path() / "out", err = scratch.path() / "err";
  const std::string command = "cd '" + where.string() + "' && '" + std::string(POLHODE_BINARY) + "' " +
                              arguments + " >'" + out.string() + "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(command.c_str());
  CommandResult r;
  r.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  r.out = text_of(out);
  r.err = text_of(err);
  return r;
}

/// The same on a terminal, where Ctrl-C is pressed once as soon as the program has said `words` there; `out`
/// is all that the terminal showed.
inline CommandResult interrupted_command(const std::string& arguments, const std::filesystem::path& where,
                                         const std::string& words) {
  const std::string command =
      "cd '" + where.string() + "' && exec '" + std::string(POLHODE_BINARY) + "' " + arguments;
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child == 0) {
    execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    _exit(127);
  }
  CommandResult r;
  if (child < 0) return r;
  std::array<char, 4096> block;
  bool pressed = false;
  // The terminal of a program that has ended gives an error.
  for (ssize_t n; (n = read(terminal, block.data(), block.size())) > 0;) {
    r.out.append(block.data(), static_cast<std::size_t>(n));
    if (pressed || r.out.find(words) == std::string::npos) continue;
    pressed = write(terminal, "\x03", 1) == 1;
  }
  close(terminal);
  int status = 0;
  waitpid(child, &status, 0);
  r.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return r;
}

}  // namespace polhode
