// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "quench/context.h"
#include "quench/poly_data.h"
#include "quench/voxel_shape.h"

namespace quench {

/// One thing that was checked about a result.
struct Check {
  std::string name;  ///< e.g. "euler and Betti numbers"
  bool passed = false;
  std::string detail;  ///< figures when it passed, the first counterexample when it did not
};

struct Certificate {
  std::vector<Check> checks;
  bool passed() const;
};

struct VerifyOptions {
  std::optional<double> lambda;  ///< world units; default: the result's FieldData, else 0
  std::size_t samples = 20000;   ///< cells per sampled check
};

/// Proves a result against its shape (SPEC 9), by code of its own: it shares the voxel shape, integer_spacing,
/// make_complex and the topology functions with the code that made the result. `result` is what a file holds: complex
/// by points, verts, lines and polys, point array `radius`.
Certificate verify(const VoxelShape& shape, const PolyData& result, const VerifyOptions& options = {},
                   Context* context = nullptr);

}  // namespace quench
