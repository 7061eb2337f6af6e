// SPDX-License-Identifier: Apache-2.0
#include "picture/primitives.h"

#include <cmath>

#include "base/parallel.h"
#include "quench/error.h"

namespace quench::picture {
namespace {

constexpr std::uint8_t kBoundary = 1, kSeam = 2;
constexpr int kEverywhere = 1 << 20;

std::vector<std::array<std::uint32_t, 3>> fans(const Polygons& polygons) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  triangles.reserve(polygons.corners.size());
  for (std::size_t f = 0; f < polygons.size(); ++f)
    for (std::uint32_t c = polygons.offsets[f] + 1; c + 1 < polygons.offsets[f + 1]; ++c)
      triangles.push_back({polygons.offsets[f], c, c + 1});
  return triangles;
}

std::vector<Vec3f> seen(const std::vector<Vec3f>& points, const Camera& camera) {
  std::vector<Vec3f> out(points.size());
  base::for_indices(points.size(), [&](std::size_t i) { out[i] = camera.view(points[i]); });
  return out;
}

Vec3f part_colour(std::uint32_t part) { return Light::linear(rgb(kParts[part % kParts.size()])); }

/// Lines of dense sheets would cover them: the larger the share, the paler they are.
float opacity_of_lines(std::size_t count, double width, double area, double per_pixel, float most) {
  if (!(area > 0)) return most;
  const double covered = static_cast<double>(count) * width * per_pixel / area;
  const double opacity = std::min<double>(most, kCovered / std::max(covered, 1e-9));
  return opacity < kPalest ? 0 : static_cast<float>(opacity);
}

Vec3f mixed(const std::array<Vec3f, 3>& of, const Vec3f& weights) {
  return of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2];
}

}  // namespace

Primitives::Primitives(const Scene& scene, const ViewState& state, const ColourRange& range, const Camera& camera,
                       double unit)
    : scene_(scene),
      light_(range, state.dark),
      focus_(camera.focus() * kSamples),
      centre_x_(camera.centre_x() * kSamples),
      centre_y_(camera.centre_y() * kSamples),
      near_(camera.near()),
      range_bias_((camera.far() - camera.near()) / (2 * camera.far() * camera.near())),
      curve_half_((scene.curve_length > kManyCurves ? kThinCurveWidth : kCurveWidth) / 2 * unit * kSamples),
      tube_half_(kTubeLeast * unit * kSamples),
      point_half_(curve_half_ + kPointMore * unit * kSamples),
      boundary_half_(kBoundaryWidth * unit * kSamples),
      seam_half_(kSeamWidth * unit * kSamples),
      boundary_colour_(rgb(state.dark ? kDark.boundary : kLight.boundary)),
      seam_colour_(rgb(kSeamColour)),
      points_(seen(scene.points, camera)),
      shape_points_(seen(scene.shape_points, camera)),
      normals_(crease_normals(points_, scene.sheets, scene.sheet_crease)),
      shape_normals_(crease_normals(shape_points_, scene.shape, scene.shape_crease)),
      sheets_(fans(scene.sheets)),
      shape_(fans(scene.shape)) {
  for (std::uint32_t f = 0; f < scene.sheets.size(); ++f)
    polygon_.insert(polygon_.end(), std::max(2U, scene.sheets.offsets[f + 1] - scene.sheets.offsets[f]) - 2, f);
  const double per_pixel = camera.per_pixel() * unit;
  boundary_opacity_ = opacity_of_lines(scene.boundary.size(), 2 * kBoundaryWidth, scene.area, per_pixel, kBoundaryMost);
  seam_opacity_ = opacity_of_lines(scene.seams.size(), 2 * kSeamWidth, scene.area, per_pixel, kSeamMost);
  if (scene.values.empty() && scene.sheet_values.empty())
    sheet_plain_ = Light::linear(rgb(state.dark ? kDark.sheet : kLight.sheet));
  if (scene.values.empty() || !state.curves_by_measure) curve_plain_ = Light::linear(rgb(kAccent));
  std::size_t end = 0;
  const auto after = [&](std::size_t count) {
    end += count;
    if (end >= kNone) throw Error(ErrorCode::usage, "a picture cannot hold that many cells");
    return static_cast<std::uint32_t>(end);
  };
  sheets_end_ = after(sheets_.size());
  curves_end_ = after(scene.curves.size());
  points_end_ = after(scene.isolated.size());
  boundary_end_ = after(boundary_opacity_ > 0 ? scene.boundary.size() : 0);
  lines_end_ = after(seam_opacity_ > 0 ? scene.seams.size() : 0);
  shape_end_ = after(shape_.size());
}

