// SPDX-License-Identifier: Apache-2.0
#include "quench/shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/parallel.h"
#include "io/volume/slice_streams.h"
#include "io/volume/volume_formats.h"
#include "pipeline/finished_shape.h"
#include "pipeline/parameters.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/pipeline.h"
#include "surface/solid_boundary.h"

namespace quench::pipeline {
namespace {

/// Errors of the input in a file name the file.
template <class Work>
auto naming(const std::filesystem::path& file, const Work& work) {
  try {
    return work();
  } catch (const Error& error) {
    const std::string sentence = error.what();
    if (error.code() == ErrorCode::failed || error.code() == ErrorCode::cancelled ||
        sentence.find(file.string()) != std::string::npos)
      throw;
    throw Error(error.code(), fmt::format("'{}': {}", file.string(), sentence), error.field());
  }
}

void record(LoadedShape& loaded, const char* name, const Parameter& value) {
  loaded.parameters = with_parameters(loaded.parameters, {{name, value}});
}

/// Which voxels of an image are the shape, without what is done to them afterwards.
ForegroundOptions only_voxels(ForegroundOptions options) {
  options.largest_component = options.fill_cavities = false;
  options.min_component = options.min_cavity = 0;
  return options;
}

void record_volume(LoadedShape& loaded, const ShapeOptions& options) {
  const ForegroundOptions& f = options.foreground;
  const PreparationOptions& p = options.preparation;
  if (p.interpolate) record(loaded, "interpolate", true);
  if (p.median) record(loaded, "median", std::int64_t{p.median});
  if (p.blur > 0) record(loaded, "blur", p.blur);
  if (f.threshold) std::visit([&](auto t) { record(loaded, "threshold", t); }, *f.threshold);
  if (f.seed_threshold) std::visit([&](auto t) { record(loaded, "seed_threshold", t); }, *f.seed_threshold);
  if (f.label) record(loaded, "label", *f.label);
  if (f.invert) record(loaded, "invert", true);
  if (f.close) record(loaded, "close", std::int64_t{f.close});
  if (f.connectivity != 6) record(loaded, "connectivity", std::int64_t{f.connectivity});
  if (!options.channel.empty()) record(loaded, "channel", options.channel);
  if (options.dimension) record(loaded, "dimension", std::int64_t{*options.dimension});
  if (!options.spacing) return;
  const Vec3& s = *options.spacing;
  const std::string spelled = s[2] == 0 ? fmt::format("{},{}", s[0], s[1]) : fmt::format("{},{},{}", s[0], s[1], s[2]);
  record(loaded, "spacing", options.spacing_text.empty() ? spelled : options.spacing_text);
}

void clean_as_asked(LoadedShape& loaded, const ForegroundOptions& f, Context* context) {
  if (!f.largest_component && f.min_component == 0 && f.min_cavity == 0 && !f.fill_cavities) return;
  ForegroundReport report;
  loaded.shape = clean(loaded.shape, f, &report, context);
  if (const auto& before = loaded.cleaned) {
    report.voxels_closed = before->voxels_closed;
    report.voxels_joined = before->voxels_joined;
    report.components_joined = before->components_joined;
    report.weak_dropped = before->weak_dropped;
  }
  loaded.cleaned = report;
  if (f.largest_component) record(loaded, "largest_component", true);
  if (f.min_component) record(loaded, "min_component", f.min_component);
  if (f.fill_cavities) record(loaded, "fill_cavities", true);
  if (f.min_cavity) record(loaded, "min_cavity", f.min_cavity);
}

void subdivide_as_asked(LoadedShape& loaded, const ShapeOptions& options, const Context* context) {
  if (options.subdivide < 1 || options.subdivide > 64)
    throw Error(ErrorCode::usage, fmt::format("subdivide '{}' is not a whole number from 1 to 64", options.subdivide),
                "subdivide");
  if (options.subdivide == 1) return;
  // Two numbers per run and one per scanline, in vectors that grow; boundary vertices grow as the surface does.
  const Grid& coarse = loaded.shape.grid();
  const double parts =
      coarse.is_plane() ? options.subdivide : static_cast<double>(options.subdivide) * options.subdivide;
  double bytes = parts * (static_cast<double>(coarse.dims[1]) * static_cast<double>(coarse.dims[2]) * 4 +
                          static_cast<double>(loaded.shape.runs().size()) * 20);
  if (options.core_follows) {
    const auto sites = static_cast<std::int64_t>(parts * static_cast<double>(count_boundary_vertices(loaded.shape)));
    bytes = std::max(bytes,
                     static_cast<double>(std::min(predicted_core_bytes(sites), predicted_core_bytes_in_bricks(sites))));
  }
  require_memory(static_cast<std::int64_t>(std::min(bytes, 0x1p62)),
                 coarse.is_plane() ? fmt::format("splitting every pixel into {0} x {0}", options.subdivide)
                                   : fmt::format("splitting every voxel into {0} x {0} x {0}", options.subdivide),
                 {"a smaller factor"}, context);
  loaded.shape = subdivide(loaded.shape, options.subdivide);
  record(loaded, "subdivide", std::int64_t{options.subdivide});
}

bool wants_isosurface(const ShapeOptions& options) {
  return options.foreground.threshold && options.surface.value_or(SurfaceKind::grey) == SurfaceKind::grey;
}

void refuse_surface(SurfaceKind kind, const std::string& reason) {
  throw Error(ErrorCode::usage, fmt::format("the surface cannot be '{}': {}", name_of(kind), reason), "surface");
}

/// Refuses a surface that inputs of this kind do not have.
void check_surface(const ShapeOptions& options, bool from_mesh) {
  if (options.surface == SurfaceKind::grey && from_mesh)
    refuse_surface(SurfaceKind::grey, "a mesh has no grey values; use 'mesh', 'smooth' or 'voxels'");
  if (options.surface == SurfaceKind::mesh && !from_mesh)
    refuse_surface(SurfaceKind::mesh, "a volume is not a mesh; use 'grey', 'smooth' or 'voxels'");
}

/// The surface of cleaned voxels that are not subdivided yet: of their grey values, or smoothed.
void set_surface_of_voxels(LoadedShape& loaded, std::optional<TriangleMesh>&& isosurface, const ShapeOptions& options,
                           Context* context) {
  if (loaded.shape.grid().is_plane()) {
    if (options.surface.value_or(SurfaceKind::voxels) != SurfaceKind::voxels)
      refuse_surface(*options.surface, "results of the plane are those of its pixels; use 'voxels'");
    return;
  }
  if (options.surface == SurfaceKind::grey && !isosurface)
    refuse_surface(SurfaceKind::grey, options.foreground.threshold
                                          ? "the image has at most two values; use 'smooth' or 'voxels'"
                                          : "only a threshold cuts grey values; use 'smooth' or 'voxels'");
  const SurfaceKind kind = isosurface ? SurfaceKind::grey : SurfaceKind::smooth;
  SurfaceSmoothing smoothing;
  if (options.surface == SurfaceKind::smooth) {
    isosurface = midpoint_surface(loaded.shape, context);
    smoothing = kStepSmoothing;
  }
  if (!isosurface) return;
  if (loaded.cleaned && kind == SurfaceKind::grey) restrict_surface(*isosurface, loaded.shape);
  smooth_surface(*isosurface, smoothing, context);
  to_world(*isosurface, loaded.shape.grid());
  // Where two sheets are less than a voxel apart, smoothing may have pushed them through each other.
  loaded.surface.emplace(surface::solid_boundary(*isosurface, false, context), kind, context);
  record(loaded, "surface", std::string(name_of(kind)));
}

}  // namespace

LoadedShape finished(LoadedShape&& loaded, const ShapeOptions& options, Context* context,
                     std::optional<TriangleMesh>&& isosurface) {
  if (loaded.from_mesh) loaded.image = loaded.shape.grid();
  clean_as_asked(loaded, options.foreground, context);
  set_surface_of_voxels(loaded, std::move(isosurface), options, context);
  if (!loaded.from_mesh) loaded.longest_side = loaded.shape.longest_side();
  base::in_arena(context, [&] { subdivide_as_asked(loaded, options, context); });
  loaded.topology = topology(loaded.shape);
  checkpoint(context, "voxelize", 1);
  return std::move(loaded);
}

namespace {

/// Refuses an image of many values, or of two that are not 0, of which nobody has said what the shape is, with a
/// threshold for it.
void check_is_chosen(const Volume& image, const ForegroundOptions& options) {
  if (options.threshold || options.label) return;
  const auto proposal = propose_threshold(image);
  if (!proposal) return;
  const std::string threshold =
      std::visit([](auto t) { return fmt::format("{:.6g}", static_cast<double>(t)); }, proposal->threshold);
  const char* invert =
      proposal->bright_border ? "; its border is bright: for a dark shape on a bright ground invert it" : "";
  throw Error(
      ErrorCode::usage,
      fmt::format("the image has {}, so it is not clear what the shape is; give a threshold T (value >= T), e.g. {}, "
                  "which parts dark from bright{}, or a label K (value = K)",
                  proposal->two_values
                      ? fmt::format("the values {:.6g} and {:.6g}, and no 0", proposal->low, proposal->high)
                      : fmt::format("more than two values, from {:.6g} to {:.6g}", proposal->low, proposal->high),
                  threshold, invert),
      "threshold");
}

/// Whether foreground() has something to report.
bool is_reported(const ForegroundOptions& options) {
  return options.seed_threshold || options.close > 0 || options.connectivity != 6;
}

/// Whether the samples are wanted as a whole, and not slice by slice.
bool needs_volume(const ShapeOptions& options) {
  const ForegroundOptions& f = options.foreground;
  return options.preparation.any() || options.otsu || options.recommended || options.keep_values ||
         (f.threshold && (f.close > 0 || f.connectivity == 26));
}

/// Without what only a volume in memory allows, where it does not fit: a threshold that the program chooses (an image
/// of two values needs none, others say so) and values for later. What is asked for by name is not given up.
void give_up_values(const SliceStream& slices, const std::filesystem::path& file, ShapeOptions& options,
                    Context* context) {
  ShapeOptions without = options;
  without.recommended = without.keep_values = false;
  if (!needs_volume(options) || needs_volume(without)) return;
  if (samples_fit(slices, context)) return;
  note(context, fmt::format("'{}' does not fit into memory: it is read slice by slice, {}", file.string(),
                            options.foreground.threshold || options.foreground.label
                                ? "and its values are not looked at again"
                                : "without a look for a threshold, and its values are not looked at again"));
  options = std::move(without);
}

/// The threshold that the options leave to the program, where the image has more than two values.
void choose_threshold(LoadedShape& loaded, const Volume& volume, ShapeOptions& options, Context* context) {
  if (!options.otsu && !options.recommended) return;
  const std::vector<ProposedThreshold> proposals = proposed_thresholds(volume, context);
  const auto of_rule = [&](const char* rule) { return std::ranges::find(proposals, rule, &ProposedThreshold::rule); };
  auto proposal = options.otsu ? of_rule("otsu") : proposals.begin();
  if (options.thin && !options.foreground.invert)
    if (const auto thin = of_rule("thin"); thin != proposals.end()) proposal = thin;
  if (proposal == proposals.end()) return;
  options.foreground.threshold = proposal->value;
  options.foreground.seed_threshold = proposal->seed;
  loaded.chosen = *proposal;
}

/// The foreground of an image, and what was found on the way; `image`: of any kind that foreground() takes.
template <class Image>
void take_foreground(LoadedShape& loaded, const Image& image, const ShapeOptions& options,
                     std::optional<TriangleMesh>& isosurface, Context* context) {
  const bool surface = wants_isosurface(options) && !image.grid.is_plane();
  ForegroundReport report;
  loaded.image = image.grid;
  loaded.shape = foreground(image, only_voxels(options.foreground), &report, context, surface ? &isosurface : nullptr);
  if (is_reported(options.foreground)) loaded.cleaned = report;
}

/// The same of a volume that is in memory: preparing, a threshold, the voxels.
void take_volume(LoadedShape& loaded, Volume&& volume, ShapeOptions& options, std::optional<TriangleMesh>& isosurface,
                 Context* context) {
  if (options.preparation.any()) {
    require_memory(predicted_preparation_bytes(volume, options.preparation), "preparing the volume",
                   {"a smaller volume"}, context);
    ForegroundOptions grey = options.foreground;
    if (!grey.threshold && (options.otsu || options.recommended)) grey.threshold = 0.0;  // chosen afterwards
    volume = prepared(std::move(volume), options.preparation, grey, &loaded.prepared.emplace(), context);
  }
  choose_threshold(loaded, volume, options, context);
  if (volume.grid.is_plane()) check_is_chosen(volume, options.foreground);
  take_foreground(loaded, volume, options, isosurface, context);
  if (options.keep_values) loaded.values = std::move(volume);
}

void check_choice(const ShapeOptions& options) {
  const ForegroundOptions& f = options.foreground;
  const int ways = (f.threshold ? 1 : 0) + (f.label ? 1 : 0) + options.otsu + options.recommended;
  if (ways > 1)
    throw Error(ErrorCode::usage, "thresholds, a rule for a threshold and a label cannot be combined; give one of them",
                "threshold");
}

LoadedShape shape_of_file(const std::filesystem::path& file, ShapeOptions options, Context* context) {
  check_surface(options, false);
  check_choice(options);
  LoadedShape loaded;
  const io::VolumeReadOptions how = read_options(options);
  const auto describe = [&](const auto& image) {
    loaded.coordinates = image.coordinates;
    loaded.spacing_source = image.spacing_source;
  };
  const auto slices = io::open_slices(file, how, context);
  std::optional<TriangleMesh> isosurface;
  if (slices && !slices->grid.is_plane()) give_up_values(*slices, file, options, context);
  if (slices && !slices->grid.is_plane() && !needs_volume(options)) {
    describe(*slices);
    naming(file, [&] { take_foreground(loaded, *slices, options, isosurface, context); });
  } else {
    Volume volume = slices ? io::read_stream(*slices, file, context) : io::read_volume(file, how, context);
    checkpoint(context, "read", 1);
    describe(volume);
    naming(file, [&] { take_volume(loaded, std::move(volume), options, isosurface, context); });
  }
  checkpoint(context, "voxelize", 1);
  record_volume(loaded, options);
  return finished(std::move(loaded), options, context, std::move(isosurface));
}

}  // namespace

std::optional<Vec3> spacing_in(std::string_view text) {
  std::vector<double> sides;
  for (const char *at = text.data(), *end = at + text.size();; ++at) {
    double side = 0;
    const auto [next, error] = std::from_chars(at, end, side);
    if (error != std::errc() || !(side > 0) || !std::isfinite(side)) return {};
    sides.push_back(side);
    at = next;
    if (at == end) break;
    if (*at != ',') return {};
  }
  if (sides.size() == 1) sides.resize(3, sides[0]);
  if (sides.size() == 2) sides.push_back(0);
  if (sides.size() != 3) return {};
  return Vec3(sides[0], sides[1], sides[2]);
}

io::VolumeReadOptions read_options(const ShapeOptions& options) {
  return {.spacing = options.spacing, .dimension = options.dimension, .channel = options.channel};
}

int LoadedShape::subdivided() const {
  return static_cast<int>(std::lround(image.spacing[0] / shape.grid().spacing[0]));
}

std::optional<bool> LoadedShape::topology_changed() const {
  if (!from_mesh) return false;
  if (!voxelization || !voxelization->topology_known) return {};
  return voxelization->topology_changed;
}

void require_voxelization_memory(const TriangleMesh& mesh, std::int64_t resolution, const Context* context) {
  if (resolution > kLargestResolution) return;  // the voxelizer has the sentence for it, as for bad triangles
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t p : triangle) {
      if (p >= mesh.points.size()) return;
      low = low.cwiseMin(mesh.points[p]);
      high = high.cwiseMax(mesh.points[p]);
    }
  // Up to four numbers per scanline, and two runs.
  const Vec3 sides = (high - low) / (high - low).maxCoeff() * static_cast<double>(resolution) + Vec3::Constant(3);
  const double bytes = 32 * sides[1] * sides[2];
  if (std::isfinite(bytes))
    require_memory(static_cast<std::int64_t>(bytes), fmt::format("the voxel shape at resolution {}", resolution),
                   {"a lower resolution"}, context);
}

