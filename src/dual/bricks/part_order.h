// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "dual/bricks/part.h"

/// What the functions of part.h share.
namespace quench::dual::bricks {

/// In the order of z, y, x, in which sites are numbered.
inline constexpr auto comes_before = [](const LatticePoint& p, const LatticePoint& q) {
  if (p[2] != q[2]) return p[2] < q[2];
  return p[1] != q[1] ? p[1] < q[1] : p[0] < q[0];
};

/// All sites of two ordered lists, in order.
std::vector<LatticePoint> united(std::span<const LatticePoint> a, std::span<const LatticePoint> b);

/// The place of each of some sites, in order, among all sites, which have them.
std::vector<std::uint32_t> places_of(std::span<const LatticePoint> some, std::span<const LatticePoint> all);

/// Site s of the part becomes site place[s] of `sites`; the order of those that are named stays.
void renumber_sites(Part& part, std::span<const std::uint32_t> place, std::vector<LatticePoint> sites);

/// Drops the sites that nothing names.
void drop_unnamed_sites(Part& part);

/// Puts polytopes and unmatched facets in order.
void put_in_order(Part& part, Context* context);
/// Puts unmatched facets in order, and drops squares that are matched.
void put_facets_in_order(Part& part);

}  // namespace quench::dual::bricks
