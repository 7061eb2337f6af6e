// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "quench/pipeline.h"

/// Results of the plane as lines: for GIS and drawing programs.
namespace quench::program {

/// Branches with their measures.
io::PlaneLines plane_lines(const CurveGraph& graph);
/// The branches of a result with their measures, the outline of the shape (that of the polygon where it was one) and,
/// with RunOptions::narrower, what is wider.
io::PlaneLines plane_lines(const pipeline::LoadedShape& shape, const pipeline::RunResult& result);

}  // namespace quench::program
