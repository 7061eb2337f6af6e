// SPDX-License-Identifier: Apache-2.0
#include "shape_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "option_checks.h"
#include "quench/axis.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "quench/voxelize.h"

namespace quench::program {
namespace {

using Json = nlohmann::ordered_json;

std::optional<Vec3> parse_spacing(const std::string& text) {
  if (text.empty()) return std::nullopt;
  std::vector<double> values = numbers_in(text, ',');
  if (values.size() == 1) values.resize(3, values[0]);
  if (values.size() != 3 || !std::all_of(values.begin(), values.end(), [](double v) { return v > 0; }))
    throw Error(ErrorCode::usage,
                fmt::format("--spacing '{}' is not a voxel size; give one positive number or three as x,y,z", text));
  return Vec3(values[0], values[1], values[2]);
}

}  // namespace

std::optional<std::int64_t> parse_resolution(const std::string& text) {
  if (text == "auto") return std::nullopt;
  std::int64_t value = 0;
  if (!is_number(text, value) || value < 1 || value > 16384)
    throw Error(ErrorCode::usage,
                fmt::format("--resolution '{}' is not a whole number from 1 to 16384 or 'auto'", text));
  return value;
}

void check_voxelization_memory(const TriangleMesh& mesh, std::int64_t resolution, const Session& session) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t p : triangle) {
      if (p >= mesh.points.size()) return;  // the voxelizer has the sentence for it
      low = low.cwiseMin(mesh.points[p]);
      high = high.cwiseMax(mesh.points[p]);
    }
  const Vec3 sides = (high - low) / (high - low).maxCoeff() * static_cast<double>(resolution) + Vec3::Constant(3);
  const double bytes = 32 * sides[1] * sides[2];
  if (std::isfinite(bytes))
    session.check_memory(static_cast<std::int64_t>(bytes), fmt::format("the voxel shape at resolution {}", resolution),
                         {"a lower --resolution"});
}

