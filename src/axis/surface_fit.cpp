// SPDX-License-Identifier: Apache-2.0
// The geometry of a pruned voxel core from the surface that was voxelized.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "quench/axis.h"
#include "quench/error.h"

namespace quench {
namespace {

// Sites nearer to each other than so many voxels stand for one contact: neighbours on a staircase.
constexpr double kOneContact = 1.8;
// Contacts farther away than the nearest by more than so many voxels are none.
constexpr double kNoContact = 1.2;
// Of the damping, beside directions at right angles to each other.
constexpr double kDamping = 1e-3;
constexpr int kRounds = 3;
// The last move is shorter than so many voxels.
constexpr double kStill = 0.03;
// Balls below so many voxels may have their centre outside the surface.
constexpr double kThin = 3;

// `to`, or the point on the way there that is not farther away from `from` than `most`.
Vec3 no_farther(const Vec3& from, const Vec3& to, double most) {
  const double way = (to - from).norm();
  return way > most ? Vec3(from + (to - from) * (most / way)) : to;
}

class Fit {
 public:
  Fit(const MedialAxis& axis, const Surface& surface)
      : grid_(axis.grid), surface_(surface), voxel_(axis.grid.spacing.maxCoeff()) {}

  struct Result {
    Vec3 point;
    Surface::Foot foot;  // of the point
  };

  Result run(const Vec3& from, double radius, std::span<const LatticePoint> sites) {
    Vec3 x = from;
    // Of a larger ball the centre is inside, unless the voxels are not those of the surface.
    const bool is_thin = radius < kThin * voxel_;
    if (is_thin) {
      const Result start = brought_inside(from, surface_.nearest(from));
      if (!start.foot.inside) return start;
      x = start.point;
    }
    find_contacts(x, sites);
    for (int round = 0; round < kRounds && look_again(x); ++round) {
      const Vec3 to = no_farther(from, x + balanced_move(), kLargestMove * voxel_);
      const double way = (to - x).norm();
      x = to;
      if (way < kStill * voxel_) break;
    }
    const Result result{x, surface_.nearest(x)};
    if (result.foot.inside) return result;
    return brought_inside(from, surface_.nearest(from));
  }

  // The point itself with its distance: where it may not move.
  Result in_place(const Vec3& point) const { return {point, surface_.nearest(point)}; }

 private:
  struct Contact {
    Vec3 direction;  // from the centre
    double distance;
    double way;  // from half way there to a point of the surface, at most
  };

  // The middle between the two walls where the surface is passed straight on, if it is near enough.
  Result brought_inside(const Vec3& from, const Surface::Foot& foot) const {
    Result best{from, foot};
    if (foot.inside) return best;
    const double most = kLargestMove * voxel_ - foot.distance;
    if (!(most > 0) || !(foot.distance > 0)) return best;
    const Vec3 inward = (foot.point - from) / foot.distance;
    for (double depth = most; depth > 1e-3 * voxel_; depth /= 2) {
      const Vec3 point = foot.point + depth * inward;
      const Surface::Foot there = surface_.nearest(point);
      if (!there.inside) continue;
      if (!best.foot.inside || there.distance > best.foot.distance) best = {point, there};
      if (there.distance > 0.99 * depth) break;
    }
    return best;
  }

  void find_contacts(const Vec3& x, std::span<const LatticePoint> sites) {
    contacts_.clear();
    groups_.clear();
    for (const LatticePoint& site : sites) {
      const Vec3 at = grid_.world_of(site);
      const auto same = std::ranges::find_if(groups_, [&](const auto& group) {
        return (at - group.first).squaredNorm() < kOneContact * kOneContact * voxel_ * voxel_;
      });
      if (same == groups_.end())
        groups_.push_back({at, (at - x).normalized()});
      else
        same->second += (at - x).normalized();
    }
    for (const auto& [at, direction] : groups_) {
      const double distance = (at - x).norm();
      contacts_.push_back({direction.normalized(), distance, 0.6 * distance + 2 * voxel_});
    }
  }

  // Contacts as seen from x. False when there are not two.
  bool look_again(const Vec3& x) {
    if (contacts_.size() < 2) return false;
    for (Contact& c : contacts_) {
      const Vec3 half_way = x + 0.5 * c.distance * c.direction;
      Surface::Foot foot = surface_.nearest(half_way, c.way);
      if (foot.triangle == kNone) foot = surface_.nearest(half_way);
      const Vec3 there = foot.point - x;
      c.distance = there.norm();
      if (c.distance > 0) c.direction = there / c.distance;
      c.way = 0.5 * c.distance + kLargestMove * voxel_;
    }
    const double least = std::ranges::min(contacts_, {}, &Contact::distance).distance;
    std::erase_if(contacts_, [&](const Contact& c) { return c.distance > least + kNoContact * voxel_; });
    return contacts_.size() > 1;
  }

  // The least-squares solution of |y_i - x| - n_i . dx = r for all i in dx and r, damped in dx.
  Vec3 balanced_move() const {
    const auto count = static_cast<double>(contacts_.size());
    Vec3 mean = Vec3::Zero();
    double distance = 0;
    for (const Contact& c : contacts_) {
      mean += c.direction / count;
      distance += c.distance / count;
    }
    Mat3 matrix = kDamping * count * Mat3::Identity();
    Vec3 right = Vec3::Zero();
    for (const Contact& c : contacts_) {
      const Vec3 row = c.direction - mean;
      matrix += row * row.transpose();
      right += row * (c.distance - distance);
    }
    return matrix.ldlt().solve(right);
  }

