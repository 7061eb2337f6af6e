// SPDX-License-Identifier: Apache-2.0
#include "shape_input.h"

#include <fmt/format.h>

#include <charconv>

#include "quench/io.h"
#include "quench/voxelize.h"

namespace quench::program {
namespace {

using Json = nlohmann::ordered_json;

std::optional<Vec3> parse_spacing(const std::string& text) {
  if (text.empty()) return std::nullopt;
  Vec3 spacing;
  const char* at = text.data();
  const char* const end = at + text.size();
  int count = 0;
  for (; count < 3; ++count) {
    const auto [next, error] = std::from_chars(at, end, spacing[count]);
    if (error != std::errc() || !(spacing[count] > 0) || !std::isfinite(spacing[count])) break;
    at = next;
    if (at == end) {
      ++count;
      break;
    }
    if (*at++ != ',') {
      count = 0;
      break;
    }
  }
  if (at != end || (count != 1 && count != 3))
    throw Error(ErrorCode::usage, fmt::format("--spacing '{}' is not a spacing; give one positive number or three as x,y,z", text));
  if (count == 1) spacing[1] = spacing[2] = spacing[0];
  return spacing;
}

std::string betti_text(const Topology& t) { return fmt::format("Betti numbers {}, {}, {}", t.betti[0], t.betti[1], t.betti[2]); }

void load_mesh(const ShapeOptions& options, Session& session, LoadedShape& loaded) {
  const PolyData data = io::read_poly_data(options.file);
  const TriangleMesh mesh = to_triangle_mesh(data);
  if (mesh.triangles.empty())
    throw Error(ErrorCode::input, fmt::format("{} holds no faces; a shape needs a closed surface", options.file));
  checkpoint(&session.context, "read", 1);
  const ForegroundOptions& f = options.foreground;
  if (f.threshold || f.label || f.invert || !options.spacing.empty())
    session.say("note: --threshold, --label, --invert and --spacing are for volumes and are ignored for a mesh");
  VoxelizeOptions voxelize_options;
  voxelize_options.fill = options.fill == "evenodd" ? FillRule::evenodd : FillRule::nonzero;
  Voxelization v;
  try {
    if (options.resolution == "auto") {
      v = voxelize_auto(mesh, voxelize_options, &session.context);
    } else {
      const auto& text = options.resolution;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), voxelize_options.resolution);
      if (error != std::errc() || end != text.data() + text.size())
        throw Error(ErrorCode::usage, fmt::format("--resolution '{}' is not a whole number or 'auto'", text));
      v = voxelize(mesh, voxelize_options, &session.context);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::input) throw;
    throw Error(ErrorCode::input, fmt::format("{}: {}", options.file, error.what()));
  }
  loaded.shape = std::move(v.shape);
  loaded.longest_side = v.longest_side;
  loaded.topology_changed = v.topology_changed;
  if (v.topology_changed) session.say("warning: voxelization changed the topology: " + v.topology_difference);
  const auto resolution = static_cast<std::int64_t>(std::llround(v.longest_side / loaded.shape.grid().spacing[0]));
  if (options.resolution == "auto") session.say(fmt::format("resolution {} (auto)", resolution));
  loaded.input["vertices"] = mesh.points.size();
  loaded.input["faces"] = mesh.triangles.size();
  loaded.input["euler"] = 2 * v.surface.euler;
  loaded.input["components"] = v.surface.components;
  loaded.input["manifold"] = v.surface.manifold;
  loaded.parameters["resolution"] = resolution;
  loaded.parameters["fill"] = options.fill;
}

