// Turning a dial: numbers of a scene file found by their place, "load[0].coefficients[2]", and set.
#include <charconv>
#include <cmath>

#include "models/errors.hpp"
#include "models/scene_reader.hpp"

namespace polhode {
namespace {

/// Where a value stands: an entry of a table or of an array. A number is replaced whole, because an integer
/// in the file cannot become 0.5 in place.
struct Slot {
  toml::table* table = nullptr;
  std::string key;
  toml::array* array = nullptr;
  std::size_t index = 0;

  toml::node* node() const {
    return table ? table->get(key) : index < array->size() ? array->get(index) : nullptr;
  }
  void set(double x) const {
    if (table)
      table->insert_or_assign(key, x);
    else
      array->replace(array->cbegin() + static_cast<std::ptrdiff_t>(index), x);
  }
};

class Place {
 public:
  Place(toml::table& document, const std::string& file, const std::string& place)
      : file_(file), place_(place) {
    const Slot slot = find(document);
    toml::node& node = *slot.node();
    if (node.is_number()) {
      slots_ = {slot};
    } else if (toml::array* array = node.as_array(); array && !array->empty()) {
      for (std::size_t i = 0; i < array->size(); ++i) {
        if (!array->get(i)->is_number()) fail("an array of something else");
        slots_.push_back({nullptr, {}, array, i});
      }
      if (value() == 0) fail("a vector that is zero");
    } else {
      fail("something else");
    }
  }

  /// The number, or the largest modulus of the vector.
  double value() const {
    if (slots_.size() == 1) return at(slots_.front());
    double largest = 0;
    for (const Slot& s : slots_) largest = std::max(largest, std::abs(at(s)));
    return largest;
  }
  void set(double to) const {
    const double from = value();
    for (const Slot& s : slots_) {
      const double x = at(s);
      s.set(x == from ? to : to * (x / from));  // exactly `to` where it is the largest
    }
  }

  [[noreturn]] void fail(const std::string& got) const {
    throw InputError(file_ + ": dial \"" + place_ + "\": got " + got +
                     ", need the place of a number or of a vector, such as load[0].coefficients, "
                     "initial.angular_velocity[1], duration");
  }

 private:
  static double at(const Slot& s) { return *s.node()->value<double>(); }

  Slot find(toml::table& document) const {
    Slot slot;
    toml::node* node = &document;
    std::string_view rest = place_;
    if (rest.empty()) fail("an empty name");
    while (!rest.empty()) {
      slot = {};
      if (rest.front() == '[') {
        const char* const end = rest.data() + rest.size();
        const auto [after, error] = std::from_chars(rest.data() + 1, end, slot.index);
        if (error != std::errc() || after == end || *after != ']') fail("an index that is not [0], [1], ...");
        slot.array = node->as_array();
        rest.remove_prefix(static_cast<std::size_t>(after + 1 - rest.data()));
      } else {
        if (node != &document) {
          if (rest.front() != '.') fail("no '.' before a name");
          rest.remove_prefix(1);
        }
        slot.key = rest.substr(0, rest.find_first_of(".["));
        slot.table = node->as_table();
        rest.remove_prefix(slot.key.size());
      }
      node = slot.table || slot.array ? slot.node() : nullptr;
      if (!node) fail("nothing there");
    }
    return slot;
  }

  const std::string& file_;
  const std::string& place_;
  std::vector<Slot> slots_;
};

}  // namespace

void turn_dial(toml::table& document, const std::string& file, const Dial& dial, double value) {
  const Place place(document, file, dial.place);
  const double ratio = value / place.value();
  for (const Dial::Follower& f : dial.followers) {
    const Place follower(document, file, f.place);
    const double turned = follower.value() * std::pow(ratio, f.power);
    if (!(ratio > 0) || !std::isfinite(turned))
      follower.fail("a number that would be " + number_text(turned) + " with the dial at " +
                    number_text(value));
    follower.set(turned);
  }
  place.set(value);
}

}  // namespace polhode
