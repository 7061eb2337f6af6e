// SPDX-License-Identifier: Apache-2.0
#include "surface/solid_boundary.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/csr.h"
#include "base/parallel.h"
#include "base/union_find.h"
#include "surface/box_tree.h"
#include "surface/conforming.h"
#include "surface/cutting.h"
#include "surface/facet.h"
#include "surface/inside.h"

namespace quench::surface {
namespace {

constexpr double kNear = 1e-12;  // of the longest side: what is nearer is at one place
constexpr double kNarrow = 16;   // in units of the above: what is narrower is left out, no ray can tell its sides
constexpr double kOnePlace = 8;  // in the same units: points of neighbours that are cut by themselves
constexpr std::size_t kChunk = 4096;
constexpr const char* kStage = "surface";

using Pair = std::array<std::uint32_t, 2>;

/// Per point the first one, in the order of coordinates, then of indices, at the same place.
std::vector<std::uint32_t> first_at_place(std::span<const Vec3> points) {
  std::vector<std::uint32_t> order(points.size()), first(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    const Vec3 &p = points[i], &q = points[j];
    for (int a = 0; a < 3; ++a)
      if (p[a] != q[a]) return p[a] < q[a];
    return i < j;
  });
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && points[order[i]] == points[order[i - 1]] ? first[order[i - 1]] : order[i];
  return first;
}

/// An orthonormal frame in the plane of a facet, in which it is counterclockwise.
struct Plane {
  Vec3 at, u, v;
  explicit Plane(const Facet& facet)
      : at(facet.at[0]), u((facet.at[1] - facet.at[0]).normalized()), v(facet.normal.cross(u)) {}
  Vec2 to(const Vec3& p) const { return {u.dot(p - at), v.dot(p - at)}; }
  Vec3 from(const Vec2& p) const { return at + p[0] * u + p[1] * v; }
};

/// Part of a facet.
struct Piece {
  std::vector<Vec3> corners;
  bool turned = false;
};

class BoundaryMaker {
 public:
  BoundaryMaker(const TriangleMesh& mesh, bool odd, Context* context)
      : mesh_(mesh),
        context_(context),
        origin_(mesh.points.empty() ? Vec3::Zero() : mesh.points[0]),
        near_(kNear * longest_side_of(mesh.points)),
        facets_(facets()),
        tree_(boxes()),
        inside_(facets_, tree_, odd, near_) {}

  TriangleMesh make() {
    find_meetings();
    sides_.assign(facets_.size(), Side::none);
    pieces_.resize(facets_.size());
    decide_patches();
    decide_cut_facets();
    return assemble();
  }

 private:
  std::vector<Facet> facets() {
    const std::vector<std::uint32_t> first = first_at_place(mesh_.points);
    std::vector<Facet> made;
    made.reserve(mesh_.triangles.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      std::array<std::uint32_t, 3> corner = mesh_.triangles[t];
      std::array<Vec3, 3> at;
      for (std::size_t i = 0; i < 3; ++i) {
        corner[i] = first[corner[i]];
        at[i] = mesh_.points[corner[i]] - origin_;
      }
      if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
      made.emplace_back(at, corner, near_);
      triangle_.push_back(t);
    }
    return made;
  }

  std::vector<Bounds> boxes() const {
    std::vector<Bounds> boxes(facets_.size());
    for (std::size_t f = 0; f < facets_.size(); ++f)
      for (const Vec3& p : facets_[f].at) boxes[f].add(p);
    return boxes;
  }

  Meeting meeting_of(std::uint32_t f, std::uint32_t g) const {  // the same for (g, f)
    return meeting(facets_[std::min(f, g)], facets_[std::max(f, g)], near_);
  }

  void find_meetings() {
    const auto order = tree_.order();
    const std::size_t chunks = base::chunks_for(order.size(), kChunk);
    std::vector<std::vector<Pair>> found(chunks);
    base::for_chunks(chunks, context_, kStage, 0, 0.6, [&](std::size_t chunk) {
      const auto [begin, end] = base::part_of(order.size(), chunk, chunks);
      for (std::size_t i = begin; i < end; ++i) find_meetings(order[i], found[chunk]);
    });
    meets_ = base::Csr<std::uint32_t>::group(facets_.size(), [&](const auto& emit) {
      for (const auto& pairs : found)
        for (const auto& [f, g] : pairs) emit(f, g), emit(g, f);
    });
  }

