// SPDX-License-Identifier: Apache-2.0
#include "axis_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "option_checks.h"
#include "quench/axis.h"
#include "quench/geometry.h"
#include "quench/io.h"

namespace quench::program {

std::vector<std::filesystem::path> AxisOptions::inputs() const {
  std::vector<std::filesystem::path> list{file};
  if (!radii.empty()) list.emplace_back(radii);
  if (!shape.empty()) list.emplace_back(shape);
  return list;
}

void add_axis_options(CLI::App& app, AxisOptions& o) {
  app.add_option("AXIS", o.file, "A medial axis, of Quench or of another program: .vtp .ply .obj .off .ma")
      ->type_name("")
      ->required();
  const auto group = "Medial axis";
  app.add_option("--radii", o.radii, "Radii of the vertices (a .r file: x y z r per line), matched by position")
      ->type_name("FILE")
      ->group(group);
  app.add_option(
         "--shape", o.shape,
         "The mesh or volume the axis is of: fractions refer to its longest side [default: what AXIS says, else "
         "the bounding box of AXIS]")
      ->type_name("FILE")
      ->group(group);
  add_threshold(app, o.threshold, "--shape is a volume: its voxels of at least this value")
      ->type_name("T")
      ->group(group);
  add_label(app, o.label, "--shape is a volume: its voxels of exactly this value")->type_name("K")->group(group);
}

void check_axis_options(const AxisOptions& options) {
  std::error_code ignored;
  for (const auto& file : options.inputs())
    if (!std::filesystem::exists(file, ignored))
      throw Error(ErrorCode::failed, fmt::format("'{}' does not exist", file.string()));
  if (io::kind_of(options.file) == io::Kind::volume)
    throw Error(ErrorCode::input,
                fmt::format("'{}' is a volume, not a medial axis; 'quench core' computes one of it", options.file));
  if (options.shape.empty() && (options.threshold || options.label))
    throw Error(ErrorCode::usage, "--threshold and --label say which voxels of --shape are meant; give --shape too");
}

std::optional<double> field_number(const Record& data, const char* name) {
  const DataArray* array = find_array(data.field_data, name);
  if (!array || array->size() == 0 || std::holds_alternative<std::vector<std::string>>(array->values)) return {};
  return array->numbers().front();
}

std::optional<std::string> field_text(const Record& data, const char* name) {
  const DataArray* array = find_array(data.field_data, name);
  if (!array) return {};
  const auto* text = std::get_if<std::vector<std::string>>(&array->values);
  if (!text || text->empty()) return {};
  return text->front();
}

double LoadedAxis::resolve(const std::string& text, const std::string& option) const {
  const Length length = parse_length(text, option);
  if (length.unit == Length::Unit::voxels && voxel == 0)
    throw Error(ErrorCode::usage, fmt::format("{} {} needs a voxel size, which the medial axis does not say; give "
                                              "--shape VOLUME, a fraction (0.01) or a world length (3.5abs)",
                                              option, text));
  return length.resolve(longest_side, voxel);
}

Record read_axis_file(const std::string& file, Session& session) {
  std::error_code ignored;
  // The bytes of the file and what is made of them; a compressed one says what it holds when it is opened.
  if (const auto size = std::filesystem::file_size(file, ignored); !ignored)
    session.check_memory(static_cast<std::int64_t>(2 * size), fmt::format("reading '{}'", file), {"a smaller file"});
  return io::read_record(file, &session.context);
}

namespace {

void measure_shape(const AxisOptions& options, Session& session, LoadedAxis& loaded) {
  if (io::kind_of(options.shape) == io::Kind::surface) {
    loaded.longest_side = longest_side_of(read_axis_file(options.shape, session).points);
    return;
  }
  ShapeOptions shape;
  shape.file = options.shape;
  shape.foreground.threshold = options.threshold;
  shape.foreground.label = options.label;
  const LoadedShape volume = load_shape(shape, session);
  loaded.longest_side = volume.longest_side;
  loaded.voxel = volume.shape.grid().spacing.minCoeff();
}

}  // namespace

LoadedAxis load_axis(const AxisOptions& options, Session& session) {
  check_axis_options(options);
  return make_axis(options, read_axis_file(options.file, session), session);
}

LoadedAxis make_axis(const AxisOptions& options, Record&& data, Session& session) {
  LoadedAxis loaded;
  loaded.data = std::move(data);
  drop_unusable_fields(loaded.data, options.file, &session.context);
  if (!options.radii.empty()) {
    std::erase_if(loaded.data.point_data, [](const DataArray& a) { return a.name == "radius"; });
    loaded.data.point_data.insert(loaded.data.point_data.begin(),
                                  {"radius", 1, io::read_radii(options.radii, loaded.data.points, &session.context)});
  }
  AxisRepair repair;
  try {
    loaded.axis = medial_axis_of(loaded.data, &repair);
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("'{}': {}", options.file, error.what()));
  }
  if (loaded.axis.points.empty()) throw Error(ErrorCode::input, fmt::format("'{}' is empty", options.file));
  checkpoint(&session.context, "read", 1);
  if (repair.degenerate + repair.duplicate > 0)
    session.say(fmt::format(
        "note: '{}' has {} with a repeated corner (the rest of it is kept) and {} twice (counted once)", options.file,
        base::counted(repair.degenerate, "cell"), base::counted(repair.duplicate, "polygon")));
  if (const DataArray* spacing = find_array(loaded.data.field_data, "spacing")) {
    const std::vector<double> sizes = spacing->numbers();
    loaded.spacing = {sizes[0], sizes[1], sizes[2]};
    loaded.voxel = loaded.spacing.minCoeff();
  }
  loaded.longest_side = field_number(loaded.data, "longest_side").value_or(0);
  if (!options.shape.empty()) measure_shape(options, session, loaded);
  if (!(loaded.longest_side > 0)) loaded.longest_side = longest_side_of(loaded.axis.points);
  // A voxel core of ours names the boundary vertices its radii are distances to.
  if (const DataArray* sites = find_array(loaded.data.field_data, "sites"); sites && sites->components == 3)
    loaded.voxel_core = true;
  loaded.coordinates = {field_text(loaded.data, "units").value_or(""), field_text(loaded.data, "SPACE").value_or("")};
  const CellComplex& c = loaded.axis.complex;
  loaded.input = {{"file", options.file},    {"kind", "medial axis"},   {"vertices", c.vertex_count},
                  {"edges", c.edges.size()}, {"faces", c.face_count()}, {"longest_side", loaded.longest_side}};
  return loaded;
}

}  // namespace quench::program