namespace {

std::string topology_text(const Topology& t) {
  return fmt::format("{}, {}, {}", base::counted(t.betti[0], "component"), base::counted(t.betti[1], "tunnel"),
                     base::counted(t.betti[2], "cavity", "cavities"));
}

/// The options that are for volumes, as far as they are set.
std::vector<std::string> options_for_volumes(const ShapeOptions& options) {
  const ForegroundOptions& f = options.foreground;
  std::vector<std::string> names;
  if (f.threshold) names.emplace_back("--threshold");
  if (f.label) names.emplace_back("--label");
  if (f.invert) names.emplace_back("--invert");
  if (!options.spacing.empty()) names.emplace_back("--spacing");
  return names;
}

/// Of a mesh: which options have no effect, given on the command line or recorded in a result.
void say_ignored(const ShapeOptions& options, Session& session) {
  const auto say = [&](const std::vector<std::string>& names, const std::string& recorded) {
    if (names.empty()) return;
    const bool one = names.size() == 1;
    session.say(fmt::format("note: {}{} {} for volumes and {} ignored for a mesh", fmt::join(names, ", "), recorded,
                            one ? "is" : "are", one ? "is" : "are"));
  };
  std::vector<std::string> given = options_for_volumes(options);
  for (const std::string& name : options.recorded) std::erase(given, name);
  say(given, "");
  say(options.recorded, fmt::format(" (recorded in '{}')", options.recorded_in));
}

void load_mesh(const ShapeOptions& options, Session& session, LoadedShape& loaded) {
  const Record data = io::read_record(options.file, &session.context);
  TriangleMesh mesh = to_triangle_mesh(data);
  if (mesh.triangles.empty())
    throw Error(ErrorCode::input, fmt::format("'{}' holds no faces; a shape needs a closed surface", options.file));
  checkpoint(&session.context, "read", 1);
  say_ignored(options, session);
  VoxelizeOptions voxelize_options;
  voxelize_options.fill = fill_of(options.fill).value_or(FillRule::nonzero);
  const std::optional<std::int64_t> wanted = parse_resolution(options.resolution);
  Voxelization v;
  try {
    if (wanted) {
      check_voxelization_memory(mesh, *wanted, session);
      voxelize_options.resolution = *wanted;
      v = voxelize(mesh, voxelize_options, &session.context);
    } else {
      v = voxelize_auto(mesh, voxelize_options, &session.context);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::input) throw;
    throw Error(ErrorCode::input, fmt::format("'{}': {}", options.file, error.what()));
  }
  loaded.shape = std::move(v.shape);
  loaded.longest_side = v.longest_side;
  if (!v.fill_reason.empty()) session.say(fmt::format("fill {} (auto): {}", fill_name(v.fill), v.fill_reason));
  if (!v.sound) session.say("warning: " + defects_text(v));
  if (v.topology_known)
    loaded.topology_changed = v.topology_changed;
  else if (v.sound)
    session.say("note: parts of the mesh overlap, so whether voxelization changed the topology cannot be told from it");
  if (v.topology_changed) session.say("warning: voxelization changed the topology: " + v.topology_difference);
  const auto resolution = static_cast<std::int64_t>(std::llround(v.longest_side / loaded.shape.grid().spacing[0]));
  if (options.resolution == "auto") session.say(fmt::format("resolution {} (auto)", resolution));
  loaded.input["vertices"] = mesh.points.size();
  loaded.input["faces"] = mesh.triangles.size();
  loaded.input["euler"] = v.surface.surface_euler;
  loaded.input["components"] = v.surface.components;
  loaded.input["manifold"] = v.surface.manifold;
  loaded.input["fill"] = fill_name(v.fill);
  if (!v.fill_reason.empty()) loaded.input["fill_reason"] = v.fill_reason;
  loaded.input["sound"] = v.sound;
  loaded.input["defects"] = {{"open_edges", v.defects.open_edges},
                             {"unbalanced_edges", v.defects.unbalanced_edges},
                             {"degenerate_faces", v.defects.degenerate_faces},
                             {"duplicate_faces", v.defects.duplicate_faces},
                             {"flipped_faces", v.defects.flipped_faces},
                             {"filled_holes", v.defects.filled_holes},
                             {"flipped_components", v.defects.flipped_components},
                             {"scanlines", v.defects.scanlines},
                             {"defective_scanlines", v.defects.defective_scanlines},
                             {"winding_share", v.defects.winding_share},
                             {"doubtful_share", v.defects.doubtful_share}};
  loaded.parameters["resolution"] = resolution;
  loaded.parameters["fill"] = options.fill;
  if (options.keep_mesh) loaded.mesh = std::move(mesh);
}

bool is_tiff(const std::string& file) { return extension_of(file) == ".tif" || extension_of(file) == ".tiff"; }

/// What a volume says of itself, for the report; on screen where the format has no field for it.
void take_origin(const ShapeOptions& options, const Grid& grid, const Coordinates& coordinates,
                 const std::string& source, Session& session, LoadedShape& loaded) {
  loaded.coordinates = coordinates;
  if (!coordinates.units.empty()) loaded.input["units"] = coordinates.units;
  if (!coordinates.space.empty()) loaded.input["space"] = coordinates.space;
  loaded.input["spacing"] = {grid.spacing[0], grid.spacing[1], grid.spacing[2]};
  const std::string from = options.spacing.empty() ? source : "--spacing";
  if (!from.empty()) loaded.input["spacing_source"] = from;
  if (options.spacing.empty() && !source.empty() && is_tiff(options.file))
    session.say(fmt::format("note: spacing {} from {}", spacing_text(grid, coordinates.units), source));
  say_picture(options.file, grid, session);
}

void load_volume(const ShapeOptions& options, Session& session, LoadedShape& loaded) {
  if (options.resolution_given) session.say("note: --resolution is for meshes and is ignored for a volume");
  ForegroundOptions foreground_options = options.foreground;
  foreground_options.largest_component = foreground_options.fill_cavities = false;  // below, as for meshes
  foreground_options.min_component = 0;
  const io::VolumeReadOptions read_options{parse_spacing(options.spacing)};
  const auto told = [&](const auto& get) {
    try {
      loaded.shape = get();
    } catch (const Error& error) {
      if (error.code() == ErrorCode::failed || error.code() == ErrorCode::cancelled ||
          std::string_view(error.what()).find(options.file) != std::string_view::npos)
        throw;
      throw Error(error.code(), fmt::format("'{}': {}{}", options.file, error.what(),
                                            error.code() == ErrorCode::usage ? " by --threshold or --label" : ""));
    }
  };
  if (const auto slices = io::open_slices(options.file, read_options, &session.context)) {
    take_origin(options, slices->grid, slices->coordinates, slices->spacing_source, session, loaded);
    told([&] { return foreground(*slices, foreground_options, nullptr, &session.context); });
  } else {
    const Volume volume = io::read_volume(options.file, read_options, &session.context);
    checkpoint(&session.context, "read", 1);
    take_origin(options, volume.grid, volume.coordinates, volume.spacing_source, session, loaded);
    told([&] { return foreground(volume, foreground_options, nullptr, &session.context); });
  }
  checkpoint(&session.context, "voxelize", 1);
  loaded.longest_side = loaded.shape.longest_side();
  if (options.foreground.threshold)
    std::visit([&](auto t) { loaded.parameters["threshold"] = t; }, *options.foreground.threshold);
  if (options.foreground.label) loaded.parameters["label"] = *options.foreground.label;
  if (options.foreground.invert) loaded.parameters["invert"] = true;
  if (!options.spacing.empty()) loaded.parameters["spacing"] = options.spacing;
}

void say_cleaned(const ForegroundReport& report, Session& session) {
  session.say(fmt::format(
      "cleaned: {} of {} dropped ({} of the shape), {} of {} filled",
      base::counted(report.components_removed, "component"), base::counted(report.voxels_removed, "voxel"),
      percent_text(report.voxels_removed, report.voxels_before),
      base::counted(report.cavities_filled, "cavity", "cavities"), base::counted(report.voxels_filled, "voxel")));
  if (const std::string much = much_dropped(report); !much.empty()) session.say("warning: " + much);
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
  say_cleaned(report, session);
  loaded.input["cleaned"] = {{"voxels_before", report.voxels_before},
                             {"components_removed", report.components_removed},
                             {"voxels_removed", report.voxels_removed},
                             {"cavities_filled", report.cavities_filled},
                             {"voxels_filled", report.voxels_filled}};
  if (f.largest_component) loaded.parameters["largest_component"] = true;
  if (f.min_component) loaded.parameters["min_component"] = f.min_component;
  if (f.fill_cavities) loaded.parameters["fill_cavities"] = true;
  if (loaded.kind == "volume") loaded.longest_side = loaded.shape.longest_side();
}

}  // namespace

