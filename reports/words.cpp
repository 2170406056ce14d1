// Numbers and names as a reader wants to see them.
#include "reports/words.hpp"

#include <array>
#include <cmath>

#include <fmt/format.h>

namespace polhode::report {

std::string escape_html(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  return out;
}

namespace {

std::string superscript(int n) {
  static constexpr std::array<std::string_view, 10> digits = {"⁰", "¹", "²", "³", "⁴",
                                                              "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out;
  for (const char c : std::to_string(n)) out += c == '-' ? "⁻" : digits[static_cast<std::size_t>(c - '0')];
  return out;
}

}  // namespace

std::string pretty_number(double value) {
  if (std::isnan(value)) return "–";
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  if (value < 0) return "−" + pretty_number(-value);
  if (value >= 999.5 && value < 99999.5) return fmt::format("{:.0f}", value);
  if (value == 0 || (value >= 1e-3 && value < 999.5)) return fmt::format("{:.3g}", value);
  // Let the formatter round first: 9.996e-9 is 10^-8 to three digits.
  const std::string text = fmt::format("{:.2e}", value);
  const auto e = text.find('e');
  std::string mantissa = text.substr(0, e);
  while (mantissa.back() == '0') mantissa.pop_back();
  if (mantissa.back() == '.') mantissa.pop_back();
  const std::string power = "10" + superscript(std::stoi(text.substr(e + 1)));
  return mantissa == "1" ? power : mantissa + "·" + power;
}

std::string pretty_time(double seconds) {
  if (!std::isfinite(seconds)) return "–";
  static constexpr std::array<std::pair<double, std::string_view>, 4> units = {
      {{1, "s"}, {1e-3, "ms"}, {1e-6, "µs"}, {1e-9, "ns"}}};
  for (const auto& [size, name] : units)
    if (seconds >= 0.9995 * size || size == 1e-9) {
      const double value = seconds / size;
      return value >= 999.5 ? fmt::format("{:.0f} {}", value, name) : fmt::format("{:.3g} {}", value, name);
    }
  return {};
}

std::string pretty_factor(double factor) {
  if (!std::isfinite(factor)) return "–";
  if (factor < 9.95) return fmt::format("{:.2g}", factor);
  if (factor < 9999.5) return fmt::format("{:.0f}", factor);
  return pretty_number(factor);
}

std::string pretty_count(std::size_t n, std::string_view noun) {
  return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s");
}

std::string file_name_of(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'))
      out += c;
    else if (c >= 'A' && c <= 'Z')
      out += static_cast<char>(c - 'A' + 'a');
    else if (!out.empty() && out.back() != '-')
      out += '-';
  }
  while (!out.empty() && out.back() == '-') out.pop_back();
  return out.empty() ? "scene" : out;
}

}  // namespace polhode::report
