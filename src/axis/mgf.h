// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "quench/shape.h"

namespace quench::axis {

/// The medial geodesic function of edges in the plane (Dey, Sun 2006; Yan 2018, sec. 3.2): the shorter arc of the
/// boundary of the pixel shape between the two contacts, in world units; infinite where they lie on different curves of
/// the boundary. A site where O touches itself lies on the boundary twice: the contact is in the corner of O in which
/// the segment between the sites begins.
///
/// `sites`: all of the shape, in order of y, x. Precondition: the segment between the sites of a pair lies in the
/// closure of O. Steps along x and along y are counted, so that only the last products round. O(runs + sites + edges);
/// 21 bytes per site.
std::vector<double> mgf_of_edges(const VoxelShape& shape, std::span<const LatticePoint> sites,
                                 std::span<const std::array<std::uint32_t, 2>> edge_sites);

}  // namespace quench::axis
