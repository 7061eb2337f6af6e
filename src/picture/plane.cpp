// SPDX-License-Identifier: Apache-2.0
#include "picture/plane.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "picture/canvas.h"
#include "picture/frame.h"

namespace quench::picture {
namespace {

constexpr int kRows = 64;  ///< drawn at a time

/// Signed areas beside directed edges: summed up along a row they give how much of each pixel is inside (R. Levien,
/// font-rs, 2015).
class AreaRow {
 public:
  explicit AreaRow(int width) : sums_(static_cast<std::size_t>(width) + 2, 0), width_(width) {}
  void clear() { std::fill(sums_.begin(), sums_.end(), 0); }
  double operator[](int x) const { return sums_[static_cast<std::size_t>(x)]; }

  /// The part of an edge that crosses this row from x0 to x1, `height` of a row downwards (upwards: negative).
  void add(double x0, double x1, double height) {
    const double low = std::clamp(std::min(x0, x1), 0.0, double(width_)),
                 high = std::clamp(std::max(x0, x1), 0.0, double(width_));
    const int first = static_cast<int>(low), last = std::max(first, static_cast<int>(std::ceil(high)) - 1);
    // How much of the edge is left of x, and of each pixel right of the edge.
    double before = 0;
    for (int x = first; x <= last; ++x) {
      const double from = std::max<double>(x, low), to = std::min<double>(x + 1, high);
      const double share = high > low ? (to - from) / (high - low) : 1, covered = share * (x + 1 - (from + to) / 2);
      sums_[static_cast<std::size_t>(x)] += height * (before + covered);
      before = share - covered;
    }
    sums_[static_cast<std::size_t>(last) + 1] += height * before;
  }

 private:
  std::vector<double> sums_;
  int width_;
};

/// Calls cover(x, y, share covered, share of the way from a to b) for the pixels of rows [first, last) that a line with
/// round ends covers.
template <class Cover>
void each_pixel(const Point& a, const Point& b, double half, int width, int first, int last, const Cover& cover) {
  const double reach = half + 0.5, length2 = (b - a).squaredNorm();
  const auto row = [&](double y) { return static_cast<int>(std::floor(std::clamp<double>(y, first, last))); };
  const int top = row(std::min(a.y(), b.y()) - reach), bottom = row(std::max(a.y(), b.y()) + reach + 1);
  for (int y = top; y < bottom; ++y) {
    // Only what of the line is near this row.
    double t0 = 0, t1 = 1;
    if (std::abs(b.y() - a.y()) > 1e-9) {
      const double u = (y + 0.5 - reach - a.y()) / (b.y() - a.y()), v = (y + 0.5 + reach - a.y()) / (b.y() - a.y());
      t0 = std::clamp(std::min(u, v), 0.0, 1.0);
      t1 = std::clamp(std::max(u, v), 0.0, 1.0);
    }
    const double xa = a.x() + t0 * (b.x() - a.x()), xb = a.x() + t1 * (b.x() - a.x());
    const int left = static_cast<int>(std::clamp<double>(std::min(xa, xb) - reach, 0, width)),
              right = static_cast<int>(std::clamp<double>(std::max(xa, xb) + reach + 1, 0, width));
    for (int x = left; x < right; ++x) {
      const Point at(x + 0.5, y + 0.5);
      const double t = length2 > 0 ? std::clamp((at - a).dot(b - a) / length2, 0.0, 1.0) : 0;
      const double share = std::min(1.0, reach - (at - a - t * (b - a)).norm());
      if (share > 0) cover(x, y, static_cast<float>(share), static_cast<float>(t));
    }
  }
}

class Drawing {
 public:
  Drawing(const Scene& scene, const ViewState& state, const ColourRange& range, const Camera& camera, Picture& picture,
          double unit)
      : scene_(scene),
        state_(state),
        range_(range),
        picture_(picture),
        curve_half_((scene.curve_length > kManyCurves ? kThinPlaneCurveWidth : kPlaneCurveWidth) / 2 * unit),
        point_half_(curve_half_ + unit),
        outline_half_(kOutlineWidth * unit),
        outline_opacity_(opacity_of_outline(scene, 2 * outline_half_ * camera.per_pixel())),
        points_(on_picture(scene.points, camera)),
        shape_points_(on_picture(scene.shape_points, camera)),
        ground_(state.dark ? kDark : kLight) {}

