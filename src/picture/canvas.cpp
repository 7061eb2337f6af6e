// SPDX-License-Identifier: Apache-2.0
#include "picture/canvas.h"

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include <algorithm>
#include <cmath>

#include "picture/font.h"
#include "quench/error.h"

namespace quench::picture {
namespace {

/// The next code point, and the text behind it; of bytes that are no UTF-8 the replacement character.
char32_t take_letter(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(0);
  const std::size_t length = first < 0x80 ? 1 : first >> 5 == 6 ? 2 : first >> 4 == 14 ? 3 : first >> 3 == 30 ? 4 : 0;
  char32_t letter = length < 2 ? first : first & (0x7FU >> length);
  bool good = length > 0;
  for (std::size_t i = 1; i < length; ++i) {
    good &= byte(i) >> 6 == 2;
    letter = letter << 6 | (byte(i) & 63U);
  }
  text.remove_prefix(good ? length : 1);
  return good ? letter : U'\uFFFD';
}

}  // namespace

struct Canvas::Letters {
  FT_Library library = nullptr;
  FT_Face face = nullptr;

  Letters() {
    const std::string_view font = font_file();
    if (FT_Init_FreeType(&library) != 0)
      throw Error(ErrorCode::failed, "FreeType cannot be started: not enough memory");
    if (FT_New_Memory_Face(library, reinterpret_cast<const FT_Byte*>(font.data()), static_cast<FT_Long>(font.size()), 0,
                           &face) != 0) {
      FT_Done_FreeType(library);
      throw Error(ErrorCode::invariant, "the font that is built in is damaged");
    }
  }
  Letters(const Letters&) = delete;
  Letters& operator=(const Letters&) = delete;
  ~Letters() {
    FT_Done_Face(face);
    FT_Done_FreeType(library);
  }

  /// Calls glyph(slot, pen) for each letter, as outlines; returns the width. Places are fractions of pixels, so that
  /// letters keep their distances at every size.
  template <class Glyph>
  double set(std::string_view text, double size, const Glyph& glyph) {
    FT_Set_Char_Size(face, 0, static_cast<FT_F26Dot6>(std::lround(size * 64)), 72, 72);
    double pen = 0;
    while (!text.empty()) {
      if (FT_Load_Char(face, take_letter(text), FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP) != 0) continue;
      glyph(face->glyph, pen);
      pen += static_cast<double>(face->glyph->linearHoriAdvance) / 65536;
    }
    return pen;
  }
};

Canvas::Canvas(Picture& picture) : picture_(picture), letters_(std::make_unique<Letters>()) {}
Canvas::~Canvas() = default;

double Canvas::width_of(const std::string& text, double size) {
  return letters_->set(text, size, [](FT_GlyphSlot, double) {});
}

std::string Canvas::fitted(const std::string& text, double size, double width) {
  if (width_of(text, size) <= width) return text;
  std::string_view rest = text;
  std::string shorter;
  while (!rest.empty()) {
    const std::string_view before = rest;
    take_letter(rest);
    std::string longer = shorter + std::string(before.substr(0, before.size() - rest.size()));
    if (width_of(longer + "…", size) > width) break;
    shorter = std::move(longer);
  }
  return shorter.empty() ? shorter : shorter + "…";
}

void Canvas::write(const std::string& text, double size, const Point& at, const Vec3f& colour) {
  letters_->set(text, size, [&](FT_GlyphSlot slot, double pen) {
    const double x = at.x() + pen, y = at.y();
    FT_Outline_Translate(&slot->outline, std::lround((x - std::floor(x)) * 64), std::lround((std::ceil(y) - y) * 64));
    if (FT_Render_Glyph(slot, FT_RENDER_MODE_NORMAL) != 0) return;
    const FT_Bitmap& map = slot->bitmap;
    for (unsigned r = 0; r < map.rows; ++r)
      for (unsigned c = 0; c < map.width; ++c)
        blend(static_cast<int>(std::floor(x)) + slot->bitmap_left + static_cast<int>(c),
              static_cast<int>(std::ceil(y)) - slot->bitmap_top + static_cast<int>(r), colour,
              static_cast<float>(
                  map.buffer[static_cast<std::ptrdiff_t>(r) * map.pitch + static_cast<std::ptrdiff_t>(c)]) /
                  255);
  });
}

void Canvas::fill(std::span<const Point> corners, const Vec3f& colour) {
  constexpr int kSide = 4;  // samples along a side of a pixel
  Point low = corners[0], high = corners[0];
  for (const Point& p : corners) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const auto inside = [&](double x, double y) {
    bool in = false;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
      if ((a.y() > y) != (b.y() > y) && x < a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) in = !in;
    }
    return in;
  };
  const int x0 = std::max(0, static_cast<int>(std::floor(low.x()))),
            x1 = std::min<int>(picture_.width, static_cast<int>(std::ceil(high.x())));
  const int y0 = std::max(0, static_cast<int>(std::floor(low.y()))),
            y1 = std::min<int>(picture_.height, static_cast<int>(std::ceil(high.y())));
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      int hits = 0;
      for (int s = 0; s < kSide * kSide; ++s)
        hits += inside(x + (s % kSide + 0.5) / kSide, y + (s / kSide + 0.5) / kSide);
      blend(x, y, colour, static_cast<float>(hits) / (kSide * kSide));
    }
}

void Canvas::fill_box(const Point& low, const Point& high, const Vec3f& colour) {
  const Point corners[] = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  fill(corners, colour);
}

void Canvas::stroke(const Point& a, const Point& b, double width, const Vec3f& colour) {
  const Point along = b - a;
  if (!(along.norm() > 0)) return;
  const Point across = Point(-along.y(), along.x()) / along.norm() * (width / 2);
  const Point corners[] = {a + across, b + across, b - across, a - across};
  fill(corners, colour);
}

void Canvas::blend(int x, int y, const Vec3f& colour, float cover) {
  if (x < 0 || y < 0 || x >= picture_.width || y >= picture_.height || cover <= 0) return;
  std::uint8_t* const pixel =
      &picture_.pixels[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) +
                            static_cast<std::size_t>(x))];
  for (int i = 0; i < 3; ++i) {
    const float old = pixel[i];
    pixel[i] = static_cast<std::uint8_t>(old + (colour[i] * 255 - old) * cover + 0.5F);
  }
}

}  // namespace quench::picture
