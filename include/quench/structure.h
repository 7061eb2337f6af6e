// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "quench/complex.h"

namespace quench {

/// The sheets of a complex, the seams along which they meet, and the junctions of these: what surfaces, curves and
/// points a medial axis is made of, as its cells have it (Yan 2018, sec. 1.2: manifold sheets, singular curves and
/// points).
struct Structure {
  std::uint32_t sheets = 0, seams = 0;
  std::vector<std::int32_t> face_sheet;   ///< per face: its sheet; faces that share an edge of no other are of one
  std::vector<std::int32_t> edge_seam;    ///< per edge of three faces or more: its seam, a line without fork; else -1
  std::vector<std::int32_t> vertex_seam;  ///< per vertex inside a seam: that seam; else -1
  std::vector<char> junction;             ///< per vertex: seams meet or end there
};

/// Sheets are numbered in the order of their first faces, seams of their first edges. O(n) but for a logarithm.
Structure structure_of(const CellComplex& complex);

}  // namespace quench