std::array<Vec3f, 3> Primitives::triangle(std::uint32_t id) const {
  const bool shape = is_shape(id);
  const Corners& c = shape ? shape_[id - lines_end_] : sheets_[id];
  const std::vector<Vec3f>& points = shape ? shape_points_ : points_;
  const std::vector<std::uint32_t>& corners = shape ? scene_.shape.corners : scene_.sheets.corners;
  return {points[corners[c[0]]], points[corners[c[1]]], points[corners[c[2]]]};
}

std::array<std::uint32_t, 2> Primitives::ends(std::uint32_t id) const {
  if (id < curves_end_) return scene_.curves[id - sheets_end_];
  if (id < points_end_) return {scene_.isolated[id - curves_end_], scene_.isolated[id - curves_end_]};
  return id < boundary_end_ ? scene_.boundary[id - points_end_] : scene_.seams[id - boundary_end_];
}

BarSetup Primitives::bar(std::uint32_t id) const {
  const auto [a, b] = ends(id);
  const Projected pa = projected(points_[a]), pb = projected(points_[b]);
  if (id < curves_end_)
    return {pa, pb, std::max(curve_half_, kCurveLeast * focus_ / pa.z()),
            std::max(curve_half_, kCurveLeast * focus_ / pb.z())};
  const double half = id < points_end_ ? point_half_ : id < boundary_end_ ? boundary_half_ : seam_half_;
  return {pa, pb, half, half};
}

double Primitives::tube_radius(std::uint32_t v) const {
  return std::max<double>(scene_.radius[v], tube_half_ * -points_[v].z() / focus_);
}

Tube Primitives::tube(std::uint32_t id) const {
  const auto [a, b] = ends(id);
  return {points_[a], points_[b], tube_radius(a), tube_radius(b)};
}

Box Primitives::box_of(std::uint32_t id) const {
  constexpr Box kNoBox{0, 0, 0, 0}, kAll{-kEverywhere, -kEverywhere, kEverywhere, kEverywhere};
  if (id >= sheets_end_ && !is_shape(id)) {
    const auto [a, b] = ends(id);
    if (!is_before_eye(a) || !is_before_eye(b)) return kNoBox;
    if (!is_tube(id)) return bar(id).box();
    // Of a ball with the centre z before the eye the outline is at most r / (z - r) from the middle.
    const auto half = [&](std::uint32_t v) {
      const double r = tube_radius(v);
      return r * focus_ / std::max(-points_[v].z() - r, near_);
    };
    return BarSetup(projected(points_[a]), projected(points_[b]), half(a), half(b)).box();
  }
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e18), high = -low;
  int before = 0;
  for (const Vec3f& corner : triangle(id)) {
    const Projected p = projected(corner);
    before += p.z() > near_;
    low = low.cwiseMin(p.head<2>() / p.z());
    high = high.cwiseMax(p.head<2>() / p.z());
  }
  if (before == 0) return kNoBox;
  if (before < 3) return kAll;
  const auto floor = [](double x) {
    return static_cast<int>(std::floor(std::clamp<double>(x, -kEverywhere, kEverywhere)));
  };
  // Only what has the middle of a sample inside.
  return {floor(low.x() - 0.51) + 1, floor(low.y() - 0.51) + 1, floor(high.x() + 0.51), floor(high.y() + 0.51)};
}

void Primitives::draw(std::uint32_t id, Tile& tile) const {
  if (id < sheets_end_ || is_shape(id)) {
    const auto corners = triangle(id);
    const TriangleSetup setup(projected(corners[0]), projected(corners[1]), projected(corners[2]));
    if (setup.visible) tile.draw(is_shape(id) ? tile.glass : tile.solid, setup, box_of(id), 1 / near_, id);
  } else if (is_tube(id)) {
    tile.draw(
        tube(id), [&](double x, double y) { return ray(x, y); }, box_of(id), id);
  } else if (id < points_end_) {
    tile.draw(bar(id), kCurveBias * range_bias_, id);
  } else {
    tile.draw_line(bar(id), kLineBias * range_bias_, id < boundary_end_ ? kBoundary : kSeam);
  }
}

Vec3f Primitives::colour_at(std::uint32_t id, double x, double y) const {
  if (id < sheets_end_) return colour_of_sheet(id, x, y);
  if (is_tube(id)) return colour_of_tube(id, x, y);
  return id < curves_end_ ? colour_of_curve(id, x, y) : colour_of_point(id, x, y);
}

