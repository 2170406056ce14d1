// `manual`: the manual page in roff, from the lists of verbs and options.
#include <fmt/format.h>

#include "experiments/provenance.hpp"
#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "experiments/verbs.hpp"
#include "models/errors.hpp"

namespace polhode {
namespace {

/// Text in which no character has a meaning to roff.
std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '\'')
      out += "\\(aq";
    else
      out += c;
  }
  return out.starts_with('.') ? "\\&" + out : out;
}

std::string entry(const std::string& tag, std::string_view text) {
  return ".TP\n" + tag + '\n' + plain(text) + '\n';
}

std::string page() {
  std::string out = fmt::format(
      ".TH POLHODE 1 \"\" \"polhode {}\" \"User Commands\"\n"
      ".SH NAME\npolhode \\- how wrong, how stable and how expensive is this integrator on this spinning "
      "body?\n"
      ".SH SYNOPSIS\n.B polhode\n.I VERB\n.RI [ WHAT ...]\n.RI [ OPTION ...]\n"
      ".SH DESCRIPTION\n"
      "Runs integrators of rigid\\-body motion on a scene, against its exact motion in 50 digits, and "
      "reports error, "
      "drift, stability and CPU time.\n"
      "A SCENE is the id of a built\\-in one or the path of a TOML file.\n"
      "Results go to standard output or into a folder, everything else to standard error.\n"
      ".SH VERBS\n",
      polhode_version);
  for (const Verb& v : all_verbs()) {
    const std::string operands = *v.operands ? " \\fI" + plain(v.operands) + "\\fR" : "";
    out += entry("\\fB" + plain(v.id) + "\\fR" + operands, std::string(v.summary) + ".");
  }
  out += ".SH OPTIONS\nEach means the same for every verb that follows it; the others refuse it.\n";
  for (const OptionInfo& o : all_options()) {
    std::string tag;
    for (const std::string& name : split(o.names, ','))
      tag += (tag.empty() ? "\\fB" : ", \\fB") + plain(name) + "\\fR";
    if (!o.takes.empty()) tag += " \\fI" + plain(o.takes) + "\\fR";
    std::string followers;
    for (const std::string& v : split(o.verbs, ' ')) followers += (followers.empty() ? "" : ", ") + v;
    out += entry(tag, fmt::format("{}. For: {}.", o.help, followers));
  }
  out +=
      ".SH EXAMPLES\n"
      ".TP\n.B polhode study hairer\\-vilmart \\-o results\nevery question on one scene\n"
      ".TP\n.B polhode advise heavy\\-top \\-\\-error 1e\\-6\nthe fastest solver with that error, and its "
      "setting\n"
      ".TP\n.B polhode judge tumbling\\-box mine.csv \\-\\-max\\-error 1e\\-3\n"
      "a trajectory of your own as a check: exit 1 if it is worse\n"
      ".SH EXIT STATUS\n";
  for (const auto& [code, meaning] :
       {std::pair("0", "done"), std::pair("1", "a check or a comparison failed"), std::pair("2", "usage"),
        std::pair("65", "bad input file"), std::pair("69", "something needed is not installed"),
        std::pair("70", "internal error"), std::pair("73", "output cannot be written"),
        std::pair("130", "interrupted")})
    out += entry(std::string("\\fB") + code + "\\fR", meaning);
  return out + ".SH ENVIRONMENT\n" + entry("\\fBNO_COLOR\\fR", "if set, no colours on the terminal") +
         ".SH SEE ALSO\nThe built\\-in scenes:\n.B polhode list scenes\n(files to copy and edit).\n"
         "The solvers, with their claims and sources:\n.B polhode list solvers \\-\\-json\n";
}

}  // namespace

int manual_verb(const Options& options) {
  if (!options.scenes.empty()) throw UsageError("manual takes nothing; got '" + options.scenes.front() + "'");
  write_stdout(page());
  return 0;
}

}  // namespace polhode
