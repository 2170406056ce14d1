// Writes the report of a result folder: scripts first, then what gnuplot makes of them, then the page.
#include "reports/report.hpp"

#include <chrono>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "reports/figures.hpp"
#include "reports/gnuplot.hpp"
#include "reports/page.hpp"
#include "reports/results.hpp"

namespace polhode {
namespace {

constexpr std::chrono::seconds patience(60);  // for one figure; the largest take about a second

void write_file(const std::filesystem::path& path, std::string_view text) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

constexpr const char* drawings[] = {"-84mm.svg", "-84mm.pdf", "-174mm.svg", "-174mm.pdf"};

}  // namespace

ReportOutcome write_report(const std::filesystem::path& folder) {
  using End = report::GnuplotRun::End;
  ReportOutcome outcome;
  const report::Results results = report::read_results(folder);
  const std::filesystem::path figures = folder / "figures";
  std::error_code error;
  std::vector<std::pair<report::Figure, std::string>> stand_ins;
  bool installed = true;
  for (const report::Figure& f : report::figures_of(results)) {
    std::filesystem::create_directories(figures, error);
    if (error) throw std::runtime_error("cannot make " + figures.string() + ": " + error.message());
    write_file(figures / (f.name + ".csv"), f.data);
    write_file(figures / (f.name + ".gp"), f.script);
    // A drawing of an earlier report must not stand in for one that cannot be made now.
    for (const char* drawing : drawings) std::filesystem::remove(figures / (f.name + drawing), error);
    if (!installed) continue;
    const report::GnuplotRun run = report::run_gnuplot(figures, f.name + ".gp", patience);
    if (run.end == End::not_installed) {
      installed = false;
      outcome.notes.push_back(
          "gnuplot is not installed: the figures are there as scripts only (figures/*.gp); on Debian: apt "
          "install "
          "gnuplot-nox, then make the report again");
    } else if (run.end != End::drawn) {
      outcome.notes.push_back(fmt::format("gnuplot could not draw figures/{}.gp: {}", f.name, run.message));
    } else {
      ++outcome.figures;
      for (const char* drawing : drawings)
        if (!std::filesystem::exists(figures / (f.name + drawing)))
          outcome.notes.push_back(
              fmt::format("figures/{}{} is missing: this gnuplot lacks the terminal", f.name, drawing));
      // Where the page can draw charts itself, it needs no pictures of them.
      if (!report::page_missing_packages.empty())
        stand_ins.emplace_back(f, read_file(figures / (f.name + drawings[2])));
    }
  }
  write_file(folder / "index.html",
             report::page(report::page_data(results, folder, stand_ins, report::read_provenance(folder),
                                            outcome.notes)));
  return outcome;
}

}  // namespace polhode
