// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

/// TIFF files by hand, so that the tests do not depend on the library that reads them.
namespace quench::testing_tiff {

struct TiffTag {
  std::uint32_t tag, type;
  std::uint64_t count;
  std::string bytes;  ///< in the byte order of the file
};

struct TiffOptions {
  std::uint32_t bits = 8;
  std::uint32_t format = 1;       ///< 1: unsigned, 2: signed, 3: float
  std::uint32_t photometric = 1;  ///< 0: white is 0, 1: black is 0, 3: palette
  bool big_endian = false;        ///< of the directories; samples are given in this order
  bool big_tiff = false;
  std::uint32_t compression = 1;         ///< the pages are given as it leaves them
  std::uint32_t rows_per_strip = 0;      ///< 0: a strip per page
  std::vector<std::uint32_t> tile = {};  ///< width, height (and depth) of tiles instead of strips
  std::uint32_t depth = 1;               ///< planes of a page
  std::uint32_t samples = 1;             ///< per pixel
  std::vector<TiffTag> tags = {};        ///< of all pages, beside these
};

/// Writes a file page by page.
class TiffBytes {
 public:
  explicit TiffBytes(bool big_endian = false, bool big_tiff = false) : big_endian_(big_endian), big_tiff_(big_tiff) {
    file_ = big_endian ? "MM" : "II";
    file_ += number(big_tiff ? 43 : 42, 2);
    if (big_tiff) file_ += number(8, 2) + number(0, 2);
    link_ = file_.size();
    file_ += offset(0);
  }

  std::string number(std::uint64_t v, int bytes) const {
    std::string text;
    for (int b = 0; b < bytes; ++b) text += static_cast<char>(v >> (8 * (big_endian_ ? bytes - 1 - b : b)) & 0xFF);
    return text;
  }
  TiffTag shorts(std::uint32_t tag, const std::vector<std::uint32_t>& values) const { return numbers(tag, 3, values); }
  TiffTag longs(std::uint32_t tag, const std::vector<std::uint32_t>& values) const { return numbers(tag, 4, values); }
  TiffTag rational(std::uint32_t tag, std::uint32_t numerator, std::uint32_t denominator) const {
    return {tag, 5, 1, number(numerator, 4) + number(denominator, 4)};
  }
  static TiffTag text(std::uint32_t tag, const std::string& words) { return {tag, 2, words.size() + 1, words + '\0'}; }

  /// `pieces` are the strips or tiles.
  void page(std::uint32_t width, std::uint32_t height, const std::vector<std::string>& pieces, const TiffOptions& o) {
    std::vector<TiffTag> tags = o.tags;
    std::vector<std::uint32_t> sizes;
    for (const std::string& piece : pieces) sizes.push_back(static_cast<std::uint32_t>(piece.size()));
    for (TiffTag tag :
         {longs(256, {width}), longs(257, {height}), shorts(258, std::vector<std::uint32_t>(o.samples, o.bits)),
          shorts(259, {o.compression}), shorts(262, {o.photometric}), shorts(277, {o.samples}),
          shorts(339, std::vector<std::uint32_t>(o.samples, o.format))})
      tags.push_back(std::move(tag));
    if (o.depth != 1) tags.push_back(longs(32997, {o.depth}));
    if (o.tile.empty()) {
      tags.push_back(longs(278, {o.rows_per_strip ? o.rows_per_strip : height}));
    } else {
      tags.push_back(longs(322, {o.tile[0]}));
      tags.push_back(longs(323, {o.tile[1]}));
      if (o.tile.size() > 2) tags.push_back(longs(32998, {o.tile[2]}));
    }
    tags.push_back(longs(o.tile.empty() ? 279 : 325, sizes));
    const std::uint32_t offsets = o.tile.empty() ? 273 : 324;
    tags.push_back(longs(offsets, sizes));  // of the same length: filled in below
    for (std::size_t i = 1; i < tags.size(); ++i)
      for (std::size_t k = i; k > 0 && tags[k].tag < tags[k - 1].tag; --k) std::swap(tags[k], tags[k - 1]);
    append(tags, offsets, pieces);
  }

  /// Where the last directory begins, and its link to the next.
  std::size_t directory() const { return directory_; }
  std::size_t link() const { return link_; }
  const std::string& file() const { return file_; }

 private:
  std::string offset(std::uint64_t v) const { return number(v, big_tiff_ ? 8 : 4); }
  TiffTag numbers(std::uint32_t tag, std::uint32_t type, const std::vector<std::uint32_t>& values) const {
    TiffTag result{tag, type, values.size(), {}};
    for (const std::uint32_t v : values) result.bytes += number(v, type == 3 ? 2 : 4);
    return result;
  }

  void append(std::vector<TiffTag>& tags, std::uint32_t offsets, const std::vector<std::string>& pieces) {
    const std::size_t inlined = big_tiff_ ? 8 : 4, count = big_tiff_ ? 8 : 2, entry = big_tiff_ ? 20 : 12;
    if (file_.size() % 2) file_ += '\0';
    directory_ = file_.size();
    file_.replace(link_, inlined, offset(directory_));
    link_ = directory_ + count + entry * tags.size();
    std::size_t end = link_ + inlined;
    for (const TiffTag& tag : tags)
      if (tag.bytes.size() > inlined) end += tag.bytes.size();
    for (TiffTag& tag : tags) {
      if (tag.tag != offsets) continue;
      tag.bytes.clear();
      std::size_t at = end;
      for (const std::string& piece : pieces) {
        tag.bytes += number(at, 4);
        at += piece.size();
      }
    }
    std::string behind;
    file_ += number(tags.size(), static_cast<int>(count));
    for (const TiffTag& tag : tags) {
      file_ += number(tag.tag, 2) + number(tag.type, 2) + offset(tag.count);
      if (tag.bytes.size() > inlined) {
        file_ += offset(link_ + inlined + behind.size());
        behind += tag.bytes;
      } else {
        file_ += tag.bytes + std::string(inlined - tag.bytes.size(), '\0');
      }
    }
    file_ += offset(0) + behind;
    for (const std::string& piece : pieces) file_ += piece;
  }

  bool big_endian_, big_tiff_;
  std::string file_;
  std::size_t link_ = 0, directory_ = 0;
};

/// A grey TIFF, one strip per page.
inline std::string tiff(std::uint32_t width, std::uint32_t height, const std::vector<std::string>& pages,
                        const TiffOptions& options = {}) {
  TiffBytes bytes(options.big_endian, options.big_tiff);
  for (const std::string& page : pages) bytes.page(width, height, {page}, options);
  return bytes.file();
}

/// The description and the resolution of ImageJ, `per_unit` pixels in a millionth.
inline std::vector<TiffTag> imagej_tags(const std::string& description, std::uint32_t per_unit,
                                        bool big_endian = false) {
  const TiffBytes b(big_endian);
  return {TiffBytes::text(270, description), b.rational(282, per_unit, 1000000), b.rational(283, per_unit, 1000000),
          b.shorts(296, {1})};
}

}  // namespace quench::testing_tiff