void refuse_unknown_kind(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    throw Error(ErrorCode::input,
                fmt::format("the folder '{}' holds no PNG, TIFF or DICOM slices; give a file or a folder of slices",
                            file.string()));
  const std::string type = file.extension().string();
  std::string lower = type;
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (lower == ".hdr" || lower == ".img")
    throw Error(ErrorCode::input, fmt::format("'{}' has the unknown file type '{}'; a pair .hdr/.img is not read; save "
                                              "it as one .nii file",
                                              file.string(), type));
  throw Error(ErrorCode::input,
              fmt::format("'{}' has {}; meshes end in e.g. .ply, .obj, .off, .stl, volumes in .nrrd, .nii.gz, .mha, "
                          ".map, .vol, .npy, .tif, .h5, .dcm, images in .png, .tif, .bmp, .jpg, .pgm",
                          file.string(),
                          type.empty() ? "no file type in its name" : fmt::format("the unknown file type '{}'", type)));
}

namespace {

/// Why the mesh does not bound the shape; empty where it does.
std::string not_its_boundary(const LoadedShape& loaded, const ShapeOptions& options) {
  if (options.foreground.fill_cavities || options.foreground.min_cavity > 1) return "its cavities are filled";
  if (!loaded.voxelization->sound || loaded.voxelization->fill == FillRule::winding)
    return "winding numbers decide what is inside of it, not its faces as they are";
  return {};
}

void set_surface(LoadedShape& loaded, const TriangleMesh& mesh, const ShapeOptions& options, Context* context) {
  if (options.surface.value_or(SurfaceKind::mesh) != SurfaceKind::mesh) return;
  if (const std::string reason = not_its_boundary(loaded, options); !reason.empty()) {
    if (options.surface) refuse_surface(SurfaceKind::mesh, reason + "; use 'smooth' or 'voxels'");
    return;
  }
  record(loaded, "surface", std::string(name_of(SurfaceKind::mesh)));
  const bool odd = loaded.voxelization->fill == FillRule::evenodd;
  loaded.surface.emplace(surface::solid_boundary(mesh, odd, context), SurfaceKind::mesh, context);
}

}  // namespace

