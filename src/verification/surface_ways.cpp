// SPDX-License-Identifier: Apache-2.0
#include "verification/surface_ways.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <unordered_map>

#include "verification/checks.h"

namespace quench::verification {
namespace {

constexpr double kNoWay = std::numeric_limits<double>::infinity();

bool is_earlier(const LatticePoint& a, const LatticePoint& b) {
  return a[2] != b[2] ? a[2] < b[2] : a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

}  // namespace

SurfaceWays::SurfaceWays(const VoxelShape& shape, const Sites& sites)
    : sites_(sites), step_(shape.grid().spacing), mask_(sites.lattice().size(), 0) {
  most_ = (step_.maxCoeff() == step_.minCoeff() ? std::sqrt(4 - 2 * std::sqrt(2.0)) : std::sqrt(2.0)) * (1 + 1e-9);
  for (auto& list : beside_) list.resize(mask_.size());
  for (std::uint32_t s = 0; s < mask_.size(); ++s) {
    const LatticePoint& p = sites.lattice()[s];
    for (unsigned v = 0; v < 8; ++v)
      if (shape.contains(p[0] - 1 + int(v & 1), p[1] - 1 + int(v >> 1 & 1), p[2] - 1 + int(v >> 2)))
        mask_[s] |= static_cast<std::uint8_t>(1u << v);
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t up = 0; up < 2; ++up) {
        LatticePoint q = p;
        q[axis] += up ? 1 : -1;
        beside_[2 * axis + up][s] = find(q);
      }
  }
}

std::uint32_t SurfaceWays::find(const LatticePoint& p) const {
  const auto found = std::ranges::lower_bound(sites_.lattice(), p, is_earlier);
  return found != sites_.lattice().end() && *found == p ? static_cast<std::uint32_t>(found - sites_.lattice().begin())
                                                        : kNone;
}

std::uint32_t SurfaceWays::part(std::uint32_t site, std::uint32_t voxel) const {
  std::uint32_t smallest = voxel, seen = 1u << voxel;
  std::array<std::uint32_t, 8> open{voxel};
  for (std::size_t next = 0, count = 1; next < count; ++next)
    for (const std::uint32_t bit : {1u, 2u, 4u}) {
      const std::uint32_t v = open[next] ^ bit;
      if (!(mask_[site] >> v & 1) || (seen >> v & 1)) continue;
      seen |= 1u << v;
      smallest = std::min(smallest, v);
      open[count++] = v;
    }
  return smallest;
}

std::int64_t SurfaceWays::place(const LatticePoint& from, const LatticePoint& to) const {
  const std::uint32_t site = find(from);
  if (site == kNone) return -1;
  for (std::uint32_t v = 0; v < 8; ++v) {
    bool on_the_way = (mask_[site] >> v & 1) != 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (to[axis] != from[axis]) on_the_way &= (to[axis] > from[axis]) == ((v >> axis & 1) != 0);
    if (on_the_way) return 8 * std::int64_t{site} + part(site, v);
  }
  return -1;
}

// Squares of the surface at a place, of each voxel of its part, and their three other corners.
template <class Visit>
void SurfaceWays::for_neighbours(std::int64_t place, const Visit& visit) const {
  const auto site = static_cast<std::uint32_t>(place / 8), smallest = static_cast<std::uint32_t>(place % 8);
  for (std::uint32_t v = smallest; v < 8; ++v) {
    if (!(mask_[site] >> v & 1) || part(site, v) != smallest) continue;
    for (std::size_t across = 0; across < 3; ++across) {
      if (mask_[site] >> (v ^ 1u << across) & 1) continue;
      const std::size_t b = (across + 1) % 3, c = (across + 2) % 3;
      const auto go = [&](std::uint32_t from, std::size_t axis) { return beside_[2 * axis + (v >> axis & 1)][from]; };
      const std::uint32_t at_b = go(site, b), at_c = go(site, c), at_both = go(at_b, c);
      visit(8 * std::int64_t{at_b} + part(at_b, v ^ 1u << b), step_[static_cast<int>(b)]);
      visit(8 * std::int64_t{at_c} + part(at_c, v ^ 1u << c), step_[static_cast<int>(c)]);
      visit(8 * std::int64_t{at_both} + part(at_both, v ^ 1u << b ^ 1u << c),
            std::hypot(step_[static_cast<int>(b)], step_[static_cast<int>(c)]));
    }
  }
}

double SurfaceWays::shortest(const LatticePoint& from, const LatticePoint& to) const {
  const std::int64_t start = place(from, to), end = place(to, from);
  if (start < 0 || end < 0) return -1;
  std::unordered_map<std::int64_t, double> distance{{start, 0}};
  using Entry = std::pair<double, std::int64_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  queue.emplace(0, start);
  while (!queue.empty()) {
    const auto [d, at] = queue.top();
    queue.pop();
    if (at == end) return d;
    if (d > distance.at(at)) continue;
    for_neighbours(at, [&, d = d](std::int64_t next, double length) {
      const auto [known, fresh] = distance.try_emplace(next, kNoWay);
      if (d + length >= known->second) return;
      known->second = d + length;
      queue.emplace(d + length, next);
    });
  }
  return kNoWay;
}

Check check_mgf_of_surface(const Result& result, const Sites& sites, std::size_t samples, Context* context) {
  const std::string name = "ways along the boundary";
  const std::vector<double> point = numbers_or_empty(result.data.point_data, kMgf),
                            cell = numbers_or_empty(result.data.cell_data, kMgf);
  if (point.empty() && cell.empty()) return not_checked(name, "no array 'mgf'");
  if (point.empty() || cell.empty() || result.face_sites.size() != result.complex.face_count())
    return not_checked(name, "it needs 'mgf' of points and cells, and the sites of polygons");
  const double rounding = 1e-9 + result.slack;
  const auto of_face = [&](std::size_t f) { return cell[result.first_polygon() + f]; };
  const auto straight = [&](std::size_t f) {
    const auto& [a, b] = result.face_sites[f];
    return result.shape.grid().spacing.cwiseProduct(Vec3(a[0] - b[0], a[1] - b[1], a[2] - b[2])).norm();
  };
  const std::size_t faces = result.complex.face_count();
  std::size_t bad = first_failure(faces, context, "verify: boundary",
                                  [&](std::size_t f) { return of_face(f) >= straight(f) * (1 - rounding); });
  if (bad < faces)
    return failed(name, fmt::format("{} has mgf {:.9g}, its two sites are {:.9g} apart", result.describe_face(bad),
                                    of_face(bad), straight(bad)));
  constexpr std::size_t most_samples = 32;  // a way may lead over all of the surface
  const std::vector<std::uint32_t> sampled = sample(faces, std::min(samples, most_samples));
  const SurfaceWays ways(result.shape, sites);
  std::vector<double> way(sampled.size());
  const auto is_right = [&](std::size_t i) {
    const auto& [a, b] = result.face_sites[sampled[i]];
    way[i] = ways.shortest(a, b);
    const double written = of_face(sampled[i]);
    if (way[i] == kNoWay) return written >= kInfiniteLevelInFiles;
    return written <= way[i] * (1 + rounding) && written >= way[i] / ways.most() * (1 - rounding);
  };
  bad = first_failure(sampled.size(), context, "verify: boundary", is_right);
  if (bad < sampled.size())
    return failed(name, way[bad] < 0
                            ? fmt::format("the two sites of {} do not see each other inside of the shape",
                                          result.describe_face(sampled[bad]))
                            : fmt::format("{} has mgf {:.9g}, the shortest way along sides and diagonals is {:.9g}",
                                          result.describe_face(sampled[bad]), of_face(sampled[bad]), way[bad]));
  if (std::string low = below_cells_around(result, "mgf", point, cell, rounding, context); !low.empty())
    return failed(name, std::move(low));
  Check check{name, true, {}, {}};
  cover(check, "cell mgf");
  cover(check, "point mgf");
  check.detail = fmt::format(
      "mgf of {} of {} polygons lies between the shortest way along sides and diagonals and {:.3f} "
      "of it, of all it is at least the straight distance and at most that of the cells around",
      sampled.size(), faces, 1 / ways.most());
  return check;
}

}  // namespace quench::verification
