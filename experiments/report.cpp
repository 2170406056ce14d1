// `report`: the page and the figures of a result folder, made anew from its tables.
#include "reports/report.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "models/errors.hpp"

namespace polhode {

int report_verb(const Options& options) {
  if (options.scenes.size() != 1) throw UsageError("report needs one result folder");
  const std::filesystem::path folder = options.scenes.front();
  if (!std::filesystem::exists(folder / "run.json"))
    throw InputError("'" + folder.string() + "' is not a result folder: it has no run.json");
  ReportOutcome done;
  try {
    done = write_report(folder);
  } catch (const std::runtime_error& e) {
    throw OutputError(e.what());
  }
  for (const std::string& note : done.notes) fmt::print(stderr, "polhode: note: {}\n", note);
  if (options.json) {
    const nlohmann::ordered_json j = {
        {"figures", done.figures}, {"page", (folder / "index.html").string()}, {"notes", done.notes}};
    write_stdout(j.dump(2) + "\n");
    return 0;
  }
  write_stdout(fmt::format("{} figures, {}\n", done.figures, (folder / "index.html").string()));
  return 0;
}

}  // namespace polhode
