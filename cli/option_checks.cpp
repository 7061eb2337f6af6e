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

bool is_whole(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

CLI::Validator one_of(std::vector<std::string> names) {
  return CLI::Validator(
      [names](std::string& value) {
        if (std::find(names.begin(), names.end(), value) != names.end()) return std::string();
        return fmt::format("'{}' is not one of {}", value, fmt::join(names, ", "));
      },
      "");
}

void refuse_empty_values(CLI::App& app) {
  const CLI::Validator check(
      [](std::string& value) { return value.empty() ? "has an empty value; give one or leave it out" : std::string(); },
      "");
  for (CLI::Option* option : app.get_options())
    if (option->get_items_expected_max() > 0) option->transform(check);  // before its own checks
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
    if (result.ec == std::errc::result_out_of_range && range.empty()) range = " of up to 308 digits";
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

Threshold threshold_of(const std::string& option, const std::string& text) {
  constexpr std::int64_t exact = std::int64_t{1} << 53;  // up to here doubles hold every whole number
  std::int64_t whole = 0;
  std::uint64_t large = 0;
  if (is_number(text, whole) && (whole < -exact || whole > exact)) return whole;
  if (is_number(text, large) && large > static_cast<std::uint64_t>(exact)) return large;
  return number_of<double>(option, text);
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
  return add_parsed(
      app, name, help,
      [&value, least, most](const std::string& option, const std::string& text) {
        value = number_of<T>(option, text, least, most);
      },
      [&value] { return fmt::format("{}", value); });
}

CLI::Option* add_label(CLI::App& app, std::optional<std::int64_t>& label, const std::string& help) {
  return add_parsed(app, "--label", help, [&label](const std::string& option, const std::string& text) {
    label = number_of<std::int64_t>(option, text);
  });
}

CLI::Option* add_threshold(CLI::App& app, std::optional<Threshold>& threshold, const std::string& help) {
  return add_parsed(app, "--threshold", help, [&threshold](const std::string& option, const std::string& text) {
    threshold = threshold_of(option, text);
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

}  // namespace quench::program
