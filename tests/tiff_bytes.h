// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace quench::testing_tiff {

struct TiffOptions {
  std::uint32_t bits = 8;
  std::uint32_t format = 1;       ///< 1: unsigned, 2: signed, 3: float
  std::uint32_t photometric = 1;  ///< 0: white is 0, 1: black is 0
  bool big_endian = false;        ///< of the directories; samples are given in this order
};

/// A grey TIFF, one uncompressed strip per page.
inline std::string tiff(std::uint16_t width, std::uint16_t height, const std::vector<std::string>& pages,
                        const TiffOptions& options = {}) {
  std::string file = options.big_endian ? std::string("MM\0*", 4) : std::string("II*\0", 4);
  const auto put = [&](std::uint32_t v, int bytes) {
    for (int b = 0; b < bytes; ++b) file += static_cast<char>(v >> (8 * (options.big_endian ? bytes - 1 - b : b)));
  };
  put(8, 4);
  for (std::size_t p = 0; p < pages.size(); ++p) {
    const std::array<std::array<std::uint32_t, 2>, 10> entries{{{256, width},
                                                                {257, height},
                                                                {258, options.bits},
                                                                {259, 1},
                                                                {262, options.photometric},
                                                                {273, 0},
                                                                {277, 1},
                                                                {278, height},
                                                                {279, static_cast<std::uint32_t>(pages[p].size())},
                                                                {339, options.format}}};
    const auto directory = static_cast<std::uint32_t>(file.size());
    const auto strip = directory + 2 + 12 * static_cast<std::uint32_t>(entries.size()) + 4;
    put(static_cast<std::uint32_t>(entries.size()), 2);
    for (const auto& [tag, value] : entries) {
      const bool is_long = tag == 273 || tag == 279;
      put(tag, 2);
      put(is_long ? 4 : 3, 2);
      put(1, 4);
      if (is_long) {
        put(tag == 273 ? strip : value, 4);
      } else {
        put(value, 2);
        put(0, 2);
      }
    }
    const bool last = p + 1 == pages.size();
    const std::string padding(pages[p].size() % 2, '\0');
    put(last ? 0 : strip + static_cast<std::uint32_t>(pages[p].size() + padding.size()), 4);
    file += pages[p] + padding;
  }
  return file;
}

}  // namespace quench::testing_tiff
