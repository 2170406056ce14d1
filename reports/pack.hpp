// Tables small enough to travel inside the page.
#pragma once
#include <string>
#include <string_view>

namespace polhode::report {

/// CSV text whose numbers are rounded to a few significant digits.
///
/// digits   of every unquoted field that is a number and no integer; all other fields stay as they are
std::string rounded_csv(std::string_view text, int digits);

/// Text as base64 of its zlib stream: what atob() and DecompressionStream('deflate') of a browser undo. Holds
/// nothing that HTML could take for markup.
///
/// throws   std::runtime_error if there is not enough memory
std::string packed(std::string_view text);

}  // namespace polhode::report