  void find_meetings(std::uint32_t f, std::vector<Pair>& found) const {
    const Facet& facet = facets_[f];
    if (facet.flat) return;
    Bounds box;
    for (const Vec3& p : facet.at) box.add(p);
    tree_.visit([&](const Bounds& other) { return other.meets(box, near_); },
                [&](std::uint32_t g) {
                  if (g > f && !facets_[g].flat && meeting(facet, facets_[g], near_).kind != Meeting::Kind::none)
                    found.push_back({f, g});
                });
  }

  bool whole(std::uint32_t f) const { return meets_[f].empty(); }

  // Facets that are joined by edges of two faces each have the same on both sides, unless others cut them. A flat
  // facet joins one neighbour only: whether others cut it is not known.
  void decide_patches() {
    base::UnionFind patches(facets_.size());
    std::vector<Pair> with_flat;
    for (const auto& [f, g] : neighbours())
      if (facets_[f].flat || facets_[g].flat)
        with_flat.push_back({f, g});
      else if (whole(f) && whole(g))
        patches.unite(f, g);
    join_flat(with_flat, patches);
    std::vector<std::uint32_t> sample(facets_.size(), kNone);  // of each patch the widest facet
    std::vector<double> widest(facets_.size(), 0);
    for (std::uint32_t f = 0; f < facets_.size(); ++f) {
      if (!whole(f) || facets_[f].flat) continue;
      const std::uint32_t patch = patches.find(f);
      const double w = width(outline(f, Plane(facets_[f])));
      if (sample[patch] == kNone || w > widest[patch]) sample[patch] = f, widest[patch] = w;
    }
    std::vector<std::uint32_t> decided;
    for (std::uint32_t f = 0; f < facets_.size(); ++f)
      if (sample[f] != kNone) decided.push_back(f);
    const std::size_t chunks = base::chunks_for(decided.size(), 64);
    base::for_chunks(chunks, context_, kStage, 0.6, 0.8, [&](std::size_t chunk) {
      const auto [begin, end] = base::part_of(decided.size(), chunk, chunks);
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t patch = decided[i], f = sample[patch];
        if (widest[patch] > kNarrow * near_) sides_[patch] = inside_.side(middle(f), f);
      }
    });
    for (std::uint32_t f = 0; f < facets_.size(); ++f) sides_[f] = sides_[patches.find(f)];
  }

  /// Pairs of facets at edges of two faces, in opposite directions.
  std::vector<Pair> neighbours() const {
    struct End {
      std::uint32_t high, facet;
      bool upward;
    };
    auto ends = base::Csr<End>::group(mesh_.points.size(), [&](const auto& emit) {
      for (std::uint32_t f = 0; f < facets_.size(); ++f)
        for (std::size_t i = 0; i < 3; ++i) {
          const std::uint32_t a = facets_[f].corner[i], b = facets_[f].corner[(i + 1) % 3];
          emit(std::min(a, b), {std::max(a, b), f, a < b});
        }
    });
    std::vector<Pair> pairs;
    for (std::uint32_t low = 0; low < mesh_.points.size(); ++low) {
      const std::span<End> at = ends[low];
      std::sort(at.begin(), at.end(),
                [](const End& s, const End& t) { return s.high != t.high ? s.high < t.high : s.facet < t.facet; });
      for (auto e = at.begin(); e != at.end();) {
        const auto after = std::find_if(e, at.end(), [&](const End& s) { return s.high != e->high; });
        if (after - e == 2 && e[0].upward != e[1].upward) pairs.push_back({e[0].facet, e[1].facet});
        e = after;
      }
    }
    return pairs;
  }

  void join_flat(const std::vector<Pair>& pairs, base::UnionFind& patches) const {
    std::vector<char> joined(facets_.size(), 0);
    const auto known = [&](std::uint32_t f) { return facets_[f].flat ? joined[f] != 0 : whole(f); };
    for (bool again = true; again;) {
      again = false;
      for (const auto& [f, g] : pairs) {
        if (known(f) == known(g)) continue;
        const std::uint32_t joins = known(f) ? g : f;
        if (!facets_[joins].flat) continue;  // it is cut
        patches.unite(f, g);
        joined[joins] = again = true;
      }
    }
  }

  Polygon outline(std::uint32_t f, const Plane& plane) const {
    return {plane.to(facets_[f].at[0]), plane.to(facets_[f].at[1]), plane.to(facets_[f].at[2])};
  }
  Vec3 middle(std::uint32_t f) const { return (facets_[f].at[0] + facets_[f].at[1] + facets_[f].at[2]) / 3; }

  std::vector<Segment> cuts(std::uint32_t f, const Plane& plane) const {
    std::vector<Segment> segments;
    for (const std::uint32_t g : meets_[f]) {
      const Meeting met = meeting_of(f, g);
      if (met.kind == Meeting::Kind::segment) segments.push_back({plane.to(met.ends[0]), plane.to(met.ends[1])});
      if (met.kind != Meeting::Kind::overlap) continue;
      const Polygon other = outline(g, plane);
      for (std::size_t i = 0; i < 3; ++i) segments.push_back({other[i], other[(i + 1) % 3]});
    }
    return segments;
  }

