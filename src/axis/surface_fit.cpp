// SPDX-License-Identifier: Apache-2.0
// The geometry of a pruned voxel core from the surface that was voxelized: docs/algorithms/surface_fit.md.
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "axis/contact_place.h"
#include "base/parallel.h"
#include "quench/axis.h"
#include "quench/error.h"

namespace quench {
namespace {

// Sites nearer to each other than so many voxels stand for one contact: neighbours on a staircase.
constexpr double kOneContact = 1.8;
// The same in thin parts, in radii.
constexpr double kOneOfThin = 0.8;
// Contacts farther away than the nearest by more than so many voxels are none; twice as many where they are only feet
// of sites.
constexpr double kNoContact = 1.2;
// Planes whose normals have no smaller cosine are one.
constexpr double kFlat = 1 - 1e-6;
// The damping, as a share of what determines the move in all directions together.
constexpr double kDamping = 0.05;
// Directions with a smaller share of what determines the best one are free.
constexpr double kWeak = 0.1;
constexpr int kRounds = 3;
// The last move is shorter than so many voxels.
constexpr double kStill = 0.1;
// Balls below so many voxels may have their centre outside the surface.
constexpr double kThin = 3;

// `to`, or the point on the way there that is not farther away from `from` than `most`.
Vec3 no_farther(const Vec3& from, const Vec3& to, double most) {
  const double way = (to - from).norm();
  return way > most ? Vec3(from + (to - from) * (most / way)) : to;
}

// A place of the surface that a site stands for, and the plane of the triangle there.
struct Foot {
  Vec3 site, point, normal;
};

std::vector<Foot> feet_of(const std::vector<LatticePoint>& sites, const Grid& grid, const Surface& surface) {
  std::vector<Foot> feet(sites.size());
  base::for_indices(sites.size(), [&](std::size_t s) {
    const Vec3 site = grid.world_of(sites[s]);
    const Surface::Foot foot = surface.nearest(site);
    const auto& [a, b, c] = surface.mesh().triangles[foot.triangle];
    const auto& points = surface.mesh().points;
    feet[s] = {site, foot.point, (points[b] - points[a]).cross(points[c] - points[a]).normalized()};
  });
  return feet;
}

// The directions in which contacts determine where a centre is: at right angles to a sheet, to a curve, or all.
struct Determined {
  enum class In : char { line, plane, space };
  Vec3 axis = Vec3::Zero();  // along the line; at right angles to the plane
  In in = In::line;

  Vec3 part_of(const Vec3& move) const {
    const Vec3 along = axis * axis.dot(move);
    if (in == In::line) return along;
    return in == In::plane ? Vec3(move - along) : move;
  }
};

class Fit {
 public:
  Fit(const MedialAxis& axis, const Surface& surface, const std::vector<Foot>& feet)
      : surface_(surface), feet_(feet), voxel_(axis.grid.spacing.maxCoeff()) {}

  struct Place {
    Vec3 point;
    Determined determined = {};
  };

  // Where the ball of a vertex touches the surface at its contacts.
  Place place(const Vec3& from, double radius, std::span<const std::uint32_t> sites) {
    // Of a larger ball the centre is inside, unless the voxels are not those of the surface.
    Place result{radius < kThin * voxel_ ? brought_inside(from).point : from};
    find_contacts(result.point, radius, sites);
    for (int round = 0; round < kRounds; ++round) {
      if (round > 0) look_again(result.point);
      if (!drop_far_contacts(round == 0 ? 2 * kNoContact : kNoContact)) break;
      const Vec3 to = no_farther(from, result.point + balanced_move(result.determined), kLargestMove * voxel_);
      const double way = (to - result.point).norm();
      result.point = to;
      if (round > 0 && way < kStill * voxel_) break;
    }
    return result;
  }

  struct Centre {
    Vec3 point;
    Surface::Foot foot;  // of the point
  };

  // The point itself where it is inside, else the middle between the two walls where the surface is passed straight on
  // from the other one, if it is near enough.
  Centre centre(const Vec3& point, const Vec3& other) const {
    const Surface::Foot foot = surface_.nearest(point);
    return foot.inside ? Centre{point, foot} : brought_inside(other);
  }

