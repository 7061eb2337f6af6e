// SPDX-License-Identifier: Apache-2.0
// Headers and names before 0.2.
#include <quench/axis_fields.h>
#include <quench/curve_graph.h>
#include <quench/extent.h>
#include <quench/image.h>
#include <quench/medial_axis.h>
#include <quench/output_group.h>
#include <quench/poly_data.h>
#include <quench/prune.h>
#include <quench/raster.h>
#include <quench/sample.h>
#include <quench/slices.h>
#include <quench/topology.h>
#include <quench/volume.h>
#include <quench/voxel_core.h>
#include <quench/voxel_shape.h>

bool old_names_work() {
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  const quench::PolyData data = quench::to_poly_data(quench::make_sample("box").mesh);
  return data.poly_count() > 0 && !quench::samples().empty();
}
