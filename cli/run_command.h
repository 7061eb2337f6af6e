// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "quench/pipeline.h"
#include "session.h"
#include "shape_input.h"
#include "stage_options.h"

namespace quench::program {

/// The options of `quench run`.
struct RunProgram {
  ShapeOptions shape;
  pipeline::RunOptions run;
  GraphFileOptions graph;
  std::size_t max_triangles = kPageTriangles;
  bool no_view = false, no_picture = false;
  std::string folder;
};

/// The folder exists or can be created: told before a long computation.
void check_folder(const std::string& folder);
void create_folder(const std::string& folder);

/// `quench run` of a file of several polygons.
int run_features(const RunProgram& o, Session& session);

}  // namespace quench::program
