// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "picture/scene.h"

namespace quench::picture {

/// The layer `simple` of a page at the vertices of a state, into an empty scene: triangles, curves, isolated points
/// and, where they give the colours, radii. Throws Error(usage) for arrays that do not fit.
void add_mesh_cells(const Page& page, const ViewState& state, Scene& scene);

/// The vertices of the mesh that is drawn for a state: as many as it wants, or as there are.
std::size_t mesh_vertices(const Page& page, const ViewState& state);

}  // namespace quench::picture
