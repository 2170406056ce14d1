// Reading of trajectories. The format is told by the first line that is no comment: eight bare numbers are
// TUM.
#include "experiments/trajectory_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>

#include <fmt/format.h>

#include "experiments/options.hpp"
#include "models/errors.hpp"
#include "reports/csv.hpp"

namespace polhode {
namespace {

constexpr const char* tum_header = "t,px,py,pz,qx,qy,qz,qw";
constexpr std::uintmax_t largest_file = 1'000'000'000;

std::string text_of(const std::filesystem::path& file) {
  std::error_code failed;
  const auto size = std::filesystem::file_size(file, failed);
  if (failed) throw InputError("'" + file.string() + "' cannot be read: " + failed.message());
  if (size > largest_file)
    throw InputError(
        fmt::format("'{}' has {} bytes; a trajectory may have {}", file.string(), size, largest_file));
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (size > 0) text << in.rdbuf();
  if (!in || in.bad()) throw InputError("'" + file.string() + "' cannot be read");
  if (text.str().find('\0') != std::string::npos)
    throw InputError("'" + file.string() + "' is not text: it holds a zero byte; needs CSV or TUM");
  return text.str();
}

std::optional<double> number_in(std::string_view field) {
  double x = 0;
  const auto [end, failed] = std::from_chars(field.data(), field.data() + field.size(), x);
  if (failed != std::errc() || end != field.data() + field.size() || !std::isfinite(x)) return std::nullopt;
  return x;
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// TUM as CSV, line for line, so that line numbers stay true; other text as it is.
std::string as_csv(const std::string& text, bool& tum) {
  std::istringstream in(text);
  std::string csv, line;
  tum = false;
  bool first = true;
  while (std::getline(in, line)) {
    const auto words = words_of(line);
    const bool comment = words.empty() || words.front().starts_with('#');
    if (first && !comment) {
      tum = words.size() == 8 &&
            std::ranges::all_of(words, [](const auto& w) { return number_in(w).has_value(); });
      if (!tum) return text;
      first = false;
    }
    std::string row;
    if (!comment)
      for (const std::string& w : words) row += (row.empty() ? "" : ",") + w;
    csv += row + '\n';
  }
  return first ? text : std::string(tum_header) + '\n' + csv;
}

struct ColumnName {
  std::string name;  // short: "wx"
  bool degrees = false, space = false;
};

/// "Omega_x_space_deg_per_s" -> wx, degrees, space frame
ColumnName column_name(std::string header) {
  std::erase(header, ' ');
  std::ranges::transform(header, header.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  ColumnName c;
  const auto drop = [&header](std::string_view tail) {
    if (header.size() <= tail.size() || !header.ends_with(tail)) return false;
    header.resize(header.size() - tail.size());
    return true;
  };
  c.degrees = drop("_deg_per_s");
  for (const char* unit : {"_kg_m2_per_s", "_rad_per_s", "_m_per_s", "_m", "_s", "_j"})
    if (drop(unit)) break;
  c.space = drop("_space") || drop("_world");
  drop("_body");
  std::erase(header, '_');
  static const std::map<std::string, std::string> others = {
      {"time", "t"},    {"timestamp", "t"}, {"x", "px"},      {"y", "py"},
      {"z", "pz"},      {"posx", "px"},     {"posy", "py"},   {"posz", "pz"},
      {"omegax", "wx"}, {"omegay", "wy"},   {"omegaz", "wz"}, {"e", "energy"}};
  const auto known = others.find(header);
  c.name = known == others.end() ? header : known->second;
  return c;
}

}  // namespace

TrajectoryFile read_trajectory(const std::filesystem::path& file) {
  TrajectoryFile out;
  const report::CsvTable table = report::parse_csv(as_csv(text_of(file), out.tum));
  const std::string name = file.string();
  const auto& header = table.header();
  // The header that stands for TUM's is not in the file.
  const auto line = [&](std::size_t row) { return table.line(row) - (out.tum ? 1 : 0); };
  std::map<std::string, std::size_t> at;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const ColumnName c = column_name(header[i]);
    static const std::vector<std::string> known =
        split("t px py pz vx vy vz qw qx qy qz wx wy wz energy lx ly lz", ' ');
    if (std::ranges::find(known, c.name) == known.end()) {
      out.ignored.push_back(header[i]);
      continue;
    }
    if (!at.emplace(c.name, i).second)
      throw InputError(fmt::format("{}:1: column '{}' is there twice; needs each once", name, header[i]));
    out.degrees |= c.degrees;
    out.space_rates |= c.space;
  }
  const auto part = [&](const std::vector<std::string>& names) {
    std::vector<std::size_t> columns;
    for (const std::string& n : names)
      if (at.count(n)) columns.push_back(at[n]);
    if (!columns.empty() && columns.size() < names.size())
      throw InputError(fmt::format("{}:1: got {} of the columns {}; needs all or none", name, columns.size(),
                                   name_list(names)));
    return columns;
  };
  const auto t = part({"t"}), q = part({"qw", "qx", "qy", "qz"}), w = part({"wx", "wy", "wz"}),
             p = part({"px", "py", "pz"}), v = part({"vx", "vy", "vz"}), L = part({"lx", "ly", "lz"}),
             energy = part({"energy"});
  if (t.empty() || (q.empty() && w.empty() && p.empty() && v.empty() && L.empty() && energy.empty()))
    throw InputError(
        fmt::format("{}:1: got the columns '{}'; needs t_s and some of qw, qx, qy, qz, wx_rad_per_s, "
                    "..., px_m, ..., separated by commas (or TUM: t x y z qx qy qz qw)",
                    name, name_list(header).substr(0, 120)));
  if (table.rows() == 0) throw InputError(name + ": has no rows below its header");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (table.fields(i) != header.size())
      throw InputError(
          fmt::format("{}:{}: got {} fields, needs {}", name, line(i), table.fields(i), header.size()));
    const auto value = [&](std::size_t column) {
      const std::string& field = table.text(i, header[column]);
      const auto x = number_in(field);
      if (!x)
        throw InputError(fmt::format("{}:{}: column '{}': got '{}', needs a finite number", name, line(i),
                                     header[column], field));
      return *x;
    };
    const auto add = [&](std::vector<Vec3>& to, const std::vector<std::size_t>& columns) {
      if (!columns.empty()) to.emplace_back(value(columns[0]), value(columns[1]), value(columns[2]));
    };
    const double time = value(t[0]);
    if (time < 0 || (!out.t.empty() && time <= out.t.back()))
      throw InputError(fmt::format("{}:{}: column '{}': got {}, needs times from 0 on that increase", name,
                                   line(i), header[t[0]], time));
    out.t.push_back(time);
    if (!q.empty()) {
      out.q.push_back({value(q[0]), value(q[1]), value(q[2]), value(q[3])});
      const auto& c = out.q.back();
      if (c[0] == 0 && c[1] == 0 && c[2] == 0 && c[3] == 0)
        throw InputError(fmt::format("{}:{}: column '{}': the quaternion is zero; needs an attitude", name,
                                     line(i), header[q[0]]));
    }
    add(out.w, w);
    if (out.degrees && !out.w.empty()) out.w.back() *= std::numbers::pi / 180;
    add(out.p, p);
    add(out.v, v);
    add(out.L, L);
    if (!energy.empty()) out.energy.push_back(value(energy[0]));
  }
  return out;
}

}  // namespace polhode