  const Grid& grid_;
  const Surface& surface_;
  double voxel_;
  std::vector<Contact> contacts_;
  std::vector<std::pair<Vec3, Vec3>> groups_;  // the first site, and the sum of directions
};

// Twice the area of a face as a vector.
Vec3 area_of(std::span<const std::uint32_t> corners, const std::vector<Vec3>& points) {
  Vec3 area = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    area += (points[corners[i]] - points[corners[0]]).cross(points[corners[i + 1]] - points[corners[0]]);
  return area;
}

// Vertices of faces that moving has turned over.
std::vector<char> of_turned_faces(const CellComplex& complex, const std::vector<Vec3>& before,
                                  const std::vector<Vec3>& after) {
  std::vector<char> turned(complex.vertex_count, 0);
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    const auto corners = complex.corners(f);
    if (area_of(corners, before).dot(area_of(corners, after)) > 0) continue;
    for (const std::uint32_t v : corners) turned[v] = 1;
  }
  return turned;
}

// Moves the inner vertices of the paths that only the promise of a pruning by detail keeps (their detail is the least
// exactly) towards the middle of their neighbours. Along edges between the balls of noise they would be longer than the
// way, and their erosion thickness that of a branch. Returns the vertices.
std::vector<std::uint32_t> straighten_paths(const MedialAxis& axis, std::vector<Vec3>& points) {
  constexpr int kPasses = 30;
  const Measure* detail = axis.find_measure(kDetail);
  std::vector<std::uint32_t> inner;
  if (!detail || !detail->value.complete(axis.complex)) return inner;
  const double least = auto_detail(axis.grid), most = kLargestMove * axis.grid.spacing.maxCoeff();
  std::vector<std::array<std::uint32_t, 2>> next(points.size(), {kNone, kNone});
  std::vector<char> is_other(points.size(), 0);  // not the inner vertex of a path
  for (const std::uint32_t v : axis.complex.face_vertices) is_other[v] = 1;
  for (std::size_t e = 0; e < axis.complex.edges.size(); ++e)
    for (std::size_t end = 0; end < 2; ++end) {
      const std::uint32_t v = axis.complex.edges[e][end];
      if (detail->value.edge[e] != least || next[v][1] != kNone) is_other[v] = 1;
      next[v][next[v][0] == kNone ? 0 : 1] = axis.complex.edges[e][1 - end];
    }
  for (std::uint32_t v = 0; v < points.size(); ++v)
    if (!is_other[v] && next[v][1] != kNone) inner.push_back(v);
  std::vector<Vec3> now(inner.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    for (std::size_t i = 0; i < inner.size(); ++i) {
      const std::uint32_t v = inner[i];
      const Vec3 to = 0.5 * points[v] + 0.25 * (points[next[v][0]] + points[next[v][1]]);
      now[i] = no_farther(axis.voxel_points[v], to, most);
    }
    for (std::size_t i = 0; i < inner.size(); ++i) points[inner[i]] = now[i];
  }
  return inner;
}

}  // namespace

SurfaceFit fit_to_surface(MedialAxis& axis, const ContactSites& contacts, const Surface& surface, Context* context) {
  if (contacts.offsets.size() != axis.points.size() + 1)
    throw Error(ErrorCode::usage, "fitting to a surface needs the sites around each vertex of the medial axis");
  return base::in_arena(context, [&] {
    axis.voxel_points = axis.points;
    axis.voxel_radius = axis.radius;
    axis.surface = surface.kind();
    std::vector<char> inside(axis.points.size());
    const auto take = [&](std::size_t v, const Fit::Result& result) {
      axis.points[v] = result.point;
      axis.radius[v] = result.foot.inside ? result.foot.distance : 0;
      inside[v] = result.foot.inside;
    };
    const std::size_t chunks = base::chunks_for(axis.points.size(), 1 << 10);
    base::for_chunks(chunks, context, "fit", 0, 1, [&](std::size_t chunk) {
      Fit fit(axis, surface);
      const auto [first, last] = base::part_of(axis.points.size(), chunk, chunks);
      for (std::size_t v = first; v < last; ++v)
        take(v,
             fit.run(axis.voxel_points[v], axis.voxel_radius[v],
                     {contacts.sites.data() + contacts.offsets[v], contacts.sites.data() + contacts.offsets[v + 1]}));
    });
    // Few faces turn over; what goes back may turn others.
    const Fit fit(axis, surface);
    for (bool again = true; again;) {
      again = false;
      const std::vector<char> turned = of_turned_faces(axis.complex, axis.voxel_points, axis.points);
      for (std::size_t v = 0; v < turned.size(); ++v)
        if (turned[v] && axis.points[v] != axis.voxel_points[v]) {
          take(v, fit.in_place(axis.voxel_points[v]));
          again = true;
        }
    }
    std::vector<Vec3> straight = axis.points;
    for (const std::uint32_t v : straighten_paths(axis, straight))
      if (straight[v] != axis.points[v]) take(v, fit.in_place(straight[v]));
    SurfaceFit result;
    for (std::size_t v = 0; v < axis.points.size(); ++v) {
      const double way = (axis.points[v] - axis.voxel_points[v]).norm();
      result.moved += way > 0;
      result.outside += !inside[v];
      result.mean_move += way / static_cast<double>(axis.points.size());
      result.largest_move = std::max(result.largest_move, way);
    }
    return result;
  });
}

}  // namespace quench
