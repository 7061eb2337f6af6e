// SPDX-License-Identifier: Apache-2.0
#include "option_checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <type_traits>

#include "quench/error.h"

namespace quench::program {
namespace {

/// " from 1 to 64"; empty where every value of the type will do.
template <class T>
std::string range_text(T least, T most) {
  if (least == std::numeric_limits<T>::lowest() && most == std::numeric_limits<T>::max()) return {};
  return fmt::format(" from {} to {}", least, most);
}

[[noreturn]] void refuse(const std::string& option, const std::string& text, const std::string& what) {
  throw Error(ErrorCode::usage, fmt::format("{} '{}' is not {}", option, text, what));
}

/// A validator has no place for its words but its name.
const std::string kWords = "words\n", kAlso = "also\n", kRange = "range\n";

/// What stands behind `kind` in the name of one of its validators.
std::optional<std::string> noted(CLI::Option& option, const std::string& kind) {
  for (int i = 0;; ++i) {
    std::string name;
    try {
      name = option.get_validator(i)->get_name();
    } catch (const CLI::OptionNotFound&) {
      return {};
    }
    if (name.starts_with(kind)) return name.substr(kind.size());
  }
}

CLI::Validator note_of(const std::string& name) {
  return CLI::Validator([](std::string&) { return std::string(); }, "", name);
}

/// How many letters must be changed, added, removed or swapped with their neighbour to make one word the other.
std::size_t distance_of(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      d[i][j] = i + j;
      if (i == 0 || j == 0) continue;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

bool is_whole(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

CLI::Validator one_of(const std::vector<std::string>& names) {
  return CLI::Validator(
      [names](std::string& value) {
        if (std::find(names.begin(), names.end(), value) != names.end()) return std::string();
        const std::string meant = nearest_name(value, names);
        return fmt::format("'{}' is not one of {}{}", value, fmt::join(names, ", "),
                           meant.empty() ? "" : fmt::format("; did you mean '{}'?", meant));
      },
      "", kWords + fmt::format("{}", fmt::join(names, "\n")));
}

CLI::Validator also(const std::vector<std::string>& words) {
  return note_of(kAlso + fmt::format("{}", fmt::join(words, "\n")));
}

std::vector<std::string> words_of(CLI::Option& option) {
  for (const std::string& kind : {kWords, kAlso})
    if (const auto words = noted(option, kind)) return CLI::detail::split(*words, '\n');
  return {};
}

bool takes_only_words(CLI::Option& option) { return noted(option, kWords).has_value(); }

std::optional<NumberRange> range_of(CLI::Option& option) {
  const auto text = noted(option, kRange);
  if (!text) return {};
  const std::vector<std::string> parts = CLI::detail::split(*text, '\n');
  NumberRange range{0, 0, parts.at(2) == "whole"};
  is_number(parts[0], range.least);
  is_number(parts[1], range.most);
  return range;
}

std::string nearest_name(const std::string& word, const std::vector<std::string>& names) {
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  std::string best;
  if (word.size() > 64) return {};
  const auto begins = [&](const std::string& name) { return name.starts_with(word); };
  if (word.size() > 2 && std::ranges::count_if(names, begins) == 1) return *std::ranges::find_if(names, begins);
  for (const std::string& name : names)
    if (const std::size_t distance = distance_of(word, name); distance < least) {
      least = distance;
      best = name;
    }
  return best;
}

std::string empty_value_text(const CLI::Option& option) {
  if (!option.get_required()) return "has an empty value; give one or leave it out";
  const std::string type = option.get_type_name();
  return fmt::format("is empty; give the name of a {}", type == "DIR" || type == "OUT" ? "folder"
                                                        : option.get_name() == "NAME"  ? "sample"
                                                                                       : "file");
}

void refuse_empty_values(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_items_expected_max() == 0) continue;
    const std::string text = empty_value_text(*option);
    option->transform(CLI::Validator([text](std::string& value) { return value.empty() ? text : std::string(); },
                                     ""));  // before its own checks
  }
}

template <class T>
bool is_number(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

template <class T>
T number_of(const std::string& option, const std::string& text, T least, T most) {
  T value{};
  const bool good = is_number(text, value) && value >= least && value <= most;
  if (good && std::isfinite(static_cast<double>(value))) return value;
  std::string range = range_text(least, most);
  if constexpr (std::is_integral_v<T>) {
    // Where the range is that of the type, it is only worth saying of a number that is outside.
    if (most == std::numeric_limits<T>::max())
      range = is_whole(text) ? fmt::format(" from {} to {}", least, most) : std::string();
    refuse(option, text, "a whole number" + range);
  } else {
    T unlimited{};
    const auto result = std::from_chars(text.data(), text.data() + text.size(), unlimited);
    // Not rounded to 0 or to infinity: no sample would be compared with what was given.
    const bool number = result.ptr == text.data() + text.size();
    if (number && result.ec == std::errc::result_out_of_range && range.empty())
      throw Error(ErrorCode::usage,
                  fmt::format("{} '{}' is beyond the range of numbers (up to 1.8e308, down to 5e-324)", option, text));
    refuse(option, text, "a number" + range);
  }
}

std::vector<double> numbers_in(std::string_view text, char separator) {
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    double value = 0;
    if (!is_number(text.substr(begin, end - begin), value) || !std::isfinite(value)) return {};
    numbers.push_back(value);
    begin = end + 1;
  }
  return numbers;
}

namespace {

/// The least whole number that is not below the decimal `text`, of which `nearest`, from 2^52 to 2^64 or from -2^64 to
/// -2^52, is the nearest double: nothing lies between the two in samples of any type, as doubles of this size are
/// whole. Nothing where it needs more than 64 bits.
std::optional<Threshold> least_whole(std::string_view text, double nearest) {
  const std::size_t begin = nearest < 0 ? 1 : 0, end = std::min(text.find_first_of("eE"), text.size());
  std::int64_t exponent = 0;
  if (end < text.size()) {
    std::string_view power = text.substr(end + 1);
    if (power.starts_with('+')) power.remove_prefix(1);
    if (!is_number(power, exponent)) return {};
  }
  std::string digits(text.substr(begin, end - begin));
  const std::size_t point = std::min(digits.find('.'), digits.size());
  if (point < digits.size()) digits.erase(point, 1);
  // The first digits, up to 20 behind any zeros, are before the point: `nearest` says how large the number is.
  const std::size_t zeros = digits.find_first_not_of('0');
  const auto before = static_cast<std::size_t>(static_cast<std::int64_t>(point - zeros) + exponent);
  digits.erase(0, zeros);
  const bool fraction = digits.size() > before && digits.find_first_not_of('0', before) != std::string::npos;
  digits.resize(before, '0');
  std::uint64_t whole = 0;
  if (!is_number(digits, whole)) return {};
  if (nearest > 0) {
    if (fraction && whole == std::numeric_limits<std::uint64_t>::max()) return {};
    whole += fraction ? 1 : 0;
    return whole <= std::uint64_t{INT64_MAX} ? Threshold(static_cast<std::int64_t>(whole)) : Threshold(whole);
  }
  if (whole > std::uint64_t{INT64_MAX}) return {};
  return Threshold(-static_cast<std::int64_t>(whole));
}

}  // namespace

Threshold threshold_of(const std::string& option, const std::string& text) {
  constexpr std::int64_t exact = std::int64_t{1} << 53;  // up to here doubles hold every whole number
  std::int64_t whole = 0;
  std::uint64_t large = 0;
  if (is_number(text, whole) && (whole < -exact || whole > exact)) return whole;
  if (is_number(text, large) && large > static_cast<std::uint64_t>(exact)) return large;
  const double nearest = number_of<double>(option, text);
  if (const double size = std::abs(nearest);
      size >= 0x1p52 && size <= 0x1p64 && text.find_first_of(".eE") != std::string::npos)
    if (const auto least = least_whole(text, nearest)) return *least;
  return nearest;
}

CLI::Option* add_parsed(CLI::App& app, const std::string& name, const std::string& help,
                        std::function<void(const std::string& option, const std::string& text)> parse,
                        std::function<std::string()> default_text) {
  const CLI::callback_t callback = [name, parse = std::move(parse)](const CLI::results_t& results) {
    parse(name, results.front());
    return true;
  };
  return app.add_option(name, callback, help, false, std::move(default_text));
}

template <class T>
CLI::Option* add_number(CLI::App& app, const std::string& name, T& value, const std::string& help, T least, T most) {
  CLI::Option* option = add_parsed(
      app, name, help,
      [&value, least, most](const std::string& of, const std::string& text) {
        value = number_of<T>(of, text, least, most);
      },
      [&value] { return fmt::format("{}", value); });
  if (!range_text(least, most).empty())
    option->check(note_of(fmt::format("{}{}\n{}\n{}", kRange, least, most, std::is_integral_v<T> ? "whole" : "any")));
  return option;
}

CLI::Option* add_label(CLI::App& app, std::optional<std::int64_t>& label, const std::string& help) {
  return add_parsed(app, "--label", help, [&label](const std::string& option, const std::string& text) {
    label = number_of<std::int64_t>(option, text);
  });
}

#define QUENCH_NUMBER(T)                                              \
  template bool is_number(std::string_view, T&);                      \
  template T number_of(const std::string&, const std::string&, T, T); \
  template CLI::Option* add_number(CLI::App&, const std::string&, T&, const std::string&, T, T);
QUENCH_NUMBER(int)
QUENCH_NUMBER(std::int64_t)
QUENCH_NUMBER(std::uint64_t)
QUENCH_NUMBER(double)
#undef QUENCH_NUMBER

std::string extension_of(const std::filesystem::path& file) { return CLI::detail::to_lower(file.extension().string()); }

}  // namespace quench::program