 private:
  struct Contact {
    Vec3 site;
    axis::ContactPlace place;
    Vec3 direction;   // from the centre to it
    Vec3 normal;      // of the plane it lies in
    double distance;  // along the direction
    int sites;        // that stand for it
    bool is_plane;    // as far as the sites tell
  };

  Centre brought_inside(const Vec3& from) const {
    const Surface::Foot foot = surface_.nearest(from);
    Centre best{from, foot};
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

  // From the feet of sites. Of those that stand for one contact the nearest tells where it is. Where they lie in one
  // plane, so does the contact, and need not be looked for.
  void find_contacts(const Vec3& x, double radius, std::span<const std::uint32_t> sites) {
    const double near = std::min(kOneContact * voxel_, kOneOfThin * radius);
    contacts_.clear();
    for (const std::uint32_t row : sites) {
      const Foot& foot = feet_[row];
      const Vec3 there = foot.point - x;
      const double distance = there.norm();
      if (!(distance > 0)) continue;
      Contact own{foot.site, axis::ContactPlace(foot.point), there / distance, foot.normal, distance,
                  1,         there.dot(foot.normal) > 0};
      const auto same = std::ranges::find_if(
          contacts_, [&](const Contact& other) { return (own.site - other.site).squaredNorm() < near * near; });
      if (same == contacts_.end()) {
        contacts_.push_back(own);
        continue;
      }
      own.is_plane = own.is_plane && same->is_plane && own.normal.dot(same->normal) > kFlat &&
                     std::abs((own.place.point() - same->place.point()).dot(own.normal)) < 1e-3 * voxel_;
      own.sites = same->sites + 1;
      if (own.distance >= same->distance)
        std::tie(own.place, own.direction, own.distance) = std::tuple(same->place, same->direction, same->distance);
      own.site = same->site;
      *same = own;
    }
    for (Contact& c : contacts_) {
      c.is_plane = c.is_plane && c.sites > 1;
      if (c.is_plane) {
        c.direction = c.normal;
        c.distance = (c.place.point() - x).dot(c.normal);
      }
    }
  }

  // Where the contacts are as seen from x.
  void look_again(const Vec3& x) {
    for (Contact& c : contacts_) {
      if (c.is_plane) {
        c.distance = (c.place.point() - x).dot(c.direction);
        continue;
      }
      c.place.look_again(x, surface_);
      const Vec3 there = c.place.point() - x;
      c.distance = there.norm();
      if (c.distance > 0) c.direction = there / c.distance;
    }
  }

  // False when there are not two.
  bool drop_far_contacts(double farther) {
    if (contacts_.size() < 2) return false;
    const double least = std::ranges::min(contacts_, {}, &Contact::distance).distance;
    std::erase_if(contacts_, [&](const Contact& c) { return c.distance > least + farther * voxel_; });
    return contacts_.size() > 1;
  }

  // The least-squares solution of |y_i - x| - n_i . dx = r for all i in dx and r, damped in dx; and the directions
  // that determine it.
  Vec3 balanced_move(Determined& determined) const {
    const auto count = static_cast<double>(contacts_.size());
    Vec3 mean = Vec3::Zero();
    double distance = 0;
    for (const Contact& c : contacts_) {
      mean += c.direction / count;
      distance += c.distance / count;
    }
    Mat3 matrix = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (const Contact& c : contacts_) {
      const Vec3 row = c.direction - mean;
      matrix += row * row.transpose();
      right += row * (c.distance - distance);
    }
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    solver.computeDirect(matrix);
    const Vec3 values = solver.eigenvalues();  // ascending
    if (values[1] < kWeak * values[2])
      determined = {solver.eigenvectors().col(2), Determined::In::line};
    else
      determined = {solver.eigenvectors().col(0),
                    values[0] < kWeak * values[2] ? Determined::In::plane : Determined::In::space};
    matrix.diagonal().array() += kDamping * matrix.trace();
    return matrix.ldlt().solve(right);
  }

  const Surface& surface_;
  const std::vector<Foot>& feet_;
  double voxel_;
  std::vector<Contact> contacts_;
};

// Twice the area of a face as a vector.
Vec3 area_of(std::span<const std::uint32_t> corners, const std::vector<Vec3>& points) {
  Vec3 area = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    area += (points[corners[i]] - points[corners[0]]).cross(points[corners[i + 1]] - points[corners[0]]);
  return area;
}

enum Damage : char { kUnharmed, kConcave, kTurned };

// The cells that a pruning at the automatic detail keeps. Where they go does not depend on how much more there is, so
// that a pruning of a fitted axis is the fit of that pruning.
class FirstCells {
 public:
  explicit FirstCells(const MedialAxis& axis) : least_(auto_detail(axis.grid)) {
    const Measure* detail = axis.find_measure(kDetail);
    if (detail && detail->level.complete(axis.complex) && detail->value.complete(axis.complex)) detail_ = detail;
  }
  bool known() const { return detail_ != nullptr; }
  bool vertex(std::size_t v) const { return is_first(detail_->level.vertex[v]); }
  bool face(std::size_t f) const { return is_first(detail_->level.face[f]); }
  bool edge(std::size_t e) const { return is_first(detail_->level.edge[e]); }
  // Of a path that only the promise of the pruning keeps: its detail is the least exactly.
  bool is_of_path(std::size_t e) const { return edge(e) && detail_->value.edge[e] == least_; }