std::string spacing_text(const Grid& grid, const std::string& units) {
  return fmt::format("{:.6g} x {:.6g} x {:.6g}{}{}", grid.spacing[0], grid.spacing[1], grid.spacing[2],
                     units.empty() ? "" : " ", units);
}

void say_picture(const std::string& file, const Grid& grid, Session& session) {
  std::error_code ignored;
  if (grid.dims[2] != 1 ||
      !(extension_of(file) == ".png" || is_tiff(file) || std::filesystem::is_directory(file, ignored)))
    return;
  session.say(
      fmt::format("note: '{}' is one picture of {} x {} pixels; it is taken as a slab one voxel thick, whose radii are "
                  "about half a voxel; for a 3D shape give a folder of slices or a stack",
                  file, grid.dims[0], grid.dims[1]));
}

void add_shape_options(CLI::App& app, ShapeOptions& o) {
  app.add_option("SHAPE", o.file,
                 "A mesh (.ply .obj .off .stl ...) or a volume (.nrrd .nii.gz .mha .map .vol .npy .tif, a "
                 "folder of slices ...)")
      ->type_name("")
      ->required();
  const auto group = "Shape";
  app.add_option("--resolution", o.resolution,
                 "Mesh: voxels along the longest side, 1 to 16384, or 'auto': the smallest of 128, 256 ... 2048 that "
                 "keeps the topology")
      ->type_name("N")
      ->capture_default_str()
      ->group(group)
      ->each([&o](const std::string& text) {
        parse_resolution(text);
        o.resolution_given = true;
      });
  app.add_option(
         "--fill", o.fill,
         "Mesh: overlapping and nested parts are united ('nonzero') or alternate between inside and outside "
         "('evenodd', for faces that point either way). What holes leave open, the generalized winding number "
         "decides; 'winding': faces are turned and duplicates dropped first, even if the mesh is closed; 'auto': "
         "one of these, and says why")
      ->type_name("RULE")
      ->check(one_of({"nonzero", "evenodd", "winding", "auto"}))
      ->capture_default_str()
      ->group(group)
      ->each([&o](const std::string&) { o.fill_given = true; });
  add_threshold(app, o.foreground.threshold, "Volume: the shape is the voxels of at least this value")
      ->type_name("T")
      ->group(group);
  add_label(app, o.foreground.label, "Volume: the shape is the voxels of exactly this value (0 too)")
      ->type_name("K")
      ->group(group);
  app.add_option("--spacing", o.spacing, "Volume: voxel size x,y,z (or one number), instead of the file's")
      ->type_name("SIZE")
      ->group(group);
  app.add_flag("--invert", o.foreground.invert, "Volume: the shape is all other voxels of the image")->group(group);
  app.add_flag("--largest-component", o.foreground.largest_component, "Keep the largest connected part only")
      ->group(group);
  add_number<std::int64_t>(app, "--min-component", o.foreground.min_component, "Drop connected parts of fewer voxels",
                           0)
      ->type_name("N")
      ->group(group);
  app.add_flag("--fill-cavities", o.foreground.fill_cavities, "Fill cavities that are closed all around")->group(group);
  add_number(app, "--subdivide", o.subdivide, "Split every voxel into K x K x K, K from 1 to 64", 1, 64)
      ->type_name("K")
      ->capture_default_str()
      ->group(group);
}

