// The list of options.
#include "experiments/options.hpp"

#include <algorithm>

namespace polhode {
namespace {

constexpr OptionInfo options[] = {
#define OPTION(names, takes, verbs, help) {names, takes, verbs, help},
#include "experiments/options.def"
#undef OPTION
};

constexpr std::string_view questions[] = {
#define QUESTION(function, verb, summary) verb,
#include "experiments/questions.def"
#undef QUESTION
};

}  // namespace

std::span<const OptionInfo> all_options() { return options; }

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> words;
  while (true) {
    const std::size_t end = text.find(separator);
    words.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) return words;
    text.remove_prefix(end + 1);
  }
}

bool OptionInfo::followed_by(std::string_view verb) const {
  return std::ranges::any_of(split(verbs, ' '), [verb](const std::string& word) {
    return word == "all" || word == verb ||
           (word == "questions" && std::ranges::find(questions, verb) != std::end(questions));
  });
}

std::vector<std::string> OptionInfo::choices() const {
  return takes.find('|') == std::string_view::npos ? std::vector<std::string>() : split(takes, '|');
}

}  // namespace polhode
