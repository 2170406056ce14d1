// Writes the report of a result folder: scripts first, then what gnuplot makes of them, then the page.
#include "reports/report.hpp"

#include <chrono>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string_view>
#include <system_error>

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

}  // namespace

ReportOutcome write_report(const std::filesystem::path& folder) {
  using End = report::GnuplotRun::End;
  ReportOutcome outcome;
  const report::Results results = report::read_results(folder);
  const std::vector<report::Figure> figures = report::figures_of(results);
  std::set<std::string> drawn;
  if (!figures.empty()) {
    std::error_code error;
    std::filesystem::create_directories(folder / "figures", error);
    if (error)
      throw std::runtime_error("cannot make " + (folder / "figures").string() + ": " + error.message());
  }
  bool installed = true;
  for (const report::Figure& f : figures) {
    const std::filesystem::path script = "figures/" + f.name + ".gp";
    write_file(folder / script, f.script);
    // A figure of an earlier report must not stand in for one that cannot be drawn now.
    for (const char* end : {".svg", ".pdf"}) {
      std::error_code ignored;
      std::filesystem::remove(folder / ("figures/" + f.name + end), ignored);
    }
    if (!installed) continue;
    const report::GnuplotRun run = report::run_gnuplot(folder, script, patience);
    if (run.end == End::not_installed) {
      installed = false;
      outcome.notes.push_back(
          "gnuplot is not installed: the figures are there as scripts only (figures/*.gp); on Debian: apt "
          "install "
          "gnuplot-nox, then make the report again");
    } else if (run.end != End::drawn) {
      outcome.notes.push_back(fmt::format("gnuplot could not draw {}: {}", script.string(), run.message));
    } else {
      ++outcome.figures;
      if (!std::filesystem::exists(folder / ("figures/" + f.name + ".pdf")))
        outcome.notes.push_back(
            fmt::format("figures/{}.pdf is missing: this gnuplot has no pdfcairo terminal", f.name));
    }
    if (std::filesystem::exists(folder / ("figures/" + f.name + ".svg"))) drawn.insert(f.name);
  }
  write_file(folder / "index.html",
             report::page(results, figures, drawn, report::read_provenance(folder), outcome.notes));
  return outcome;
}

}  // namespace polhode
