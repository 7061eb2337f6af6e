// SPDX-License-Identifier: Apache-2.0
#include "picture/frame.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "base/parallel.h"
#include "picture/primitives.h"
#include "picture/tile.h"

namespace quench::picture {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();

/// A pixel before the light of the dome: what the dome shades, what it does not, and how far the nearest is.
struct Pixel {
  std::array<std::uint16_t, 3> shaded{}, plain{};
  float solid = kNothing;  ///< log2 of the distance
  float glass = kNothing;  ///< the same of glass that is seen
};

constexpr float kFull = 65535;

std::uint16_t packed(float x) { return static_cast<std::uint16_t>(std::clamp(x, 0.0F, 1.0F) * kFull + 0.5F); }

/// Which primitives each tile may show, in their order.
class Bins {
 public:
  Bins(const Primitives& primitives, int columns, int rows) : columns_(columns), rows_(rows) {
    const std::size_t tiles = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    constexpr std::size_t kChunks = 16;
    std::vector<std::vector<std::uint32_t>> counts(kChunks, std::vector<std::uint32_t>(tiles, 0));
    for_tiles(primitives, kChunks, [&](std::size_t chunk, std::uint32_t, std::size_t tile) { ++counts[chunk][tile]; });
    begin_.assign(tiles + 1, 0);
    for (std::size_t t = 0; t < tiles; ++t) {
      std::size_t at = begin_[t];
      for (auto& count : counts) at += std::exchange(count[t], static_cast<std::uint32_t>(at - begin_[t]));
      begin_[t + 1] = at;
    }
    ids_.resize(begin_.back());
    for_tiles(primitives, kChunks, [&](std::size_t chunk, std::uint32_t id, std::size_t tile) {
      ids_[begin_[tile] + counts[chunk][tile]++] = id;
    });
  }
  std::span<const std::uint32_t> of(std::size_t tile) const {
    return std::span(ids_).subspan(begin_[tile], begin_[tile + 1] - begin_[tile]);
  }

 private:
  template <class Body>
  void for_tiles(const Primitives& primitives, std::size_t chunks, const Body& body) const {
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(primitives.count(), chunk, chunks);
      for (auto id = static_cast<std::uint32_t>(first); id < last; ++id) {
        const Box b = primitives.box_of(id).cut({0, 0, columns_ * kTileSamples, rows_ * kTileSamples});
        if (b.empty()) continue;
        for (int y = b.y0 / kTileSamples; y <= (b.y1 - 1) / kTileSamples; ++y)
          for (int x = b.x0 / kTileSamples; x <= (b.x1 - 1) / kTileSamples; ++x)
            body(chunk, id,
                 static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x));
      }
    });
  }

  int columns_, rows_;
  std::vector<std::size_t> begin_;
  std::vector<std::uint32_t> ids_;
};

/// The primitives seen through the samples of one pixel. Each is asked for its colour once, in the middle of its
/// samples.
template <class Colour>
class Seen {
 public:
  void clear() { count_ = 0; }
  std::size_t add(std::uint32_t id, int x, int y) {
    std::size_t i = 0;
    while (i < count_ && entries_[i].id != id) ++i;
    Entry& entry = entries_[i];
    if (i == count_) {
      ++count_;
      entry.id = id;
      entry.samples = 0;
      entry.x = entry.y = 0;
    }
    ++entry.samples;
    entry.x += x + 0.5;
    entry.y += y + 0.5;
    return i;
  }
  template <class Of>
  void colour(const Of& of) {
    for (std::size_t i = 0; i < count_; ++i) {
      Entry& e = entries_[i];
      e.colour = of(e.id, e.x / e.samples, e.y / e.samples);
    }
  }
  const Colour& operator[](std::size_t i) const { return entries_[i].colour; }

 private:
  struct Entry {
    std::uint32_t id;
    int samples;
    double x, y;
    Colour colour;
  };
  std::array<Entry, kSamples * kSamples> entries_;
  std::size_t count_ = 0;
};

class Resolver {
 public:
  explicit Resolver(const Primitives& primitives) : primitives_(primitives) {}

