// Runs gnuplot on a script: posix_spawn with an argument list, so that no name needs quoting for a shell.
#include "reports/gnuplot.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace polhode::report {
namespace {

// The line that names the error is the last one that is neither blank nor only a caret under the culprit.
std::string last_words(const std::string& text) {
  std::string_view rest = text;
  while (!rest.empty()) {
    const auto cut = rest.find_last_of('\n');
    const std::string_view line = cut == std::string_view::npos ? rest : rest.substr(cut + 1);
    if (line.find_first_not_of(" ^\t\r") != std::string_view::npos) return std::string(line);
    if (cut == std::string_view::npos) break;
    rest = rest.substr(0, cut);
  }
  return {};
}

}  // namespace

GnuplotRun run_gnuplot(const std::filesystem::path& folder, const std::filesystem::path& script,
                       std::chrono::milliseconds timeout) {
  using Clock = std::chrono::steady_clock;
  using End = GnuplotRun::End;
  std::array<int, 2> pipe_ends{};
  if (pipe2(pipe_ends.data(), O_CLOEXEC) != 0) return {End::failed, std::strerror(errno)};

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], 2);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  // `-d` leaves the settings of whoever runs this out of the figures.
  std::string name = "gnuplot", defaults = "-d", file = script.string();
  std::array<char*, 4> arguments = {name.data(), defaults.data(), file.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(pipe_ends[1]);
  if (error != 0) {
    close(pipe_ends[0]);
    return {error == ENOENT ? End::not_installed : End::failed, std::strerror(error)};
  }

  std::string said;
  bool late = false;
  const auto deadline = Clock::now() + timeout;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) {
      late = true;
      break;
    }
    pollfd watch{pipe_ends[0], POLLIN, 0};
    const int ready = poll(&watch, 1, static_cast<int>(left));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) continue;  // the deadline check above decides
    std::array<char, 4096> buffer{};
    const ssize_t n = read(pipe_ends[0], buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;  // the child closed its end
    if (said.size() < 65536) said.append(buffer.data(), static_cast<std::size_t>(n));
  }
  close(pipe_ends[0]);
  if (late) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (late) return {End::timed_out, "stopped after its time was up"};
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {End::drawn, {}};
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) return {End::not_installed, last_words(said)};
  return {End::failed, last_words(said)};
}

}  // namespace polhode::report