void load_volume(const ShapeOptions& options, Session& session, LoadedShape& loaded) {
  if (options.resolution_given) session.say("note: --resolution is for meshes and is ignored for a volume");
  const Volume volume = io::read_volume(options.file, {parse_spacing(options.spacing)}, &session.context);
  checkpoint(&session.context, "read", 1);
  ForegroundOptions foreground_options = options.foreground;
  foreground_options.largest_component = foreground_options.fill_cavities = false;  // below, as for meshes
  foreground_options.min_component = 0;
  try {
    loaded.shape = foreground(volume, foreground_options, nullptr, &session.context);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::failed || error.code() == ErrorCode::cancelled) throw;
    throw Error(error.code(), fmt::format("{}: {}", options.file, error.what()));
  }
  checkpoint(&session.context, "voxelize", 1);
  loaded.units = volume.units;
  loaded.longest_side = loaded.shape.longest_side();
  if (!volume.units.empty()) loaded.input["units"] = volume.units;
  if (options.foreground.threshold) loaded.parameters["threshold"] = *options.foreground.threshold;
  if (options.foreground.label) loaded.parameters["label"] = *options.foreground.label;
  if (options.foreground.invert) loaded.parameters["invert"] = true;
  if (!options.spacing.empty()) loaded.parameters["spacing"] = options.spacing;
}

void clean_as_asked(const ShapeOptions& options, Session& session, LoadedShape& loaded) {
  const ForegroundOptions& f = options.foreground;
  if (!f.largest_component && f.min_component == 0 && !f.fill_cavities) return;
  ForegroundOptions only = f;
  only.threshold.reset();
  only.label.reset();
  only.invert = false;
  ForegroundReport report;
  loaded.shape = clean(loaded.shape, only, &report, &session.context);
  session.say(fmt::format("cleaned: {} components of {} voxels dropped, {} cavities of {} voxels filled", report.components_removed,
                          report.voxels_removed, report.cavities_filled, report.voxels_filled));
  loaded.input["cleaned"] = {{"components_removed", report.components_removed},
                             {"voxels_removed", report.voxels_removed},
                             {"cavities_filled", report.cavities_filled},
                             {"voxels_filled", report.voxels_filled}};
  if (f.largest_component) loaded.parameters["largest_component"] = true;
  if (f.min_component) loaded.parameters["min_component"] = f.min_component;
  if (f.fill_cavities) loaded.parameters["fill_cavities"] = true;
  if (loaded.kind == "volume") loaded.longest_side = loaded.shape.longest_side();
}

}  // namespace

void add_shape_options(CLI::App& app, ShapeOptions& o) {
  app.add_option("SHAPE", o.file, "A closed mesh (.ply .obj .off .stl ...) or a volume (.nrrd .nii.gz .mha .map .vol .npy .tif, a folder of slices ...)")->required();
  const auto group = "Shape";
  app.add_option("--resolution", o.resolution, "Mesh: voxels along the longest side, or 'auto': the smallest of 128, 256 ... 2048 that keeps the topology")
      ->capture_default_str()->group(group)->each([&o](const std::string&) { o.resolution_given = true; });
  app.add_option("--fill", o.fill, "Mesh: what winding numbers are inside")->check(CLI::IsMember({"nonzero", "evenodd"}))->capture_default_str()->group(group);
  app.add_option("--threshold", o.foreground.threshold, "Volume: foreground is value >= this")->group(group);
  app.add_option("--label", o.foreground.label, "Volume: foreground is value == this (0 too)")->group(group);
  app.add_option("--spacing", o.spacing, "Volume: voxel size x,y,z (or one number), instead of the file's")->group(group);
  app.add_flag("--invert", o.foreground.invert, "Volume: foreground becomes background")->group(group);
  app.add_flag("--largest-component", o.foreground.largest_component, "Keep the largest component only")->group(group);
  app.add_option("--min-component", o.foreground.min_component, "Drop components of fewer voxels")->check(CLI::NonNegativeNumber)->group(group);
  app.add_flag("--fill-cavities", o.foreground.fill_cavities, "Fill cavities")->group(group);
  app.add_option("--subdivide", o.subdivide, "Split every voxel into K x K x K")->check(CLI::Range(1, 64))->capture_default_str()->group(group);
}

