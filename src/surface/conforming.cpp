// SPDX-License-Identifier: Apache-2.0
#include "surface/conforming.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

#include "surface/box_tree.h"
#include "surface/facet.h"

namespace quench::surface {
namespace {

std::vector<Bounds> boxes_of(std::span<const Vec3> points, std::span<const std::uint32_t> which) {
  std::vector<Bounds> boxes(which.size());
  for (std::size_t i = 0; i < which.size(); ++i) boxes[i].add(points[which[i]]);
  return boxes;
}

class Conforming {
 public:
  Conforming(std::vector<Vec3> points, std::vector<std::uint32_t> loose, double near)
      : near_(near), loose_(sorted(std::move(loose))), tree_(boxes_of(points, loose_)) {
    result_.points = std::move(points);
    same_.resize(result_.points.size());
    std::iota(same_.begin(), same_.end(), 0u);
    for (const std::uint32_t p : loose_) {
      for_each_loose({result_.points[p], result_.points[p]}, [&](std::uint32_t q) {
        if (q < same_[p] && (result_.points[q] - result_.points[p]).norm() <= near_) same_[p] = q;
      });
      same_[p] = same_[same_[p]];
    }
  }

  void add(const Face& face) {
    const Face corners = with_loose(face);
    if (corners.size() == 3) {
      result_.triangles.push_back({corners[0], corners[1], corners[2]});
    } else if (corners.size() > 3 && !add_fan(corners)) {
      Vec3 middle = Vec3::Zero();
      for (const std::uint32_t c : corners) middle += result_.points[c] / static_cast<double>(corners.size());
      const auto centre = static_cast<std::uint32_t>(result_.points.size());
      result_.points.push_back(middle);
      for (std::size_t i = 0; i < corners.size(); ++i)
        result_.triangles.push_back({corners[i], corners[(i + 1) % corners.size()], centre});
    }
  }

  TriangleMesh take() { return std::move(result_); }

 private:
  static std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> loose) {
    std::sort(loose.begin(), loose.end());
    loose.erase(std::unique(loose.begin(), loose.end()), loose.end());
    return loose;
  }

  template <class Visit>
  void for_each_loose(const std::array<Vec3, 2>& ends, const Visit& visit) const {
    Bounds box;
    for (const Vec3& p : ends) box.add(p);
    tree_.visit([&](const Bounds& other) { return other.meets(box, near_); },
                [&](std::uint32_t i) { visit(loose_[i]); });
  }

  /// The corners of a face and the points on its sides, each once.
  Face with_loose(const Face& face) const {
    Face corners;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::uint32_t a = same_[face[i]], b = same_[face[(i + 1) % face.size()]];
      if (a == b) continue;
      corners.push_back(a);
      const Vec3 from = result_.points[a], along = result_.points[b] - from;
      const double length = along.norm();
      std::vector<std::pair<double, std::uint32_t>> on_side;
      for_each_loose({from, result_.points[b]}, [&](std::uint32_t p) {
        if (same_[p] != p) return;
        const double t = along.dot(result_.points[p] - from) / length;
        if (t <= near_ || t >= length - near_) return;
        if ((result_.points[p] - from - t / length * along).norm() <= near_) on_side.emplace_back(t, p);
      });
      std::sort(on_side.begin(), on_side.end());
      for (const auto& [t, p] : on_side) corners.push_back(p);
    }
    return corners;
  }

  /// From a corner from which no triangle is flat; false where there is none.
  bool add_fan(const Face& corners) {
    const std::size_t n = corners.size();
    const auto triangle = [&](std::size_t apex, std::size_t i) {
      return std::array<std::uint32_t, 3>{corners[apex], corners[(apex + i) % n], corners[(apex + i + 1) % n]};
    };
    const auto flat = [&](const std::array<std::uint32_t, 3>& t) {
      return Facet({result_.points[t[0]], result_.points[t[1]], result_.points[t[2]]}, t, near_).flat;
    };
    for (std::size_t apex = 0; apex < n; ++apex) {
      bool good = true;
      for (std::size_t i = 1; good && i + 1 < n; ++i) good = !flat(triangle(apex, i));
      for (std::size_t i = 1; good && i + 1 < n; ++i) result_.triangles.push_back(triangle(apex, i));
      if (good) return true;
    }
    return false;
  }

  double near_;
  std::vector<std::uint32_t> loose_;
  BoxTree tree_;
  TriangleMesh result_;
  std::vector<std::uint32_t> same_;  // per point the first one at its place, among those that are loose
};

}  // namespace

TriangleMesh conforming(std::vector<Vec3> points, std::span<const Face> faces, std::vector<std::uint32_t> loose,
                        double near) {
  Conforming maker(std::move(points), std::move(loose), near);
  for (const Face& face : faces) maker.add(face);
  return maker.take();
}

}  // namespace quench::surface