void check_shape_options(const ShapeOptions& options) {
  if (options.foreground.threshold && options.foreground.label)
    throw Error(ErrorCode::usage, "--threshold and --label cannot be combined; give one of them");
  parse_resolution(options.resolution);
  parse_spacing(options.spacing);
  std::error_code ignored;
  if (!std::filesystem::exists(options.file, ignored))
    throw Error(ErrorCode::failed, fmt::format("'{}' does not exist", options.file));
  if (io::kind_of(options.file) != io::Kind::unknown) return;
  refuse_unknown_kind(options.file);
}

void refuse_unknown_kind(const std::string& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    throw Error(ErrorCode::input,
                fmt::format("the folder '{}' holds no PNG or TIFF slices; give a file or a folder of slices", file));
  const std::string type = std::filesystem::path(file).extension().string(), lower = extension_of(file);
  if (lower == ".hdr" || lower == ".img")
    throw Error(ErrorCode::input, fmt::format("'{}' has the unknown file type '{}'; a pair .hdr/.img is not read; save "
                                              "it as one .nii file",
                                              file, type));
  throw Error(
      ErrorCode::input,
      fmt::format("'{}' has {}; meshes end in e.g. .ply, .obj, .off, .stl, volumes in .nrrd, .nii.gz, .mha, .map, "
                  ".vol, .npy, .tif",
                  file, type.empty() ? "no file type in its name" : fmt::format("the unknown file type '{}'", type)));
}

