#include "models/scene_reader.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "models/errors.hpp"
#include "models/scene.hpp"

namespace polhode {
namespace {

constexpr std::uintmax_t largest_file = 1'000'000;  // bytes
constexpr std::size_t longest_quote = 70;           // characters of what was found, in a message

std::string cut(std::string text) {
  if (text.size() <= longest_quote) return text;
  std::size_t end = longest_quote;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not inside a character
  return text.substr(0, end) + "...";
}

// A value as a message shows it: shortest digits, arrays on one line.
std::string show(const toml::node& node) {
  if (const auto* x = node.as_floating_point()) return number_text(x->get());
  if (const auto* n = node.as_integer()) return std::to_string(n->get());
  if (const auto* b = node.as_boolean()) return b->get() ? "true" : "false";
  if (node.is_table()) return "a table";
  if (const auto* s = node.as_string()) {
    std::string text = "\"";
    for (const char c : cut(s->get())) text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    return text + "\"";
  }
  if (const auto* a = node.as_array()) {
    std::string text = "[";
    for (const auto& element : *a) {
      if (text.size() > longest_quote) break;
      text += (text.size() > 1 ? ", " : "") + show(element);
    }
    return cut(text + "]");
  }
  return "a date or time";
}

std::string with_sign(Sign sign) {
  switch (sign) {
    case Sign::positive:
      return " > 0";
    case Sign::not_negative:
      return " >= 0";
    default:
      return "";
  }
}

/// For keys that people try: how the same is said here. "" for any other.
std::string other_words(const std::string& place) {
  const auto has = [&place](const char* part) { return place.find(part) != place.npos; };
  if (has("angular_velocity_") || has("rates") || has("rpm"))
    return "angular_velocity in rad/s (1 deg/s is 0.017453292519943295, 1 deg/day 2.0200569120304740e-07)";
  if (has("euler") || has("rpy") || has("quat") || has("axis_angle") || has("orientation_"))
    return "orientation = [w, x, y, z], a quaternion that turns body into space, scalar first";
  if (place == "body.orientation" || has("inertia_frame"))
    return "the tensor in the axes of the body: inertia = [xx, yy, zz, xy, xz, yz] of R I R^T";
  if (place.starts_with("body.part") && (has("inertia") || has("shape")))
    return "a shape for each part; a body known by numbers is one tensor, [body] inertia = [xx, yy, zz, xy, "
           "xz, yz]";
  return "";
}

std::string lengths_text(const std::vector<std::size_t>& lengths) {
  std::string text;
  for (const std::size_t n : lengths) text += (text.empty() ? "" : " or ") + std::to_string(n);
  return text;
}

}  // namespace

std::string SceneTable::name_of(const std::string& key) const {
  if (key.empty()) return path_.empty() ? "scene" : path_;
  return path_.empty() ? key : path_ + "." + key;
}

std::size_t SceneTable::line_of(const std::string& key) const {
  for (const auto& [k, value] : *table_)
    if (k.str() == key) return k.source().begin.line;
  return line_;
}

void SceneTable::fail(const std::string& key, const std::string& got, const std::string& need) const {
  throw InputError(file_ + ":" + std::to_string(line_of(key)) + ": " + name_of(key) + ": got " + got +
                   ", need " + need);
}

void SceneTable::fail(const std::string& key, const std::string& need) const {
  const toml::node* node = table_->get(key);
  fail(key, node ? show(*node) : "nothing", need);
}

void SceneTable::allow(const std::vector<std::string>& keys) const {
  for (const auto& [k, value] : *table_) {
    const std::string key(k.str());
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    const std::string near = nearest_name(key, keys), words = other_words(name_of(key));
    fail(key, "an unknown key",
         !words.empty() ? words
                        : "one of " + name_list(keys) + (near.empty() ? "" : " (perhaps \"" + near + "\")"));
  }
}

std::string SceneTable::one_of(const std::vector<std::string>& keys) const {
  std::string found;
  for (const auto& key : keys) {
    if (!has(key)) continue;
    if (!found.empty())
      fail(key, "\"" + key + "\" beside \"" + found + "\"", "only one of " + name_list(keys));
    found = key;
  }
  return found;
}

const toml::node* SceneTable::find(const std::string& key, const std::string& need) const {
  const toml::node* node = table_->get(key);
  if (!node) fail(key, "nothing", need);
  return node;
}

double SceneTable::real(const toml::node& node, const std::string& key, const std::string& need,
                        Sign sign) const {
  double x = std::nan("");
  if (const auto* f = node.as_floating_point())
    x = f->get();
  else if (const auto* n = node.as_integer())
    x = static_cast<double>(n->get());
  else
    fail(key, need);
  if (!std::isfinite(x) || (sign == Sign::positive && !(x > 0)) || (sign == Sign::not_negative && x < 0))
    fail(key, need);
  return x;
}

double SceneTable::number(const std::string& key, Sign sign) const {
  const std::string need = "a finite number" + with_sign(sign) + (key == "duration" ? ", in seconds" : "");
  return real(*find(key, need), key, need, sign);
}

std::vector<double> SceneTable::numbers(const std::string& key, const std::vector<std::size_t>& lengths,
                                        Sign sign) const {
  std::string need = "an array of " + (lengths.empty() ? "" : lengths_text(lengths) + " ") +
                     "finite numbers" + with_sign(sign);
  if (key == "inertia") need += ": three principal moments, or xx, yy, zz, xy, xz, yz";
  if (key.starts_with("angular_velocity")) need += ", in rad/s";
  const toml::array* array = find(key, need)->as_array();
  if (!array) fail(key, need);
  if (!lengths.empty() && std::find(lengths.begin(), lengths.end(), array->size()) == lengths.end())
    fail(key, show(*array) + " (" + std::to_string(array->size()) + " elements)", need);
  std::vector<double> values;
  for (const auto& element : *array) values.push_back(real(element, key, need, sign));
  return values;
}

Vec3 SceneTable::vec3(const std::string& key, Sign sign) const {
  const auto v = numbers(key, {3}, sign);
  return {v[0], v[1], v[2]};
}

Quaternion SceneTable::quaternion(const std::string& key) const {
  const auto v = numbers(key, {4}, Sign::any);
  const Quaternion q(v[0], v[1], v[2], v[3]);
  // Also the squares: their sum must not overflow, and not lose digits by underflow.
  const double norm2 = squared_norm(q);
  if (!std::isfinite(norm2) || norm2 < 1e-280)
    fail(key, "a quaternion (w, x, y, z) of a length that is not zero and can be computed, 1e-140 to 1e150");
  return q;
}

std::int64_t SceneTable::integer(const std::string& key, std::int64_t low, std::int64_t high) const {
  const std::string need = "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  const auto* n = find(key, need)->as_integer();
  if (!n || n->get() < low || n->get() > high) fail(key, need);
  return n->get();
}

std::string SceneTable::text(const std::string& key) const {
  const auto* s = find(key, "a text in quotes")->as_string();
  if (!s || s->get().empty()) fail(key, "a text in quotes");
  return s->get();
}

std::string SceneTable::choice(const std::string& key, const std::vector<std::string>& choices) const {
  std::string need = "one of " + name_list(choices);
  if (const std::string words = other_words(name_of(key)); !has(key) && !words.empty()) need = words;
  const auto* s = find(key, need)->as_string();
  if (!s) fail(key, need);
  if (std::find(choices.begin(), choices.end(), s->get()) == choices.end()) {
    const std::string near = nearest_name(s->get(), choices);
    fail(key, need + (near.empty() ? "" : " (perhaps \"" + near + "\")"));
  }
  return s->get();
}

bool SceneTable::flag(const std::string& key) const {
  const auto* b = find(key, "true or false")->as_boolean();
  if (!b) fail(key, "true or false");
  return b->get();
}

SceneTable SceneTable::table(const std::string& key) const {
  const std::string need = "a table [" + name_of(key) + "]";
  const toml::table* t = find(key, need)->as_table();
  if (!t) fail(key, need);
  return {*t, file_, name_of(key), line_of(key)};
}

SceneTable SceneTable::table_or_empty(const std::string& key) const {
  static const toml::table empty;
  return has(key) ? table(key) : SceneTable(empty, file_, name_of(key), line_);
}

std::vector<SceneTable> SceneTable::tables(const std::string& key) const {
  const std::string need = "tables [[" + name_of(key) + "]]";
  const toml::array* array = find(key, need)->as_array();
  if (!array || array->empty()) fail(key, need);
  std::vector<SceneTable> all;
  for (const auto& element : *array) {
    const toml::table* t = element.as_table();
    if (!t) fail(key, need);
    all.emplace_back(*t, file_, name_of(key) + "[" + std::to_string(all.size()) + "]",
                     element.source().begin.line);
  }
  return all;
}

toml::table parse_scene_file(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  const std::string name = file.string();
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found)
    throw InputError(name + ": got no such file, need a scene file");
  if (!fs::exists(status)) throw InputError(name + ": got " + error.message() + ", need a scene file");
  if (fs::is_directory(status)) throw InputError(name + ": got a folder, need a scene file");
  if (!fs::is_regular_file(status))
    throw InputError(name + ": got something that is not a regular file, need a scene file");
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) throw InputError(name + ": got " + error.message() + ", need a scene file");
  const std::string too_large = " bytes, need a scene file of at most " + std::to_string(largest_file);
  if (size > largest_file) throw InputError(name + ": got " + std::to_string(size) + too_large);

  std::ifstream in(file, std::ios::binary);
  std::string text(largest_file + 1, '\0');  // no more than that, whatever the size said
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in.is_open() || in.bad())
    throw InputError(name + ": got a file that cannot be read, need a scene file");
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > largest_file)
    throw InputError(name + ": got more than " + std::to_string(largest_file) + too_large);

  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& e) {
    throw InputError(name + ":" + std::to_string(e.source().begin.line) + ": got invalid TOML (" +
                     std::string(e.description()) + "), need TOML in UTF-8");
  }
}

}  // namespace polhode
