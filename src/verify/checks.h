// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "verify/nearest_sites.h"
#include "verify/polytope.h"
#include "verify/result.h"

namespace quench::verification {

/// No two cells are the same, none is degenerate; polygons are plane and convex.
Check check_cells(const Result& result);

/// Euler characteristic and Betti numbers of the result are those of the shape.
Check check_topology(const Result& result);

/// Every cell lies in the open shape.
Check check_enclosure(const Result& result, Context* context);

/// The arrays `lambda` against LambdaOfSites.
Check check_lambda(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                   Context* context);

/// No simple pair below lambda is left, and every core cell of at least lambda around the sampled vertices is there.
Check check_pruning(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                    Context* context);

/// Distance to the true medial axis (SPEC 1, 9).
Check check_proximity(const Result& result, std::size_t samples, Context* context);

/// Levels of written cells are at least lambda.
Check check_levels(const Result& result);

/// Share of the voxel centres in the balls of the vertices; a figure, never a failure.
Check check_reconstruction(const Result& result, std::size_t samples, Context* context);

}  // namespace quench::verification
