// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/cofaces.h"
#include "skeleton/member.h"

namespace quench::skeleton {

/// The sheets of a member before its curves are pruned.
struct Sheets {
  Member member;                        ///< with all curves, and edges off these that no face is left at
  std::vector<base::Cofaces> faces_at;  ///< per edge and piece: the faces that are left there
};

/// What of the sheets is left above theta2: parts of polygons, cut where their corner levels cross it. Everything below
/// goes by collapses from the rims, in any order, so that the topology is that of K; what cannot go stays. With `rims`
/// below infinity sheets grow back to their rims, as ExtractOptions::regrow_rims_above and minor_curve say. O(n).
Sheets sheets_above(const SkeletonFamily& family, double theta2, double rims, double minor_curve);
/// The same with parts of polygons whole as soon as some of them is above theta2.
Sheets whole_sheets_above(const SkeletonFamily& family, double theta2);

}  // namespace quench::skeleton
