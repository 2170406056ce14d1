// Tables small enough to travel inside the page.
#include "reports/pack.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

namespace polhode::report {
namespace {

void append_rounded(std::string& out, std::string_view field, int digits) {
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  const bool number = error == std::errc() && end == field.data() + field.size() && std::isfinite(value);
  const bool integer = field.find_first_of(".eE") == std::string_view::npos;
  if (!number || integer) {
    out += field;
    return;
  }
  const std::string rounded = fmt::format("{:.{}g}", value, digits);
  out += rounded.size() < field.size() ? std::string_view(rounded) : field;
}

}  // namespace

std::string rounded_csv(std::string_view text, int digits) {
  std::string out;
  out.reserve(text.size());
  std::size_t start = 0;
  bool quoted = false;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    const char c = i < text.size() ? text[i] : '\n';
    if (c == '"') quoted = !quoted;
    if (i < text.size() && (quoted || (c != ',' && c != '\n' && c != '\r'))) continue;
    append_rounded(out, text.substr(start, i - start), digits);
    if (i < text.size()) out += c;
    start = i + 1;
  }
  return out;
}

std::string packed(std::string_view text) {
  uLongf size = compressBound(text.size());
  std::vector<Bytef> bytes(size);
  if (compress2(bytes.data(), &size, reinterpret_cast<const Bytef*>(text.data()), text.size(),
                Z_BEST_COMPRESSION) != Z_OK)
    throw std::runtime_error("not enough memory to pack the tables of the page");
  static constexpr std::string_view letters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3) {
    unsigned triple = 0;
    for (std::size_t k = 0; k < 3; ++k) triple = triple << 8 | (i + k < size ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) out += i + k > size ? '=' : letters[triple >> (18 - 6 * k) & 63];
  }
  return out;
}

}  // namespace polhode::report
