// Numbers and names as a reader wants to see them, and the escaping that HTML needs.
#pragma once
#include <string>
#include <string_view>

namespace polhode::report {

/// Text with `& < > " '` replaced, fit for element content and for quoted attributes.
std::string escape_html(std::string_view text);

/// A number to three digits, powers of ten raised: `0.02`, `3.2·10⁻⁹`, `10⁻⁸`; "–" for NaN.
std::string pretty_number(double value);

/// A time with its unit: `12.3 µs`, `1.34 ms`, `2.5 s`.
///
/// seconds  [s]
std::string pretty_time(double seconds);

/// A factor: `1.4`, `27`, `3 400`, never more than two digits of meaning below ten.
std::string pretty_factor(double factor);

/// A count with its noun: `1 solver`, `14 solvers`.
std::string pretty_count(std::size_t n, std::string_view noun);

/// A file name made of `[a-z0-9-]` from any text; never empty.
std::string file_name_of(std::string_view text);

}  // namespace polhode::report
