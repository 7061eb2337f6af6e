// SPDX-License-Identifier: Apache-2.0
#include "io/volume/data_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "base/text.h"
#include "io/common/words.h"

namespace quench::io {
namespace {

/// "slice%03d.raw" and 7: "slice007.raw". Nothing where there is not exactly one %d.
std::optional<std::string> numbered(const std::string& pattern, std::int64_t number) {
  std::string name;
  bool found = false;
  for (std::size_t at = 0; at < pattern.size(); ++at) {
    if (pattern[at] != '%') {
      name.push_back(pattern[at]);
      continue;
    }
    if (pattern.substr(at, 2) == "%%") {
      name.push_back(pattern[at++]);
      continue;
    }
    const std::size_t end = pattern.find_first_not_of("0123456789", at + 1);
    if (found || end == std::string::npos || (pattern[end] != 'd' && pattern[end] != 'i' && pattern[end] != 'u'))
      return {};
    const std::string digits = pattern.substr(at + 1, end - at - 1);
    std::int64_t width = 0;
    if (!digits.empty() && (!parse_integer(digits, width) || width > 32)) return {};
    const auto places = static_cast<int>(width);
    name += digits.starts_with('0') ? fmt::format("{:0{}}", number, places) : fmt::format("{:{}}", number, places);
    found = true;
    at = end;
  }
  if (!found) return {};
  return name;
}

/// "2D" as "2".
std::string_view without_d(std::string_view word) {
  if (word.size() > 1 && (word.back() == 'D' || word.back() == 'd')) word.remove_suffix(1);
  return word;
}

}  // namespace

std::uint64_t size_of_file(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return 0;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  return error ? 0 : size;
}

std::vector<SampleBlock> named_data_files(const std::filesystem::path& file, const std::string& value,
                                          const std::vector<std::string>& list, std::size_t axes, const char* field) {
  std::vector<std::string> names;
  const auto words = words_of(value);
  if (words.empty()) refuse_volume(file, fmt::format("its field '{}' is empty", field));
  const auto shown = [&] { return base::plain(value.substr(0, 80)); };
  const auto check_axes = [&](std::size_t place) {
    std::int64_t each = 1;
    if (words.size() > place + 1 || (words.size() > place && !parse_integer(without_d(words[place]), each)) ||
        each < 1 || each > static_cast<std::int64_t>(axes))
      refuse_volume(file, fmt::format("its field '{}' is '{}'; the files of an image of {} axes have 1 to {} axes",
                                      field, shown(), axes, axes));
  };
  if (lower(words[0]) == "list") {
    check_axes(1);
    names = list;
  } else if (words.size() >= 3 && words[0].find('%') != std::string_view::npos) {
    std::int64_t first = 0, last = 0, step = 1;
    const bool numbers = parse_integer(words[1], first) && parse_integer(words[2], last) &&
                         (words.size() < 4 || parse_integer(words[3], step));
    constexpr std::int64_t kLargest = 1'000'000'000;
    if (!numbers || step == 0 || std::max(std::abs(first), std::abs(last)) > kLargest || std::abs(step) > kLargest ||
        (last - first) / step >= static_cast<std::int64_t>(kMostDataFiles))
      refuse_volume(file, fmt::format("its field '{}' is '{}', which does not number files", field, shown()));
    for (std::int64_t n = first; step > 0 ? n <= last : n >= last; n += step) {
      const auto name = numbered(std::string(words[0]), n);
      if (!name)
        refuse_volume(file, fmt::format("its field '{}' is '{}', which does not number files", field, shown()));
      names.push_back(*name);
    }
    check_axes(4);
  } else {
    names.push_back(value);
  }
  if (names.empty()) refuse_volume(file, fmt::format("its field '{}' does not name any files", field));
  std::vector<SampleBlock> blocks;
  for (const std::string& name : names) {
    const std::filesystem::path path(name);
    blocks.push_back({path.is_absolute() ? path : file.parent_path() / path, 0, 0, {}});
  }
  return blocks;
}

std::uint64_t after_lines(const std::filesystem::path& file, std::uint64_t begin, std::int64_t lines) {
  if (size_of_file(file) == 0) return begin;
  std::ifstream in(file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(begin));
  std::vector<char> block(1 << 16);
  std::uint64_t at = begin;
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    for (std::streamsize i = 0; i < in.gcount(); ++i, ++at)
      if (block[static_cast<std::size_t>(i)] == '\n' && --lines == 0) return at + 1;
  }
  return at;
}

std::uint64_t before_the_end(const std::filesystem::path& file, std::uint64_t bytes) {
  const std::uint64_t size = size_of_file(file);
  return size >= bytes ? size - bytes : size + 1;
}

}  // namespace quench::io