LoadedShape shape_of(TriangleMesh&& mesh, const ShapeOptions& options, Context* context) {
  check_surface(options, true);
  LoadedShape loaded;
  loaded.from_mesh = true;
  loaded.mesh_points = mesh.points.size();
  loaded.mesh_triangles = mesh.triangles.size();
  VoxelizeOptions voxelize_options;
  voxelize_options.fill = options.fill.value_or(FillRule::nonzero);
  voxelize_options.resolution = options.resolution.value_or(voxelize_options.resolution);
  voxelize_options.topology = options.topology.value_or(voxelize_options.topology);
  if (options.resolution == kAutomaticResolution) {
    loaded.voxelization = voxelize_auto(mesh, voxelize_options, context);
  } else {
    require_voxelization_memory(mesh, voxelize_options.resolution, context);
    loaded.voxelization = voxelize(mesh, voxelize_options, context);
  }
  loaded.shape = std::exchange(loaded.voxelization->shape, {});
  loaded.longest_side = loaded.voxelization->longest_side;
  loaded.resolution = std::llround(loaded.longest_side / loaded.shape.grid().spacing[0]);
  record(loaded, "resolution", loaded.resolution);
  record(loaded, "fill", std::string(fill_name(voxelize_options.fill)));
  if (voxelize_options.topology != TopologyRule::voxels)  // what a file without it was made with
    record(loaded, "topology", std::string(topology_name(voxelize_options.topology)));
  set_surface(loaded, mesh, options, context);
  if (options.keep_mesh) loaded.mesh = std::move(mesh);
  return finished(std::move(loaded), options, context);
}