  /// The samples of a tile that belong to the pixel (px, py), before `ground`.
  Pixel pixel(const Tile& tile, int px, int py, const Vec3f& ground) {
    constexpr std::size_t kCount = kSamples * kSamples;
    std::array<std::size_t, kCount> solid, glass;
    solid_.clear();
    glass_.clear();
    Pixel pixel;
    bool empty = true;
    float nearest_solid = 0, nearest_glass = 0;
    for (std::size_t s = 0; s < kCount; ++s) {
      const int x = px * kSamples + static_cast<int>(s) % kSamples, y = py * kSamples + static_cast<int>(s) / kSamples;
      const std::size_t at = tile.at(x, y);
      solid[s] = glass[s] = kCount;
      if (tile.solid.id[at] != kNone) solid[s] = solid_.add(tile.solid.id[at], x, y);
      if (tile.glass.id[at] != kNone && tile.glass.depth[at] >= tile.solid.depth[at])
        glass[s] = glass_.add(tile.glass.id[at], x, y);
      nearest_solid = std::max(nearest_solid, tile.solid.depth[at]);
      if (glass[s] < kCount) nearest_glass = std::max(nearest_glass, tile.glass.depth[at]);
      empty &= solid[s] == kCount && glass[s] == kCount && tile.line[at] == 0;
    }
    if (nearest_solid > 0) pixel.solid = -std::log2(nearest_solid);
    if (nearest_glass > 0) pixel.glass = -std::log2(nearest_glass);
    Vec3f shaded = Vec3f::Zero(), plain = ground;
    if (!empty) {
      solid_.colour([&](std::uint32_t id, double x, double y) { return primitives_.colour_at(id, x, y); });
      glass_.colour([&](std::uint32_t id, double x, double y) { return primitives_.glass_at(id, x, y); });
      plain.setZero();
      for (std::size_t s = 0; s < kCount; ++s) {
        const std::size_t at =
            tile.at(px * kSamples + static_cast<int>(s) % kSamples, py * kSamples + static_cast<int>(s) / kSamples);
        const bool is_solid = solid[s] < kCount;
        const Vec3f colour = primitives_.under_lines(is_solid ? solid_[solid[s]] : ground, tile.line[at]);
        const float opacity = glass[s] < kCount ? glass_[glass[s]].opacity : 0;
        (is_solid ? shaded : plain) += colour * (1 - opacity);
        if (opacity > 0) plain += glass_[glass[s]].colour * opacity;
      }
      shaded /= static_cast<float>(kCount);
      plain /= static_cast<float>(kCount);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      pixel.shaded[i] = packed(shaded[static_cast<Eigen::Index>(i)]);
      pixel.plain[i] = packed(plain[static_cast<Eigen::Index>(i)]);
    }
    return pixel;
  }

 private:
  const Primitives& primitives_;
  Seen<Vec3f> solid_;
  Seen<Light::Glass> glass_;
};

/// Eye-dome lighting (after Boucheny): what lies behind its neighbours on the screen is darker, so sheets that are flat
/// and of one colour stand apart.
class Dome {
 public:
  /// `first`: the row that the pixels begin with.
  Dome(const std::vector<Pixel>& pixels, int first, int width, int height, double unit, bool dark)
      : pixels_(pixels), first_(first), width_(width), height_(height), strength_(dark ? kDomeDark : kDomeLight) {
    for (int i = 0; i < 8; ++i) {
      const double angle = std::numbers::pi / 4 * i + 0.3;
      offsets_[static_cast<std::size_t>(i)] = Eigen::Vector2d(std::cos(angle), -std::sin(angle)) * (kDomeReach * unit);
    }
  }
  const Pixel& pixel(int x, int y) const {
    return pixels_[static_cast<std::size_t>(y - first_) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(x)];
  }
  float shade(int x, int y) const {
    const float here = pixel(x, y).solid;
    if (here == kNothing) return 1;
    return std::exp(-strength_ * (occlusion(x, y, here, 1) + kDomeFartherWeight * occlusion(x, y, here, kDomeFarther)));
  }

  /// How much of the surroundings lies behind the glass here, 0 to 1: its outlines. What only goes on as a plane does
  /// is not behind it.
  float outline(int x, int y) const {
    const float glass = pixel(x, y).glass;
    if (glass == kNothing) return 0;
    std::array<float, 8> behind{};
    for (std::size_t i = 0; i < offsets_.size(); ++i) {
      const Pixel& other = neighbour(x, y, offsets_[i]);
      behind[i] = std::min({other.glass, other.solid, glass + 1}) - glass;
    }
    float sum = 0;
    for (std::size_t i = 0; i < behind.size(); ++i) {
      const float step = behind[i] + std::min(0.0F, behind[(i + 4) % 8]);
      sum += std::clamp(step / kOutlineStep - 1, 0.0F, 1.0F);
    }
    return sum / 8;
  }