LoadedShape load_shape(const ShapeOptions& options, Session& session) {
  check_shape_options(options);
  std::error_code ignored;
  const auto size = std::filesystem::file_size(options.file, ignored);
  if (!ignored &&
      io::kind_of(options.file) == io::Kind::surface)  // volumes are read slice by slice, or check it themselves
    session.check_memory(static_cast<std::int64_t>(2 * size), fmt::format("reading '{}'", options.file),
                         {"a smaller file"});
  LoadedShape loaded;
  loaded.input["file"] = options.file;
  const io::Kind kind = io::kind_of(options.file);
  loaded.kind = kind == io::Kind::surface ? "mesh" : "volume";
  loaded.input["kind"] = loaded.kind;
  if (kind == io::Kind::surface)
    load_mesh(options, session, loaded);
  else
    load_volume(options, session, loaded);
  clean_as_asked(options, session, loaded);
  if (options.subdivide > 1) {
    // Two numbers per run and one per scanline, in vectors that grow; boundary vertices grow as the surface does.
    const Grid& coarse = loaded.shape.grid();
    const double parts = static_cast<double>(options.subdivide) * options.subdivide;
    double bytes = parts * (static_cast<double>(coarse.dims[1]) * static_cast<double>(coarse.dims[2]) * 4 +
                            static_cast<double>(loaded.shape.runs().size()) * 20);
    if (options.core_follows) {
      const auto sites = static_cast<std::int64_t>(parts * static_cast<double>(count_boundary_vertices(loaded.shape)));
      bytes = std::max(
          bytes, static_cast<double>(std::min(predicted_core_bytes(sites), predicted_core_bytes_in_bricks(sites))));
    }
    session.check_memory(static_cast<std::int64_t>(std::min(bytes, 0x1p62)),
                         fmt::format("--subdivide {}", options.subdivide), {"a smaller factor"});
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
  session.say(fmt::format("shape: {} x {} x {} voxels of {:.6g} x {:.6g} x {:.6g}, {} inside; {}", grid.dims[0],
                          grid.dims[1], grid.dims[2], grid.spacing[0], grid.spacing[1], grid.spacing[2],
                          loaded.shape.voxel_count(), topology_text(loaded.topology)));
  // What the surface says, where it does not tell the topology of the solid.
  if (loaded.kind == "mesh" && !loaded.topology_changed)
    if (const auto parts = loaded.input["components"].get<std::int64_t>(); loaded.topology.betti[0] > parts)
      session.say(fmt::format(
          "warning: the shape has {}, the surface of the mesh {}: what is thinner than a voxel breaks or is lost; a "
          "higher --resolution may help, --min-component N drops specks",
          base::counted(loaded.topology.betti[0], "component"), parts));
  if (loaded.kind == "volume" && loaded.topology.betti[0] > 100)
    session.say(
        fmt::format("note: the volume has {} components; --min-component N drops specks", loaded.topology.betti[0]));
  return loaded;
}

nlohmann::ordered_json topology_changed_of(const LoadedShape& loaded) {
  if (loaded.topology_changed) return *loaded.topology_changed;
  return loaded.kind == "volume" ? Json(false) : Json(nullptr);
}

std::string parameters_of(const Record& result) {
  const DataArray* array = find_array(result.field_data, "parameters");
  if (!array) return {};
  const auto* text = std::get_if<std::vector<std::string>>(&array->values);
  return text && !text->empty() ? text->front() : std::string();
}

namespace {

/// The parameters of a result, as its file says them.
class Parameters {
 public:
  Parameters(const std::string& text, const std::string& file)
      : json_(Json::parse(text, nullptr, false)), file_(file) {}

  /// The value of a parameter that the file has, if it is of the type and `possible`.
  template <class T, class Possible>
  std::optional<T> get(const char* name, bool (Json::*of_type)() const, const Possible& possible) const {
    if (!json_.is_object() || !json_.contains(name)) return {};
    const Json& value = json_[name];
    if ((value.*of_type)())
      if (const T taken = value.get<T>(); possible(taken)) return taken;
    throw Error(ErrorCode::input,
                fmt::format("'{}' says in its field 'parameters' that it was made with {} = {}, which cannot be; the "
                            "file was changed, compute it again",
                            file_, name, value.dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, 40)));
  }
  std::optional<std::int64_t> whole(const char* name, std::int64_t least, std::int64_t most) const {
    const auto value = get<Json>(name, &Json::is_number_integer, [&](const Json& number) {
      const bool beyond = number.is_number_unsigned() && number.get<std::uint64_t>() > std::uint64_t{INT64_MAX};
      return !beyond && number.get<std::int64_t>() >= least && number.get<std::int64_t>() <= most;
    });
    if (!value) return {};
    return value->get<std::int64_t>();
  }
  std::optional<Threshold> threshold() const {
    const auto value = get<Json>("threshold", &Json::is_number, [](const Json& number) {
      return !number.is_number_float() || std::isfinite(number.get<double>());
    });
    if (!value) return {};
    if (value->is_number_unsigned()) return value->get<std::uint64_t>();
    if (value->is_number_integer()) return value->get<std::int64_t>();
    return value->get<double>();
  }
  bool flag(const char* name) const {
    return get<bool>(name, &Json::is_boolean, [](bool) { return true; }).value_or(false);
  }

 private:
  Json json_;
  const std::string& file_;
};

bool is_spacing(const std::string& text) {
  try {
    return parse_spacing(text).has_value();
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

void take_parameters(ShapeOptions& options, const Record& result, const std::string& file) {
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  const Parameters p(parameters_of(result), file);
  if (const auto n = p.whole("resolution", 1, 16384); n && !options.resolution_given)
    options.resolution = std::to_string(*n);
  const auto is_rule = [](const std::string& name) { return name == "auto" || fill_of(name); };
  if (const auto rule = p.get<std::string>("fill", &Json::is_string, is_rule); rule && !options.fill_given)
    options.fill = *rule;
  ForegroundOptions& f = options.foreground;
  const std::vector<std::string> given = options_for_volumes(options);
  const auto threshold = p.threshold();
  const auto label = p.whole("label", -most - 1, most);
  if (!f.threshold && !f.label) {
    f.threshold = threshold;
    f.label = label;
  }
  if (const auto size = p.get<std::string>("spacing", &Json::is_string, is_spacing); size && options.spacing.empty())
    options.spacing = *size;
  f.invert |= p.flag("invert");
  options.recorded = options_for_volumes(options);
  for (const std::string& name : given) std::erase(options.recorded, name);
  options.recorded_in = file;
  f.largest_component |= p.flag("largest_component");
  f.fill_cavities |= p.flag("fill_cavities");
  if (const auto n = p.whole("min_component", 0, most); n && f.min_component == 0) f.min_component = *n;
  if (const auto n = p.whole("subdivide", 1, 64); n && options.subdivide == 1) options.subdivide = static_cast<int>(*n);
}

}  // namespace quench::program