LoadedShape shape_of(const ImageView& image, const Coordinates& coordinates, const ShapeOptions& options,
                     Context* context) {
  ImageView view = image;
  if (options.spacing) io::take_spacing("the image", *options.spacing, view.grid);
  if (view.grid.is_plane()) view.grid.make_plane();
  check_surface(options, false);
  check_choice(options);
  LoadedShape loaded;
  loaded.coordinates = coordinates;
  ShapeOptions chosen = options;
  std::optional<TriangleMesh> isosurface;
  if (needs_volume(options)) {
    Volume volume = volume_of(view);
    volume.coordinates = coordinates;
    take_volume(loaded, std::move(volume), chosen, isosurface, context);
  } else {
    take_foreground(loaded, view, chosen, isosurface, context);
  }
  record_volume(loaded, chosen);
  return finished(std::move(loaded), chosen, context, std::move(isosurface));
}

LoadedShape shape_of(VoxelShape&& voxels, const Grid& image, const ShapeOptions& options, Context* context) {
  check_surface(options, false);
  LoadedShape loaded;
  loaded.shape = std::move(voxels);
  loaded.image = image;
  record_volume(loaded, options);
  return finished(std::move(loaded), options, context);
}

LoadedShape load_shape(const std::filesystem::path& file, const ShapeOptions& options, Context* context) {
  const io::Kind kind = io::kind_of(file);
  if (kind == io::Kind::unknown) refuse_unknown_kind(file);
  if (kind == io::Kind::volume) return shape_of_file(file, options, context);
  if (kind == io::Kind::polygons)
    return naming(file, [&] { return shape_of(feature_of(file, options.feature, context), options, context); });
  return shape_of(read_surface(file, context), file, options, context);
}

LoadedShape shape_of(Record&& data, const std::filesystem::path& file, const ShapeOptions& options, Context* context) {
  if (const std::string_view name = result_name(data); !name.empty())
    throw Error(
        ErrorCode::input,
        fmt::format("'{}' is a {}, not a shape; give the mesh, volume or image it was made of", file.string(), name));
  const bool lps = field_text(data, "SPACE") == "LPS";  // as 3D Slicer marks its models
  TriangleMesh mesh = to_triangle_mesh(data);
  data = {};
  if (mesh.triangles.empty())
    throw Error(ErrorCode::input, fmt::format("'{}' holds no faces; a shape needs a closed surface", file.string()));
  checkpoint(context, "read", 1);
  LoadedShape loaded = naming(file, [&] { return shape_of(std::move(mesh), options, context); });
  if (lps) loaded.coordinates.space = "LPS";
  return loaded;
}

}  // namespace quench::pipeline
