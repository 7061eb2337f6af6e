// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core_pipeline.h"
#include "program.h"
#include "quench/io.h"

namespace quench::program {

Action add_voxelize(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    std::string output;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  app.add_option("-o,--output", o->output, "The volume (.nrrd, 0 and 1)")->required();
  return [o](Session& session) {
    session.check_output(o->output, {o->shape.file});
    if (std::filesystem::path(o->output).extension() != ".nrrd")
      throw Error(ErrorCode::usage, fmt::format("voxelize writes .nrrd, not {}", o->output));
    const LoadedShape loaded = load_shape(o->shape, session);
    io::write_volume(o->output, loaded.shape, &session.context);
    checkpoint(&session.context, "write", 1);
    if (!session.options.report.empty()) {
      nlohmann::ordered_json report;
      report["input"] = loaded.input;
      report["parameters"] = loaded.parameters;
      const Grid& grid = loaded.shape.grid();
      report["shape"] = {{"dims", grid.dims},
                         {"spacing", {grid.spacing[0], grid.spacing[1], grid.spacing[2]}},
                         {"voxels", loaded.shape.voxel_count()},
                         {"sites", count_boundary_vertices(loaded.shape)},
                         {"euler", loaded.topology.euler},
                         {"betti", loaded.topology.betti},
                         {"voxelization_changed_topology", loaded.topology_changed.value_or(false)}};
      write_report(session.options.report, report, session);
    }
    session.say(fmt::format("{}: {} voxels inside; {:.1f} s", o->output, loaded.shape.voxel_count(), session.total_seconds()));
    return 0;
  };
}

}  // namespace quench::program
