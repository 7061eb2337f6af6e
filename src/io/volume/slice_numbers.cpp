// SPDX-License-Identifier: Apache-2.0
#include "io/volume/slice_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "quench/error.h"

namespace quench::io {
namespace {

constexpr std::string_view kDigits = "0123456789";
constexpr char kTheNumber = '/';  // in a pattern; in no name

struct Numbered {
  std::uint64_t number;
  std::size_t file;
};

/// The files whose names differ in one number, by the pattern "a12_b/".
using Patterns = std::map<std::string, std::vector<Numbered>>;

/// Adds a name once for each of its numbers; numbers beyond 18 digits are identifiers.
void add_patterns(const std::string& name, std::size_t file, Patterns& patterns) {
  constexpr std::size_t kLongest = 18;
  struct Digits {
    std::size_t begin, size;
  };
  std::string plain_name;  // without leading zeros
  std::vector<Digits> numbers;
  for (std::size_t at = 0; at < name.size();) {
    const std::size_t begin = std::min(name.find_first_of(kDigits, at), name.size());
    plain_name += name.substr(at, begin - at);
    at = std::min(name.find_first_not_of(kDigits, begin), name.size());
    if (at == begin) continue;
    const std::size_t first = std::min(name.find_first_not_of('0', begin), at - 1);
    if (at - first <= kLongest) numbers.push_back({plain_name.size(), at - first});
    plain_name += name.substr(first, at - first);
  }
  for (const auto& [begin, size] : numbers) {
    const std::uint64_t number = std::stoull(plain_name.substr(begin, size));
    patterns[plain_name.substr(0, begin) + kTheNumber + plain_name.substr(begin + size)].push_back({number, file});
  }
}

/// The slices of the pattern that most names follow, in the order of their numbers; empty where the names are free.
std::vector<Numbered> numbered_slices(const std::vector<std::filesystem::path>& files) {
  Patterns patterns;
  for (std::size_t i = 0; i < files.size(); ++i) add_patterns(files[i].stem().string(), i, patterns);
  std::vector<Numbered> most;
  for (auto& [pattern, slices] : patterns)
    if (slices.size() > most.size()) most = std::move(slices);
  const bool rule = most.size() == files.size() || (most.size() >= 3 && most.size() * 2 > files.size());
  if (!rule) return {};
  std::stable_sort(most.begin(), most.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  return most;
}

std::string file_name(const std::filesystem::path& file) { return file.filename().string(); }

void check_all_belong(const std::vector<Numbered>& slices, const std::vector<std::filesystem::path>& files) {
  std::vector<bool> belongs(files.size());
  for (const Numbered& slice : slices) belongs[slice.file] = true;
  const auto other = std::find(belongs.begin(), belongs.end(), false);
  if (other == belongs.end()) return;
  const auto& file = files[static_cast<std::size_t>(other - belongs.begin())];
  throw Error(
      ErrorCode::input,
      fmt::format("'{}' is not numbered as the other slices ('{}' to '{}'); move it out of the folder, or rename "
                  "it where it is one of them",
                  file.string(), file_name(files[slices.front().file]), file_name(files[slices.back().file])));
}

void check_step(const std::filesystem::path& folder, const std::vector<Numbered>& slices,
                const std::vector<std::filesystem::path>& files) {
  std::uint64_t step = slices.back().number - slices.front().number;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    const Numbered &a = slices[i - 1], &b = slices[i];
    if (a.number == b.number)
      throw Error(ErrorCode::input,
                  fmt::format("the slices in '{}' are numbered, and number {} occurs twice, as '{}' "
                              "and '{}'; move one of them out of the folder, or renumber the slices",
                              folder.string(), a.number, file_name(files[a.file]), file_name(files[b.file])));
    step = std::min(step, b.number - a.number);
  }
  for (std::size_t i = 1; i < slices.size(); ++i)
    if (slices[i].number - slices[i - 1].number != step)
      throw Error(ErrorCode::input,
                  fmt::format("the slices in '{}' are numbered {} to {}{} and number {} is missing; restore it, or "
                              "renumber the slices",
                              folder.string(), slices.front().number, slices.back().number,
                              step == 1 ? "" : fmt::format(" in steps of {}", step), slices[i - 1].number + step));
}

}  // namespace

void check_slice_numbers(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& files) {
  const std::vector<Numbered> slices = numbered_slices(files);
  if (slices.empty()) return;
  check_all_belong(slices, files);
  check_step(folder, slices, files);
}

}  // namespace quench::io