LoadedShape load_shape(const ShapeOptions& options, Session& session) {
  if (options.foreground.threshold && options.foreground.label)
    throw Error(ErrorCode::usage, "--threshold and --label exclude each other; give one of them");
  if (!std::filesystem::exists(options.file))
    throw Error(ErrorCode::failed, fmt::format("{} does not exist", options.file));
  LoadedShape loaded;
  loaded.input["file"] = options.file;
  const io::Kind kind = io::kind_of(options.file);
  if (kind == io::Kind::unknown)
    throw Error(ErrorCode::input, fmt::format("{} is of no kind Quench knows by its name; meshes end in e.g. .ply, .obj, .off, .stl, volumes in .nrrd, "
                                              ".nii.gz, .mha, .map, .vol, .npy, .tif", options.file));
  loaded.kind = kind == io::Kind::surface ? "mesh" : "volume";
  loaded.input["kind"] = loaded.kind;
  if (kind == io::Kind::surface)
    load_mesh(options, session, loaded);
  else
    load_volume(options, session, loaded);
  clean_as_asked(options, session, loaded);
  if (options.subdivide > 1) {
    loaded.shape = subdivide(loaded.shape, options.subdivide);
    loaded.parameters["subdivide"] = options.subdivide;
  }
  loaded.topology = topology(loaded.shape);
  checkpoint(&session.context, "voxelize", 1);
  const Grid& grid = loaded.shape.grid();
  if (loaded.kind == "volume") {
    loaded.input["euler"] = loaded.topology.euler;
    loaded.input["components"] = loaded.topology.betti[0];
  }
  loaded.input["longest_side"] = loaded.longest_side;
  session.say(fmt::format("shape: {} x {} x {} voxels of {} x {} x {}, {} inside; {}", grid.dims[0], grid.dims[1], grid.dims[2], grid.spacing[0],
                          grid.spacing[1], grid.spacing[2], loaded.shape.voxel_count(), betti_text(loaded.topology)));
  if (loaded.kind == "volume" && loaded.topology.betti[0] > 100)
    session.say(fmt::format("note: the volume has {} components; --min-component N drops specks", loaded.topology.betti[0]));
  return loaded;
}

std::string parameters_of(const PolyData& result) {
  const DataArray* array = find_array(result.field_data, "parameters");
  if (!array) return {};
  const auto* text = std::get_if<std::vector<std::string>>(&array->values);
  return text && !text->empty() ? text->front() : std::string();
}

void take_parameters(ShapeOptions& options, const PolyData& result) {
  const Json p = Json::parse(parameters_of(result), nullptr, false);
  if (p.is_discarded() || !p.is_object()) return;
  const auto has = [&](const char* name, auto check) { return p.contains(name) && (p[name].*check)(); };
  if (!options.resolution_given && has("resolution", &Json::is_number_integer)) options.resolution = std::to_string(p["resolution"].get<std::int64_t>());
  if (options.fill == "nonzero" && has("fill", &Json::is_string)) options.fill = p["fill"].get<std::string>();
  ForegroundOptions& f = options.foreground;
  if (!f.threshold && !f.label) {
    if (has("threshold", &Json::is_number)) f.threshold = p["threshold"].get<double>();
    if (has("label", &Json::is_number_integer)) f.label = p["label"].get<std::int64_t>();
  }
  if (options.spacing.empty() && has("spacing", &Json::is_string)) options.spacing = p["spacing"].get<std::string>();
  if (has("invert", &Json::is_boolean)) f.invert |= p["invert"].get<bool>();
  if (has("largest_component", &Json::is_boolean)) f.largest_component |= p["largest_component"].get<bool>();
  if (f.min_component == 0 && has("min_component", &Json::is_number_integer)) f.min_component = p["min_component"].get<std::int64_t>();
  if (has("fill_cavities", &Json::is_boolean)) f.fill_cavities |= p["fill_cavities"].get<bool>();
  if (options.subdivide == 1 && has("subdivide", &Json::is_number_integer)) options.subdivide = p["subdivide"].get<int>();
}

}  // namespace quench::program
