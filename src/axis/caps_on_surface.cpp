// SPDX-License-Identifier: Apache-2.0
// docs/algorithms/surface_fit.md
#include "axis/caps_on_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "axis/contact_place.h"
#include "axis/measures.h"
#include "base/parallel.h"

namespace quench::axis {
namespace {

// A cap on the surface of this part of the least height, or more, bears out that of the voxels.
constexpr double kBorneOut = 0.5;
// Places this near to where the ball touches the surface, in voxels along it, are there; farther ones go on sliding.
constexpr double kThere = 0.7, kStill = 0.1;
constexpr int kRounds = 8;

using Place = ContactPlace;

class SurfaceCaps {
 public:
  SurfaceCaps(const MedialAxis& axis, const Surface& surface, double least)
      : axis_(axis), surface_(surface), enough_(kBorneOut * least), voxel_(axis.grid.spacing.maxCoeff()) {}

  void project(const std::vector<std::uint32_t>& sites, Context* context) {
    place_.assign(axis_.sites.size(), kNone);
    for (std::uint32_t i = 0; i < sites.size(); ++i) place_[sites[i]] = i;
    foot_.resize(sites.size());
    const std::size_t chunks = base::chunks_for(sites.size(), 1 << 12);
    base::for_chunks(chunks, context, "detail", 0, 0.1, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(sites.size(), chunk, chunks);
      for (std::size_t i = first; i < last; ++i) {
        const Surface::Foot foot = surface_.nearest(axis_.grid.world_of(axis_.sites[sites[i]]));
        foot_[i] = {foot.point, foot.triangle};
      }
    });
  }

  // The cap height of a face on the surface, or any above `enough_`.
  double height(std::size_t face) const {
    Vec3 x = Vec3::Zero();
    const auto corners = axis_.complex.corners(face);
    for (const std::uint32_t v : corners) x += axis_.points[v] / static_cast<double>(corners.size());
    const auto [s, t] = axis_.face_sites[face];
    const Foot &a = foot_[place_[s]], &b = foot_[place_[t]];
    std::array<Place, 2> y{Place(a.point), Place(b.point)};
    double height = cap(x, y);
    if (height >= enough_ && is_there(x, a) && is_there(x, b)) return height;
    for (int round = 0; round < kRounds; ++round) {
      double off = 0;
      for (Place& place : y) off = std::max(off, place.look_again(x, surface_));
      height = cap(x, y);
      if (height < enough_ || off < kStill * voxel_) break;
    }
    return height;
  }
  bool is_borne_out(double height) const { return height >= enough_; }

 private:
  struct Foot {
    Vec3 point;
    std::uint32_t triangle;
  };

  static double cap(const Vec3& x, const std::array<Place, 2>& y) {
    return cap_height((y[1].point() - y[0].point()).norm() / 2,
                      std::min((y[0].point() - x).norm(), (y[1].point() - x).norm()));
  }
  // Whether x lies nearly above a place of the surface.
  bool is_there(const Vec3& x, const Foot& foot) const {
    const auto& [a, b, c] = surface_.mesh().triangles[foot.triangle];
    const auto& points = surface_.mesh().points;
    const Vec3 normal = (points[b] - points[a]).cross(points[c] - points[a]);
    const double away = (x - foot.point).cross(normal).norm();
    return away < kThere * voxel_ * normal.norm();
  }

  const MedialAxis& axis_;
  const Surface& surface_;
  double enough_, voxel_;
  std::vector<std::uint32_t> place_;  // per site: in foot_
  std::vector<Foot> foot_;            // of the sites that are needed, which may be few of all
};

}  // namespace

void lower_to_surface(const MedialAxis& axis, const Surface& surface, double least, std::span<const double> known,
                      CellValues& height, Context* context) {
  std::vector<char> is_needed(axis.sites.size(), 0);
  std::vector<std::uint32_t> faces, sites;
  for (std::uint32_t f = 0; f < height.face.size(); ++f)
    if (height.face[f] >= least && (known.empty() || known[f] < 0)) {
      faces.push_back(f);
      for (const std::uint32_t s : axis.face_sites[f]) is_needed[s] = 1;
    }
  for (std::uint32_t s = 0; s < is_needed.size(); ++s)
    if (is_needed[s]) sites.push_back(s);
  SurfaceCaps caps(axis, surface, least);
  caps.project(sites, context);
  const std::size_t chunks = base::chunks_for(faces.size(), 1 << 12);
  base::for_chunks(chunks, context, "detail", 0.1, 0.3, [&](std::size_t chunk) {
    const auto [first, last] = base::part_of(faces.size(), chunk, chunks);
    for (std::size_t i = first; i < last; ++i) {
      double& own = height.face[faces[i]];
      const double found = caps.height(faces[i]);
      if (!caps.is_borne_out(found)) own = std::min(own, found);
    }
  });
}

}  // namespace quench::axis