 private:
  bool is_first(double level) const { return level >= least_ * (1 - 1e-12); }
  double least_;
  const Measure* detail_ = nullptr;
};

// What moving has done to the faces of a vertex, at worst: a face turned over, or a corner no longer convex.
template <class Counts>
std::vector<char> damage_of_faces(const MedialAxis& axis, const Counts& counts) {
  const CellComplex& complex = axis.complex;
  const std::vector<Vec3>&before = axis.voxel_points, &after = axis.points;
  std::vector<char> damage(complex.vertex_count, kUnharmed);
  for (std::size_t f = 0; f < complex.face_count(); ++f) {
    if (!counts(f)) continue;
    const auto corners = complex.corners(f);
    const Vec3 up = area_of(corners, before);
    char own = up.dot(area_of(corners, after)) > 0 ? kUnharmed : kTurned;
    for (std::size_t i = 0; own == kUnharmed && i < corners.size(); ++i) {
      const Vec3 &a = after[corners[i]], &b = after[corners[(i + 1) % corners.size()]],
                 &c = after[corners[(i + 2) % corners.size()]];
      if (!((b - a).cross(c - b).dot(up) > 0)) own = kConcave;
    }
    for (const std::uint32_t v : corners) damage[v] = std::max(damage[v], own);
  }
  return damage;
}

// Small faces turn over, or lose their convex shape, where their corners move along the sheet: these only move where
// contacts determine it. Where faces still turn over, corners go back to where they were, which may turn others.
// `faces` are looked at, `vertices` may be moved back.
template <class Faces, class Vertices>
void keep_faces(MedialAxis& axis, const std::vector<Determined>& determined, const Faces& faces,
                const Vertices& vertices) {
  const std::vector<Vec3>& from = axis.voxel_points;
  std::vector<Vec3>& to = axis.points;
  const std::vector<char> damage = damage_of_faces(axis, faces);
  for (std::size_t v = 0; v < damage.size(); ++v)
    if (damage[v] >= kConcave && vertices(v)) to[v] = from[v] + determined[v].part_of(to[v] - from[v]);
  for (bool again = true; again;) {
    again = false;
    const std::vector<char> turned = damage_of_faces(axis, faces);
    for (std::size_t v = 0; v < turned.size(); ++v)
      if (turned[v] == kTurned && vertices(v) && to[v] != from[v]) {
        to[v] = from[v];
        again = true;
      }
  }
}

void keep_faces(MedialAxis& axis, const FirstCells& first, const std::vector<Determined>& determined) {
  keep_faces(
      axis, determined, [&](std::size_t f) { return first.face(f); }, [](std::size_t) { return true; });
  keep_faces(
      axis, determined, [](std::size_t) { return true; }, [&](std::size_t v) { return !first.vertex(v); });
}

// Moves the inner vertices of the paths that only the promise of a pruning by detail keeps towards the middle of their
// neighbours. Along edges between the balls of noise they would be longer than the way, and their erosion thickness
// that of a branch.
void straighten_paths(MedialAxis& axis, const FirstCells& first) {
  constexpr int kPasses = 30;
  const CellComplex& complex = axis.complex;
  std::vector<Vec3>& points = axis.points;
  std::vector<std::array<std::uint32_t, 2>> next(points.size(), {kNone, kNone});
  std::vector<char> is_other(points.size(), 0);  // not the inner vertex of a path
  for (std::size_t f = 0; f < complex.face_count(); ++f)
    if (first.face(f))
      for (const std::uint32_t v : complex.corners(f)) is_other[v] = 1;
  for (std::size_t e = 0; e < complex.edges.size(); ++e) {
    if (!first.edge(e)) continue;
    for (std::size_t end = 0; end < 2; ++end) {
      const std::uint32_t v = complex.edges[e][end];
      if (!first.is_of_path(e) || next[v][1] != kNone) is_other[v] = 1;
      next[v][next[v][0] == kNone ? 0 : 1] = complex.edges[e][1 - end];
    }
  }
  std::vector<std::uint32_t> inner;
  for (std::uint32_t v = 0; v < points.size(); ++v)
    if (!is_other[v] && next[v][1] != kNone) inner.push_back(v);
  const double most = kLargestMove * axis.grid.spacing.maxCoeff();
  std::vector<Vec3> now(inner.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    for (std::size_t i = 0; i < inner.size(); ++i) {
      const std::uint32_t v = inner[i];
      const Vec3 to = 0.5 * points[v] + 0.25 * (points[next[v][0]] + points[next[v][1]]);
      now[i] = no_farther(axis.voxel_points[v], to, most);
    }
    for (std::size_t i = 0; i < inner.size(); ++i) points[inner[i]] = now[i];
  }
}

}  // namespace

SurfaceFit fit_to_surface(MedialAxis& axis, const ContactSites& contacts, const Surface& surface, Context* context) {
  if (contacts.offsets.size() != axis.points.size() + 1)
    throw Error(ErrorCode::usage, "fitting to a surface needs the sites around each vertex of the medial axis");
  return base::in_arena(context, [&] {
    axis.voxel_points = axis.points;
    axis.voxel_radius = axis.radius;
    axis.surface = surface.kind();
    const std::vector<Foot> feet = feet_of(contacts.sites, axis.grid, surface);
    const std::size_t count = axis.points.size(), chunks = base::chunks_for(count, 1 << 10);
    std::vector<Vec3>& points = axis.points;
    std::vector<Determined> determined(count);
    const auto for_vertices = [&](double begin, double end, const auto& work) {
      base::for_chunks(chunks, context, "fit", begin, end, [&](std::size_t chunk) {
        Fit fit(axis, surface, feet);
        const auto [first, last] = base::part_of(count, chunk, chunks);
        for (std::size_t v = first; v < last; ++v) work(fit, v);
      });
    };
    for_vertices(0, 0.7, [&](Fit& fit, std::size_t v) {
      const Fit::Place place =
          fit.place(axis.voxel_points[v], axis.voxel_radius[v],
                    {contacts.rows.data() + contacts.offsets[v], contacts.rows.data() + contacts.offsets[v + 1]});
      points[v] = place.point;
      determined[v] = place.determined;
    });
    if (const FirstCells first(axis); first.known()) {
      keep_faces(axis, first, determined);
      straighten_paths(axis, first);
    } else {
      for (std::size_t v = 0; v < count; ++v)
        points[v] = axis.voxel_points[v] + determined[v].part_of(points[v] - axis.voxel_points[v]);
    }
    std::vector<char> inside(count);
    for_vertices(0.7, 1, [&](const Fit& fit, std::size_t v) {
      const Fit::Centre centre = fit.centre(points[v], axis.voxel_points[v]);
      inside[v] = centre.foot.inside;
      points[v] = centre.point;
      axis.radius[v] = inside[v] ? centre.foot.distance : 0;
    });
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