 private:
  const Pixel& neighbour(int x, int y, const Eigen::Vector2d& offset) const {
    const int nx = static_cast<int>(std::floor(x + 0.5 + offset.x())),
              ny = static_cast<int>(std::floor(y + 0.5 + offset.y()));
    return pixel(std::clamp(nx, 0, width_ - 1), std::clamp(ny, 0, height_ - 1));
  }
  float occlusion(int x, int y, float here, double reach) const {
    float sum = 0;
    for (const Eigen::Vector2d& offset : offsets_) {
      sum += std::clamp(here - neighbour(x, y, offset * reach).solid, 0.0F, kDomeMost);
    }
    return sum / 8;
  }
  const std::vector<Pixel>& pixels_;
  int first_, width_, height_;
  float strength_;
  std::array<Eigen::Vector2d, 8> offsets_;
};

}  // namespace

Vec3f ground_at(int y, int height, bool dark) {
  const Ground& ground = dark ? kDark : kLight;
  const float t = 1 - (static_cast<float>(y) + 0.5F) / static_cast<float>(height);
  return rgb(ground.bottom) + (rgb(ground.top) - rgb(ground.bottom)) * (t * t * (3 - 2 * t));
}

Picture draw_scene(const Scene& scene, const ViewState& state, const ColourRange& range, const Camera& camera,
                   int width, int height, double unit, Context* context, int band) {
  const Primitives primitives(scene, state, range, camera, unit);
  const int columns = (width + kTile - 1) / kTile, rows = (height + kTile - 1) / kTile;
  const Bins bins(primitives, columns, rows);
  const auto across = static_cast<std::size_t>(width);
  Picture picture{width, height, std::vector<std::uint8_t>(3 * across * static_cast<std::size_t>(height))};
  const Vec3f rim = rgb(state.dark ? kDark.rim : kLight.rim);
  const int margin = static_cast<int>(kDomeReach * kDomeFarther * unit) + 1;
  std::vector<Pixel> pixels;
  // In bands, as far as the light of the dome reaches drawn twice, so that large pictures need little memory.
  for (int y0 = 0; y0 < height; y0 += band) {
    const int y1 = std::min(height, y0 + band), tile0 = std::max(0, y0 - margin) / kTile;
    const int tile1 = std::min(rows, (y1 + margin + kTile - 1) / kTile), first = tile0 * kTile;
    const double done = static_cast<double>(y0) / height, next = static_cast<double>(y1) / height;
    pixels.resize(across * static_cast<std::size_t>(std::min(tile1 * kTile, height) - first));
    const auto draw_tiles = [&](std::size_t chunk) {
      const int row = tile0 + static_cast<int>(chunk);
      Tile tile;
      Resolver resolver(primitives);
      for (int column = 0; column < columns; ++column) {
        const int left = column * kTile, top = row * kTile;
        tile.begin({left * kSamples, top * kSamples, left * kSamples + kTileSamples, top * kSamples + kTileSamples});
        for (const std::uint32_t id : bins.of(static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                                              static_cast<std::size_t>(column)))
          primitives.draw(id, tile);
        for (int y = top; y < std::min(top + kTile, height); ++y)
          for (int x = left; x < std::min(left + kTile, width); ++x)
            pixels[static_cast<std::size_t>(y - first) * across + static_cast<std::size_t>(x)] =
                resolver.pixel(tile, x, y, ground_at(y, height, state.dark));
      }
    };
    base::for_chunks(static_cast<std::size_t>(tile1 - tile0), context, "picture", done, 0.1 * done + 0.9 * next,
                     draw_tiles);
    const Dome dome(pixels, first, width, height, unit, state.dark);
    const auto light_row = [&](std::size_t chunk) {
      const int y = y0 + static_cast<int>(chunk);
      for (int x = 0; x < width; ++x) {
        const Pixel& pixel = dome.pixel(x, y);
        const float shade = dome.shade(x, y), outline = kOutline * dome.outline(x, y);
        for (std::size_t i = 0; i < 3; ++i) {
          const float plain =
              (static_cast<float>(pixel.shaded[i]) * shade + static_cast<float>(pixel.plain[i])) / kFull;
          const float outlined = std::min(plain, 1.0F) * (1 - outline) + rim[static_cast<Eigen::Index>(i)] * outline;
          picture.pixels[3 * (static_cast<std::size_t>(y) * across + static_cast<std::size_t>(x)) + i] =
              static_cast<std::uint8_t>(outlined * 255 + 0.5F);
        }
      }
    };
    base::for_chunks(static_cast<std::size_t>(y1 - y0), context, "picture", 0.1 * done + 0.9 * next, next, light_row);
  }
  return picture;
}

}  // namespace quench::picture
