// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/io.h"
#include "quench/pipeline.h"
#include "quench/tree.h"
#include "tree_conversion.h"
#include "units.h"

namespace quench::program {

Action add_convert(CLI::App& app) {
  struct Options {
    std::string input, output, radii, quality = "radius";
  };
  auto o = std::make_shared<Options>();
  app.add_option("A", o->input, "A mesh or a medial axis: .vtp .ply .obj .off .stl .ma ...; a tree: .swc .rsml")
      ->type_name("")
      ->required();
  app.add_option("B,-o,--output", o->output,
                 "The file to write: .vtp .vtu .ply .obj .stl .ma .r .csv; of a tree .swc .rsml .mtg .graphml .vtp")
      ->type_name("")
      ->required();
  app.add_option("--radii", o->radii, "Radii of the vertices (a .r file), matched by position")->type_name("FILE");
  app.add_option("--quality", o->quality, "PLY: the point array MeshLab shows as quality and colour")
      ->type_name("NAME")
      ->capture_default_str();
  return [o](Session& session) {
    std::vector<std::filesystem::path> inputs{o->input};
    if (!o->radii.empty()) inputs.emplace_back(o->radii);
    session.check_output(o->output, inputs, "B");
    if (io::is_tree_file(o->input)) {
      check_tree_format(o->output);
      if (!o->radii.empty()) throw Error(ErrorCode::usage, "a tree has its own radii", "radii");
      convert_tree(o->input, o->output, session);
      return 0;
    }
    io::check_writable_format(o->output);
    if (io::kind_of(o->input) == io::Kind::volume)
      throw Error(ErrorCode::usage,
                  fmt::format("'{}' is a volume; 'quench voxelize' writes its voxel shape", o->input));
    Record data = pipeline::read_surface(o->input, &session.context);
    checkpoint(&session.context, "read", 1);
    if (!o->radii.empty()) pipeline::take_radii(data, o->radii, &session.context);
    take_units(data, o->input, session);
    const std::string extension = extension_of(o->output);
    if ((extension == ".ma" || extension == ".r") && !find_array(data.point_data, "radius"))
      throw Error(ErrorCode::input, fmt::format("'{}' has no radius per vertex, which {} needs; give --radii FILE.r",
                                                o->input, extension));
    io::write_record(o->output, data, {o->quality});
    session.finished("write");
    session.say(fmt::format("{}: {}, {}, {}", o->output, base::counted(data.points.size(), "point"),
                            base::counted(data.lines.size(), "line"), base::counted(data.poly_count(), "polygon")));
    return 0;
  };
}

}  // namespace quench::program
