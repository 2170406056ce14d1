// `completion`: the completion script for bash, from the lists of verbs, options, scenes and solvers.
#include <fmt/format.h>

#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "experiments/verbs.hpp"
#include "models/errors.hpp"

namespace polhode {
namespace {

std::string words_of(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& w : words) all += (all.empty() ? "" : " ") + w;
  return all;
}

/// What completes the operands of a verb: words, and the kind of files beside them.
std::string operand_action(std::string_view operands) {
  if (operands.find('|') != std::string_view::npos) return "words " + words_of(split(operands, '|'));
  std::string actions;
  const auto has = [operands](const char* word) { return operands.find(word) != std::string_view::npos; };
  if (has("SCENE")) actions += "words \"$scenes\"; ";
  if (has("SCENE") || has("TRAJECTORY")) return actions + "files";
  return has("FOLDER") || has("BEFORE") ? actions + "folders" : actions + ":";
}

std::string bash_script() {
  std::vector<std::string> verbs, solvers;
  for (const Verb& v : all_verbs()) verbs.emplace_back(v.id);
  for (const Method* m : all_methods()) solvers.emplace_back(m->id);
  std::string out = fmt::format(R"(# bash completion for polhode; made by `polhode completion bash`.
_polhode() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  local scenes="{}"
  local solvers="{}"
  COMPREPLY=()
  words() {{ mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -W "$*" -- "$current"); }}
  files() {{ mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -f -- "$current"); }}
  folders() {{ mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -d -- "$current"); }}
  if ((COMP_CWORD == 1)); then
    words {} --help --version
    return
  fi
  case $before in
    --solver) words "$solvers"; return ;;
    -o | --output) files; return ;;
)",
                                words_of(builtin_scene_ids()), words_of(solvers), words_of(verbs));
  std::string others;
  for (const OptionInfo& o : all_options()) {
    if (!o.choices().empty())
      out += fmt::format("    {}) words {}; return ;;\n", o.long_name(), words_of(o.choices()));
    else if (!o.takes.empty() && o.long_name() != "--solver" && o.long_name() != "--output")
      others += (others.empty() ? "" : " | ") + std::string(o.long_name());
  }
  out += fmt::format("    {}) return ;;\n  esac\n  case ${{COMP_WORDS[1]}} in\n", others);
  for (const Verb& v : all_verbs()) {
    std::string options = "--help";
    for (const OptionInfo& o : all_options())
      if (o.followed_by(v.id)) options += " " + std::string(o.long_name());
    out += fmt::format("    {})\n      if [[ $current == -* ]]; then words {}; else {}; fi\n      ;;\n", v.id,
                       options, operand_action(v.operands));
  }
  return out + "  esac\n}\ncomplete -o filenames -F _polhode polhode\n";
}

}  // namespace

int completion_verb(const Options& options) {
  if (options.scenes.size() != 1 || options.scenes.front() != "bash")
    throw UsageError("completion needs the shell: polhode completion bash");
  write_stdout(bash_script());
  return 0;
}

}  // namespace polhode
