// SPDX-License-Identifier: Apache-2.0
#include "axis/mgf.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "shape/pixel_corners.h"

namespace quench::axis {
namespace {

using shape::corner_of;

constexpr unsigned bit(bool larger_x, bool larger_y) { return 1u << corner_of(larger_x, larger_y); }
constexpr unsigned kFalling = bit(false, false) | bit(true, true), kRising = bit(true, false) | bit(false, true);

/// Pixels around a site where O touches itself.
constexpr bool touches_itself(unsigned corners) { return corners == kFalling || corners == kRising; }

/// Directions along the boundary, each a left turn after the one before where y grows upwards.
enum Direction : unsigned { kRight, kUp, kLeft, kDown };

/// The corner between a direction and the next one.
constexpr int corner_after(unsigned direction) {
  constexpr int corners[] = {corner_of(true, true), corner_of(false, true), corner_of(false, false),
                             corner_of(true, false)};
  return corners[direction & 3];
}

constexpr bool is_towards_larger_y(int corner) { return corner >= corner_of(false, true); }

/// Whether the boundary leaves a site in a direction, with O on the left.
constexpr bool leaves(unsigned corners, unsigned direction) {
  return (corners >> corner_after(direction) & 1) && !(corners >> corner_after(direction + 3) & 1);
}

class BoundaryCurves {
 public:
  BoundaryCurves(const VoxelShape& shape, std::span<const LatticePoint> sites)
      : sites_(sites), corners_(shape::corners_of_sites(shape, sites)) {
    find_neighbours();
    place_passages();
    for (std::uint32_t s = 0; s < sites.size(); ++s)
      for (unsigned d = 0; d < 4; ++d)
        if (leaves(corners_[s], d) && passages_[passage(s, is_towards_larger_y(corner_after(d)))].curve == kNone)
          follow(s, d);
  }

  /// Steps along x and y of the two arcs between the contacts of a pair of sites; nothing on different curves.
  bool arcs(const std::array<std::uint32_t, 2>& pair, std::array<std::array<std::int64_t, 2>, 2>& steps) const {
    const Passage &a = passages_[contact(pair[0], pair[1])], &b = passages_[contact(pair[1], pair[0])];
    if (a.curve != b.curve) return false;
    for (std::size_t i = 0; i < 2; ++i) {
      steps[0][i] = std::abs(std::int64_t{a.steps[i]} - std::int64_t{b.steps[i]});
      steps[1][i] = std::int64_t{lengths_[a.curve][i]} - steps[0][i];
    }
    return true;
  }

 private:
  /// A curve passing by a site: steps along x and y from the curve's start. They only grow, so of two passages the
  /// same one is ahead in both.
  struct Passage {
    std::uint32_t curve = kNone;
    std::array<std::uint32_t, 2> steps{0, 0};
  };

  void find_neighbours() {
    above_.assign(sites_.size(), kNone);
    below_.assign(sites_.size(), kNone);
    std::uint32_t t = 0;  // at (x, y + 1), or the first site after it
    for (std::uint32_t s = 0; s < sites_.size(); ++s) {
      const LatticePoint wanted{sites_[s][0], sites_[s][1] + 1, 0};
      const auto before = [](const LatticePoint& a, const LatticePoint& b) {
        return a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
      };
      while (t < sites_.size() && before(sites_[t], wanted)) ++t;
      if (t == sites_.size() || sites_[t] != wanted) continue;
      above_[s] = t;
      below_[t] = s;
    }
  }

  // One passage per site, in its place, and the second ones of sites where O touches itself behind all these.
  void place_passages() {
    for (std::uint32_t s = 0; s < sites_.size(); ++s)
      if (touches_itself(corners_[s])) twice_.push_back(s);
    passages_.resize(sites_.size() + twice_.size());
  }
  // That in a corner of O at a site. Where O touches itself, one of the two corners is towards larger y.
  std::size_t passage(std::uint32_t site, bool larger_y) const {
    if (!larger_y || !touches_itself(corners_[site])) return site;
    return sites_.size() + static_cast<std::size_t>(std::ranges::lower_bound(twice_, site) - twice_.begin());
  }

  void follow(std::uint32_t start, unsigned start_direction) {
    const auto curve = static_cast<std::uint32_t>(lengths_.size());
    std::array<std::uint32_t, 2> steps{0, 0};
    std::uint32_t s = start;
    unsigned d = start_direction;
    do {
      passages_[passage(s, is_towards_larger_y(corner_after(d)))] = {curve, steps};
      ++steps[d & 1];
      s = d == kRight ? s + 1 : d == kLeft ? s - 1 : d == kUp ? above_[s] : below_[s];
      ++d;  // as far left as possible: where O touches itself it is not connected
      while (!leaves(corners_[s], d)) d += 3;
      d &= 3;
    } while (s != start || d != start_direction);
    lengths_.push_back(steps);
  }

  // The passage at `site` in whose corner of O the segment to `other` begins. Along a row it begins between two pixels;
  // where O touches itself, one of these is in O.
  std::size_t contact(std::uint32_t site, std::uint32_t other) const {
    const std::int32_t dx = sites_[other][0] - sites_[site][0], dy = sites_[other][1] - sites_[site][1];
    return passage(site, dy > 0 || (dy == 0 && !(corners_[site] >> corner_of(dx > 0, false) & 1)));
  }

  std::span<const LatticePoint> sites_;
  const std::vector<std::uint8_t> corners_;
  std::vector<std::uint32_t> above_, below_;  // per site: that with y one larger or smaller
  std::vector<std::uint32_t> twice_;          // sites where O touches itself
  std::vector<Passage> passages_;
  std::vector<std::array<std::uint32_t, 2>> lengths_;  // per curve
};

}  // namespace

std::vector<double> mgf_of_edges(const VoxelShape& shape, std::span<const LatticePoint> sites,
                                 std::span<const std::array<std::uint32_t, 2>> edge_sites) {
  const BoundaryCurves curves(shape, sites);
  const Vec3& spacing = shape.grid().spacing;
  std::vector<double> mgf(edge_sites.size(), std::numeric_limits<double>::infinity());
  std::array<std::array<std::int64_t, 2>, 2> steps;
  for (std::size_t e = 0; e < edge_sites.size(); ++e) {
    if (!curves.arcs(edge_sites[e], steps)) continue;
    for (const auto& [x, y] : steps)
      mgf[e] = std::min(mgf[e], static_cast<double>(x) * spacing[0] + static_cast<double>(y) * spacing[1]);
  }
  return mgf;
}

}  // namespace quench::axis