  void rows(int first, int last) const {
    const auto count = static_cast<std::size_t>(picture_.width) * static_cast<std::size_t>(last - first);
    std::vector<float> outline(count, 0), line(count, 0);
    std::vector<Vec3f> colour(count, Vec3f::Zero());
    const auto at = [&](int x, int y) {
      return static_cast<std::size_t>(y - first) * static_cast<std::size_t>(picture_.width) +
             static_cast<std::size_t>(x);
    };
    for (const auto& [a, b] : scene_.outline)
      each_pixel(shape_points_[a], shape_points_[b], outline_half_, picture_.width, first, last,
                 [&](int x, int y, float share, float) { outline[at(x, y)] = std::max(outline[at(x, y)], share); });
    // Of lines that cover a pixel the one that covers most, so that joints are not heavier than lines.
    const auto take = [&](int x, int y, float share, const Vec3f& of) {
      if (share <= line[at(x, y)]) return;
      line[at(x, y)] = share;
      colour[at(x, y)] = of;
    };
    for (std::size_t i = 0; i < scene_.curves.size(); ++i) {
      const auto [a, b] = scene_.curves[i];
      each_pixel(
          points_[a], points_[b], curve_half_, picture_.width, first, last,
          [&, a = a, b = b](int x, int y, float share, float t) { take(x, y, share, curve_colour(i, a, b, t)); });
    }
    for (const std::uint32_t v : scene_.isolated)
      each_pixel(points_[v], points_[v], point_half_, picture_.width, first, last,
                 [&](int x, int y, float share, float) { take(x, y, share, value_colour(v, v, 0)); });

    const std::vector<std::vector<std::uint32_t>> crossing = edges_of_rows(first, last);
    AreaRow area(picture_.width);
    for (int y = first; y < last; ++y) {
      area.clear();
      for (const std::uint32_t e : crossing[static_cast<std::size_t>(y - first)]) add_area(e, y, area);
      const Vec3f ground = ground_at(y, picture_.height, state_.dark);
      double inside = 0;
      for (int x = 0; x < picture_.width; ++x) {
        inside += area[x];
        const auto filled = kPlaneFill * static_cast<float>(std::min(1.0, std::abs(inside)));
        Vec3f out = ground + (rgb(ground_.tint) - ground) * filled;
        out += (rgb(ground_.rim) - out) * (outline_opacity_ * outline[at(x, y)]);
        out += (colour[at(x, y)] - out) * line[at(x, y)];
        const std::size_t pixel =
            3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) + static_cast<std::size_t>(x));
        for (std::size_t i = 0; i < 3; ++i)
          picture_.pixels[pixel + i] =
              static_cast<std::uint8_t>(std::clamp(out[static_cast<Eigen::Index>(i)], 0.0F, 1.0F) * 255 + 0.5F);
      }
    }
  }

 private:
  static std::vector<Point> on_picture(const std::vector<Vec3f>& points, const Camera& camera) {
    std::vector<Point> out(points.size());
    base::for_indices(points.size(), [&](std::size_t i) {
      const Vec3 p = camera.view(points[i]).cast<double>();
      out[i] = Point(camera.centre_x(), camera.centre_y()) + Point(p.x(), -p.y()) * (camera.focus() / -p.z());
    });
    return out;
  }

  /// Outlines of thin shapes would cover them: the larger the share, the paler they are. `width`: scene units.
  static float opacity_of_outline(const Scene& scene, double width) {
    double area = 0, length = 0;
    for (std::size_t t = 0; t < scene.shape.size(); ++t) {
      const auto corner = [&](std::size_t i) { return scene.shape_points[scene.shape.corners[3 * t + i]]; };
      area += (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm() / 2;
    }
    for (const auto& [a, b] : scene.outline) length += (scene.shape_points[a] - scene.shape_points[b]).norm();
    return static_cast<float>(std::min(1.0, kOutlineCovers * area / std::max(length * width, 1e-300)));
  }

  std::vector<std::vector<std::uint32_t>> edges_of_rows(int first, int last) const {
    std::vector<std::vector<std::uint32_t>> rows(static_cast<std::size_t>(last - first));
    for (std::uint32_t e = 0; e < scene_.outline.size(); ++e) {
      const auto [low, high] =
          std::minmax(shape_points_[scene_.outline[e][0]].y(), shape_points_[scene_.outline[e][1]].y());
      const int begin = static_cast<int>(std::clamp<double>(std::floor(low), first, last)),
                end = static_cast<int>(std::clamp<double>(std::ceil(high), first, last));
      for (int y = begin; y < end; ++y) rows[static_cast<std::size_t>(y - first)].push_back(e);
    }
    return rows;
  }

  void add_area(std::uint32_t e, int y, AreaRow& area) const {
    const Point &a = shape_points_[scene_.outline[e][0]], &b = shape_points_[scene_.outline[e][1]];
    const auto [low, high] = std::minmax(a.y(), b.y());
    const double from = std::max<double>(y, low), to = std::min<double>(y + 1, high);
    if (!(from < to)) return;
    const auto x = [&](double at) { return a.x() + (at - a.y()) / (b.y() - a.y()) * (b.x() - a.x()); };
    area.add(x(from), x(to), b.y() > a.y() ? to - from : from - to);
  }

  Vec3f curve_colour(std::size_t curve, std::uint32_t a, std::uint32_t b, float t) const {
    return scene_.curve_parts.empty() ? value_colour(a, b, t) : rgb(kParts[scene_.curve_parts[curve] % kParts.size()]);
  }
  Vec3f value_colour(std::uint32_t a, std::uint32_t b, float t) const {
    if (scene_.values.empty()) return rgb(kAccent);
    const float value = scene_.values[a] + (scene_.values[b] - scene_.values[a]) * t;
    if (value > kCodeLimit) return rgb(kInfinite);
    if (value < -kCodeLimit) return rgb(kMissing);
    return colour_at(std::clamp((value - range_.low) / std::max(range_.high - range_.low, 1e-30), 0.0, 1.0));
  }

  const Scene& scene_;
  const ViewState& state_;
  const ColourRange& range_;
  Picture& picture_;
  double curve_half_, point_half_, outline_half_;  ///< pixels
  float outline_opacity_;
  std::vector<Point> points_, shape_points_;
  const Ground& ground_;
};

}  // namespace

Picture draw_plane(const Scene& scene, const ViewState& state, const ColourRange& range, const Camera& camera,
                   int width, int height, double unit, Context* context) {
  Picture picture{width, height, {}};
  picture.pixels.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const Drawing drawing(scene, state, range, camera, picture, unit);
  base::for_chunks(static_cast<std::size_t>((height + kRows - 1) / kRows), context, "picture", 0, 1,
                   [&](std::size_t chunk) {
                     const int first = static_cast<int>(chunk) * kRows;
                     drawing.rows(first, std::min(height, first + kRows));
                   });
  return picture;
}

}  // namespace quench::picture
