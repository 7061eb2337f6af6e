// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "quench/shape.h"

/// Values of options as text: what is refused, and how numbers are read. Numbers are read here, lengths by
/// parse_length(), amounts of memory by the session: decimal, all of the text, never rounded into its range.
namespace quench::program {

/// The value is one of these words.
CLI::Validator one_of(const std::vector<std::string>& names);
/// Words that an option also takes, beside numbers and the like: for completion, nothing is refused.
CLI::Validator also(const std::vector<std::string>& words);
/// The words of one_of() and also().
std::vector<std::string> words_of(CLI::Option& option);
/// Whether it takes no others: those of one_of().
bool takes_only_words(CLI::Option& option);

/// The range of add_number(), where it is not that of the type.
struct NumberRange {
  double least, most;
  bool whole;
};
std::optional<NumberRange> range_of(CLI::Option& option);

/// The name that was meant by a word: the only one that begins with it, or the nearest; empty when none is near.
std::string nearest_name(const std::string& word, const std::vector<std::string>& names);

/// What is said of the empty value of an option, behind its name.
std::string empty_value_text(const CLI::Option& option);

/// Every option and argument of the command refuses an empty value.
void refuse_empty_values(CLI::App& app);

/// Whether all of the text is a decimal number of the type; no plus sign, no blanks.
template <class T>
bool is_number(std::string_view text, T& value);

/// `text` as a number from least to most; infinite ones are none. Throws Error(usage), naming the option.
template <class T>
T number_of(const std::string& option, const std::string& text, T least = std::numeric_limits<T>::lowest(),
            T most = std::numeric_limits<T>::max());

/// Numbers separated by `separator`; empty when one of them is not a finite number.
std::vector<double> numbers_in(std::string_view text, char separator);

/// A whole number that a double would round stays one; so does the least one that is not below a fraction which a
/// double would round to a whole number, where doubles are whole numbers anyway (from 2^52).
Threshold threshold_of(const std::string& option, const std::string& text);

/// An option with one value, which `parse` turns into what it means.
CLI::Option* add_parsed(CLI::App& app, const std::string& name, const std::string& help,
                        std::function<void(const std::string& option, const std::string& text)> parse,
                        std::function<std::string()> default_text = {});

/// An option that is a number from least to most.
template <class T>
CLI::Option* add_number(CLI::App& app, const std::string& name, T& value, const std::string& help,
                        T least = std::numeric_limits<T>::lowest(), T most = std::numeric_limits<T>::max());
CLI::Option* add_label(CLI::App& app, std::optional<std::int64_t>& label, const std::string& help);

/// The extension of a file name in lower case, with its dot.
std::string extension_of(const std::filesystem::path& file);

}  // namespace quench::program