Vec3f Primitives::colour_of_sheet(std::uint32_t id, double x, double y) const {
  const Corners& c = sheets_[id];
  const auto corners = triangle(id);
  const Vec3f w = TriangleSetup(projected(corners[0]), projected(corners[1]), projected(corners[2])).weights(x, y);
  Vec3f base;
  if (!scene_.sheet_parts.empty()) {
    base = part_colour(scene_.sheet_parts[polygon_[id]]);
  } else if (!scene_.sheet_values.empty()) {
    base = light_.colour_of(scene_.sheet_values[polygon_[id]]);
  } else if (sheet_plain_) {
    base = *sheet_plain_;
  } else {
    const auto value = [&](std::size_t i) { return scene_.values[scene_.sheets.corners[c[i]]]; };
    base = light_.colour_of(value(0) * w[0] + value(1) * w[1] + value(2) * w[2]);
  }
  std::array<Vec3f, 3> normals{normals_[c[0]], normals_[c[1]], normals_[c[2]]};
  // The sides of neighbours may differ.
  for (std::size_t i : {1, 2})
    if (normals[i].dot(normals[0]) < 0) normals[i] = -normals[i];
  return light_.lit(base, mixed(normals, w).normalized(), -mixed(corners, w).normalized(), kSheetGloss);
}

Vec3f Primitives::base_of_curve(std::uint32_t id, float share) const {
  if (!scene_.curve_parts.empty()) return part_colour(scene_.curve_parts[id - sheets_end_]);
  if (curve_plain_) return *curve_plain_;
  const auto [first, second] = ends(id);
  return light_.colour_of(scene_.values[first] * (1 - share) + scene_.values[second] * share);
}

Vec3f Primitives::colour_of_tube(std::uint32_t id, double x, double y) const {
  const Vec3 sight = ray(x, y);
  // The mean of samples on either side of a gap may be beside the tube.
  const auto hit = tube(id).hit(sight);
  const Vec3f normal = hit ? hit->normal : Vec3f(Vec3f::UnitZ());
  return light_.lit(base_of_curve(id, hit ? static_cast<float>(hit->share) : 0.5F), normal,
                    -sight.normalized().cast<float>(), kCurveGloss);
}

Vec3f Primitives::colour_of_curve(std::uint32_t id, double x, double y) const {
  const BarSetup b = bar(id);
  const double t = b.share(x, y);
  const auto share = static_cast<float>(t * b.depth_b / b.depth(t));  // along the bar, not on the screen
  const Vec3f base = base_of_curve(id, share);
  // Bent around the line only, also at the round ends: else every joint would be a bead.
  const Eigen::Vector2d at(x - b.a.x(), y - b.a.y());
  const Eigen::Vector2d along =
      b.length2 > 1e-4 ? Eigen::Vector2d(b.along / std::sqrt(b.length2)) : Eigen::Vector2d(0, 0);
  const Eigen::Vector2f s = ((at - along * at.dot(along)) / std::max(b.half(t), double{kSamples})).cast<float>();
  const Vec3f normal(s.x(), -s.y(), std::sqrt(std::max(0.0F, 1 - s.squaredNorm())));
  return light_.lit(base, normal, Vec3f::UnitZ(), kCurveGloss);
}

Vec3f Primitives::colour_of_point(std::uint32_t id, double x, double y) const {
  const BarSetup b = bar(id);
  const auto sx = static_cast<float>((x - b.a.x()) / b.half_a), sy = static_cast<float>((y - b.a.y()) / b.half_a);
  const Vec3f normal(sx, -sy, std::sqrt(std::max(0.0F, 1 - sx * sx - sy * sy)));
  return light_.lit(point_colour(ends(id)[0]), normal, Vec3f::UnitZ(), kBallGloss);
}

Light::Glass Primitives::glass_at(std::uint32_t id, double x, double y) const {
  const Corners& c = shape_[id - lines_end_];
  const auto corners = triangle(id);
  const Vec3f w = TriangleSetup(projected(corners[0]), projected(corners[1]), projected(corners[2])).weights(x, y);
  const Vec3f normal = mixed({shape_normals_[c[0]], shape_normals_[c[1]], shape_normals_[c[2]]}, w).normalized();
  return light_.glass(normal, -mixed(corners, w).normalized());
}

Vec3f Primitives::under_lines(const Vec3f& colour, std::uint8_t kinds) const {
  Vec3f out = colour;
  if (kinds & kBoundary) out += (boundary_colour_ - out) * boundary_opacity_;
  if (kinds & kSeam) out += (seam_colour_ - out) * seam_opacity_;
  return out;
}

}  // namespace quench::picture