  void decide_cut_facets() {
    std::vector<std::uint32_t> met;
    for (std::uint32_t f = 0; f < facets_.size(); ++f)
      if (!whole(f)) met.push_back(f);
    const std::size_t chunks = base::chunks_for(met.size(), 64);
    base::for_chunks(chunks, context_, kStage, 0.8, 1, [&](std::size_t chunk) {
      const auto [begin, end] = base::part_of(met.size(), chunk, chunks);
      for (std::size_t i = begin; i < end; ++i) decide_pieces(met[i]);
    });
  }

  // A facet whose pieces all have the same sides stays whole.
  void decide_pieces(std::uint32_t f) {
    const Plane plane(facets_[f]);
    std::vector<Piece> kept;
    std::optional<Side> common;
    bool differ = false;
    for (const Polygon& polygon : cut(outline(f, plane), cuts(f, plane), near_)) {
      if (width(polygon) <= kNarrow * near_) continue;
      const Side side = inside_.side(plane.from(centroid(polygon)), f);
      differ = differ || (common && *common != side);
      common = side;
      if (side == Side::none) continue;
      Piece piece{{}, side == Side::before};
      for (const Vec2& p : polygon) piece.corners.push_back(plane.from(p) + origin_);
      kept.push_back(std::move(piece));
    }
    if (differ)
      pieces_[f] = std::move(kept);
    else
      sides_[f] = common.value_or(Side::none);
  }

  /// The corners of facets that are in the box of one that is cut, or that is left out because it is flat.
  std::vector<std::uint32_t> corners_at_cuts() const {
    std::vector<Bounds> boxes;
    for (std::uint32_t f = 0; f < facets_.size(); ++f) {
      if (whole(f) && !(facets_[f].flat && sides_[f] == Side::none)) continue;
      boxes.emplace_back();
      for (const Vec3& p : facets_[f].at) boxes.back().add(p);
    }
    const BoxTree cut(std::move(boxes));
    std::vector<char> near(mesh_.points.size(), 0);
    for (const Facet& facet : facets_)
      for (std::size_t i = 0; i < 3; ++i) {
        char& found = near[facet.corner[i]];
        cut.visit(
            [&](const Bounds& box) {
              return !found && box.meets({facet.at[i], facet.at[i]}, kOnePlace * near_);
            },
            [&](std::uint32_t) { found = 1; });
      }
    std::vector<std::uint32_t> corners;
    for (std::uint32_t p = 0; p < near.size(); ++p)
      if (near[p] != 0) corners.push_back(p);
    return corners;
  }

  TriangleMesh assemble() const {
    std::vector<Vec3> points = mesh_.points;
    std::vector<Face> faces;
    std::vector<std::uint32_t> loose = corners_at_cuts();
    const auto add = [&](Face face, bool turned) {
      if (turned) std::reverse(face.begin() + 1, face.end());
      faces.push_back(std::move(face));
    };
    for (std::size_t f = 0; f < facets_.size(); ++f) {
      const auto& corners = mesh_.triangles[triangle_[f]];
      if (sides_[f] != Side::none) add(Face(corners.begin(), corners.end()), sides_[f] == Side::before);
      for (const Piece& piece : pieces_[f]) {
        Face face(piece.corners.size());
        std::iota(face.begin(), face.end(), static_cast<std::uint32_t>(points.size()));
        loose.insert(loose.end(), face.begin(), face.end());
        points.insert(points.end(), piece.corners.begin(), piece.corners.end());
        add(std::move(face), piece.turned);
      }
    }
    return conforming(std::move(points), faces, std::move(loose), kOnePlace * near_);
  }

  const TriangleMesh& mesh_;
  Context* context_;
  Vec3 origin_;  // differences to it are exact for all that is near
  double near_;
  std::vector<std::uint32_t> triangle_;  // of each facet
  std::vector<Facet> facets_;
  BoxTree tree_;
  Inside inside_;
  base::Csr<std::uint32_t> meets_;          // per facet those it meets
  std::vector<Side> sides_;                 // of facets that stay whole
  std::vector<std::vector<Piece>> pieces_;  // of those that do not
};

}  // namespace

TriangleMesh solid_boundary(const TriangleMesh& mesh, bool odd, Context* context) {
  return base::in_arena(context, [&] { return BoundaryMaker(mesh, odd, context).make(); });
}

}  // namespace quench::surface
