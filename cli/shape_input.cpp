// SPDX-License-Identifier: Apache-2.0
#include "shape_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/text.h"
#include "option_checks.h"
#include "quench/io.h"
#include "report.h"
#include "units.h"

namespace quench::program {
namespace {

using Json = nlohmann::ordered_json;
using pipeline::LoadedShape;

std::int64_t parse_resolution(const std::string& text) {
  if (text == "auto") return pipeline::kAutomaticResolution;
  std::int64_t value = 0;
  if (!is_number(text, value) || value < 1 || value > pipeline::kLargestResolution)
    throw Error(ErrorCode::usage, fmt::format("--resolution '{}' is not a whole number from 1 to {} or 'auto'", text,
                                              pipeline::kLargestResolution));
  return value;
}

std::string threshold_text(const Threshold& threshold) {
  return std::visit([](auto t) { return fmt::format("{:.6g}", static_cast<double>(t)); }, threshold);
}

/// Whether parts are dropped or filled on request.
bool is_cleaned(const ForegroundOptions& f) {
  return f.largest_component || f.min_component > 0 || f.fill_cavities || f.min_cavity > 0;
}

std::string topology_text(const Topology& t, bool plane) {
  if (plane) return fmt::format("{}, {}", base::counted(t.betti[0], "component"), base::counted(t.betti[1], "hole"));
  return fmt::format("{}, {}, {}", base::counted(t.betti[0], "component"), base::counted(t.betti[1], "tunnel"),
                     base::counted(t.betti[2], "cavity", "cavities"));
}

void say_voxelization(const ShapeOptions& options, const LoadedShape& shape, Session& session) {
  const Voxelization& v = *shape.voxelization;
  if (!v.fill_reason.empty()) session.say(fmt::format("fill {} (auto): {}", fill_name(v.fill), v.fill_reason));
  if (!v.sound) session.say("warning: " + defects_text(v));
  if (!v.topology_known && v.sound)
    session.say("note: parts of the mesh overlap, so whether voxelization changed the topology cannot be told from it");
  if (const std::string text = v.repair ? repair_text(*v.repair) : ""; !text.empty()) session.say(text);
  if (v.topology_changed) session.say("warning: voxelization changed the topology: " + v.topology_difference);
  if (options.how.resolution == pipeline::kAutomaticResolution)
    session.say(fmt::format("resolution {} (auto)", shape.resolution));
}

bool is_tiff(const std::string& file) { return extension_of(file) == ".tif" || extension_of(file) == ".tiff"; }

/// "0.5 x 0.5 x 2 um", "0.5 x 0.5 um": the sides of a voxel or pixel.
std::string spacing_text(const Grid& grid, const std::string& units) {
  const std::string unit = units.empty() ? "" : " " + units;
  if (grid.is_plane()) return fmt::format("{:.6g} x {:.6g}{}", grid.spacing[0], grid.spacing[1], unit);
  return fmt::format("{:.6g} x {:.6g} x {:.6g}{}", grid.spacing[0], grid.spacing[1], grid.spacing[2], unit);
}

void say_volume(const ShapeOptions& options, const LoadedShape& shape, Session& session) {
  if (!options.how.spacing && !shape.spacing_source.empty() && is_tiff(options.file))
    session.say(
        fmt::format("note: spacing {} from {}",
                    spacing_text(shape.prepared ? shape.prepared->before : shape.image, shape.coordinates.units),
                    shape.spacing_source));
}

void say_prepared(const ShapeOptions& options, const LoadedShape& shape, Session& session) {
  const ForegroundOptions& f = options.how.foreground;
  const char* of = shape.shape.grid().is_plane() ? "pixel" : "voxel";
  if (shape.prepared)
    for (const std::string& sentence : shape.prepared->done) session.say(sentence);
  if (shape.chosen)
    session.say(fmt::format("threshold {}{} ({}): {}", threshold_text(shape.chosen->value),
                            shape.chosen->seed ? "," + threshold_text(*shape.chosen->seed) : "", shape.chosen->rule,
                            shape.chosen->reason));
  if (!shape.cleaned) return;
  const ForegroundReport& c = *shape.cleaned;
  if (f.seed_threshold || c.weak_dropped > 0)
    session.say(fmt::format("weak: {} dropped that are not connected to one of at least the upper threshold",
                            base::counted(c.weak_dropped, of)));
  if (f.close > 0) session.say(fmt::format("closed: {} added", base::counted(c.voxels_closed, of)));
  if (c.voxels_joined > 0)
    session.say(fmt::format("joined: {} added, which make {} less", base::counted(c.voxels_joined, of),
                            base::counted(c.components_joined, "component")));
}

void say_cleaned(const ForegroundReport& report, bool plane, Session& session) {
  const char* of = plane ? "pixel" : "voxel";
  session.say(fmt::format("cleaned: {} of {} dropped ({} of the shape), {} of {} filled",
                          base::counted(report.components_removed, "component"),
                          base::counted(report.voxels_removed, of),
                          percent_text(report.voxels_removed, report.voxels_before),
                          plane ? base::counted(report.cavities_filled, "hole")
                                : base::counted(report.cavities_filled, "cavity", "cavities"),
                          base::counted(report.voxels_filled, of)));
  if (const std::string much = much_dropped(report, plane); !much.empty()) session.say("warning: " + much);
}

/// Whether most pixels at the sides of an image are of the shape.
bool covers_border(const VoxelShape& shape) {
  const auto& dims = shape.grid().dims;
  std::int64_t inside = 0, all = 0;
  for (std::int64_t y = 0; y < dims[1]; ++y)
    for (std::int64_t x = 0; x < dims[0]; x += y == 0 || y + 1 == dims[1] || dims[0] == 1 ? 1 : dims[0] - 1) {
      inside += shape.contains(x, y, 0);
      ++all;
    }
  return 2 * inside > all;
}

/// Holes of a few pixels are mostly noise, and each makes a loop.
void say_small_holes(const VoxelShape& shape, Session& session) {
  constexpr std::int64_t kSmall = 10;
  const std::vector<std::int64_t> sizes = cavity_sizes(shape);
  if (const auto small = std::ranges::count_if(sizes, [](std::int64_t n) { return n < kSmall; }); small > 0)
    session.say(fmt::format("note: {} of fewer than {} pixels, and loops around them; --min-hole {} fills such holes",
                            small == 1 ? "there is a hole" : fmt::format("there are {} holes", small), kSmall, kSmall));
}

/// Many components of a few voxels are mostly noise, and each is a part of every result: what takes them away without
/// taking much of the shape, and what makes them one with the others.
void say_specks(const ShapeOptions& options, const LoadedShape& shape, Session& session) {
  constexpr std::int64_t kTiny = 30;    // voxels
  constexpr std::int64_t kMany = 10;    // components
  constexpr std::int64_t kLittle = 20;  // one in so many voxels of the shape
  const std::int64_t components = shape.topology.betti[0];
  if (components < kMany) return;
  const Specks specks = specks_of(shape.shape, kTiny, &session.context);
  if (specks.count < kMany || 2 * specks.count < components) return;
  std::vector<std::string> ways;
  if (specks.voxels * kLittle <= shape.shape.voxel_count())
    ways.push_back(fmt::format("--min-component {} drops them", kTiny));
  if (!shape.from_mesh && !shape.polygon && options.how.foreground.connectivity == 6 &&
      2 * specks.touching >= specks.count)
    ways.push_back(fmt::format("--connectivity 26 joins {} that touch others", specks.touching));
  if (ways.empty()) return;
  session.say(fmt::format("note: {} of the {} components have fewer than {} {}s, together {} of the shape; {}",
                          specks.count, components, kTiny, shape.shape.grid().is_plane() ? "pixel" : "voxel",
                          percent_text(specks.voxels, shape.shape.voxel_count()), fmt::join(ways, ", ")));
}

/// What the voxels are, and what their number of components may mean.
void say_shape(const ShapeOptions& options, const LoadedShape& shape, Session& session) {
  const Grid& grid = shape.shape.grid();
  const bool plane = grid.is_plane();
  session.say(fmt::format("shape: {} of {}, {} inside; {}",
                          plane ? fmt::format("{} x {} pixels", grid.dims[0], grid.dims[1])
                                : fmt::format("{} x {} x {} voxels", grid.dims[0], grid.dims[1], grid.dims[2]),
                          spacing_text(grid, ""), shape.shape.voxel_count(), topology_text(shape.topology, plane)));
  const std::int64_t components = shape.topology.betti[0];
  // What the surface says, where it does not tell the topology of the solid.
  if (shape.from_mesh && !shape.topology_changed() && components > shape.voxelization->surface.components)
    session.say(
        fmt::format("warning: the shape has {}, the surface of the mesh {}: what is thinner than a voxel breaks or is "
                    "lost; a higher --resolution may help",
                    base::counted(components, "component"), shape.voxelization->surface.components));
  if (plane && !shape.polygon) {
    if (covers_border(shape.shape))
      session.say("note: the shape covers most of the border of the image; --invert takes the other pixels");
    say_small_holes(shape.shape, session);
  }
  say_specks(options, shape, session);
}

void add_mesh(Json& input, const LoadedShape& shape) {
  const Voxelization& v = *shape.voxelization;
  const SurfaceDefects& d = v.defects;
  input["vertices"] = shape.mesh_points;
  input["faces"] = shape.mesh_triangles;
  input["euler"] = v.surface.surface_euler;
  input["components"] = v.surface.components;
  input["manifold"] = v.surface.manifold;
  input["fill"] = fill_name(v.fill);
  if (!v.fill_reason.empty()) input["fill_reason"] = v.fill_reason;
  input["sound"] = v.sound;
  input["defects"] = {{"open_edges", d.open_edges},
                      {"unbalanced_edges", d.unbalanced_edges},
                      {"degenerate_faces", d.degenerate_faces},
                      {"duplicate_faces", d.duplicate_faces},
                      {"flipped_faces", d.flipped_faces},
                      {"filled_holes", d.filled_holes},
                      {"flipped_components", d.flipped_components},
                      {"scanlines", d.scanlines},
                      {"defective_scanlines", d.defective_scanlines},
                      {"winding_share", d.winding_share},
                      {"doubtful_share", d.doubtful_share}};
}

}  // namespace

CLI::Option* add_channel(CLI::App& app, std::string& channel) {
  return app
      .add_option("--channel", channel,
                  "Image with colours: what becomes the value of a pixel: 'luminance' (of Rec. 601, on white where it "
                  "is transparent), 'alpha', 'red', 'green' or 'blue'; without it alpha where all that is seen has one "
                  "colour, else luminance")
      ->type_name("NAME")
      ->check(one_of({"luminance", "alpha", "red", "green", "blue"}));
}

CLI::Option* add_dimension(CLI::App& app, std::optional<int>& dimension) {
  return add_parsed(
             app, "--dimension",
             "Volume of one slice: 2 takes it as an image of the plane, 3 as a slab one voxel thick; 3 takes an image "
             "so, too",
             [&dimension](const std::string&, const std::string& text) { dimension = text == "2" ? 2 : 3; })
      ->type_name("N")
      ->check(one_of({"2", "3"}));
}

CLI::Option* add_resolution(CLI::App& app, ShapeOptions& o, const std::string& help) {
  return add_parsed(app, "--resolution", help,
                    [&o](const std::string&, const std::string& text) { o.how.resolution = parse_resolution(text); })
      ->type_name("N")
      ->check(also({"auto"}));
}

CLI::Option* add_fill(CLI::App& app, ShapeOptions& o, const std::string& help) {
  return add_parsed(app, "--fill", help,
                    [&o](const std::string&, const std::string& text) { o.how.fill = fill_of(text); })
      ->type_name("RULE")
      ->check(one_of({"nonzero", "evenodd", "winding", "auto"}));
}

CLI::Option* add_topology(CLI::App& app, ShapeOptions& o, const std::string& help) {
  return add_parsed(app, "--topology", help,
                    [&o](const std::string&, const std::string& text) { o.how.topology = topology_of(text); })
      ->type_name("RULE")
      ->check(one_of({"mesh", "voxels"}));
}

/// T, LOW,HIGH, or a rule.
static void parse_threshold(const std::string& option, const std::string& text, pipeline::ShapeOptions& how) {
  how.foreground.threshold = how.foreground.seed_threshold = std::nullopt;
  how.otsu = text == "otsu";
  how.thin = text == "thin";
  how.recommended = text == "auto" || how.thin;
  if (how.otsu || how.recommended) return;
  const std::size_t comma = text.find(',');
  how.foreground.threshold = threshold_of(option, text.substr(0, comma));
  if (comma != std::string::npos) how.foreground.seed_threshold = threshold_of(option, text.substr(comma + 1));
}

void add_volume_options(CLI::App& app, pipeline::ShapeOptions& how, const std::string& of, const std::string& group) {
  ForegroundOptions& f = how.foreground;
  PreparationOptions& p = how.preparation;
  add_parsed(app, "--threshold",
             of + "the shape is the voxels or pixels of at least this value; LOW,HIGH: of at least LOW, and connected "
                  "to one of at least HIGH; 'auto': at what cuts most of the edges, which info shows; 'thin': two "
                  "thresholds for thin things; 'otsu': by Otsu's method",
             [&how](const std::string& option, const std::string& text) { parse_threshold(option, text, how); })
      ->type_name("T")
      ->check(also({"auto", "thin", "otsu"}))
      ->group(group);
  add_label(app, f.label, of + "the shape is the voxels or pixels of exactly this value (0 too)")
      ->type_name("K")
      ->group(group);
  app.add_flag("--interpolate", p.interpolate,
               of + "resample thick slices to cubes first: labels and masks by distances in the slices, grey values "
                    "linearly")
      ->group(group);
  add_number(app, "--median", p.median,
             of + "replace every value by the median of the (2N+1)^3 around it, before the threshold, N up to 16", 0,
             kLargestMedian)
      ->type_name("N")
      ->group(group);
  add_number(app, "--blur", p.blur,
             of + "blur the values before the threshold with a Gaussian of this standard deviation, in voxels of the "
                  "smallest spacing, up to 100",
             0.0, kLargestBlur)
      ->type_name("SIGMA")
      ->group(group);
  add_number(app, "--close", f.close,
             of + "close gaps and cracks with a ball of this radius, in voxels of the smallest spacing, up to 64", 0,
             kLargestClosing)
      ->type_name("N")
      ->group(group);
  add_parsed(app, "--connectivity",
             of + "26: join voxels that touch in edges or corners only (pixels: in corners) with as few voxels as "
                  "possible",
             [&f](const std::string&, const std::string& text) { f.connectivity = text == "26" ? 26 : 6; })
      ->type_name("N")
      ->check(one_of({"6", "26"}))
      ->default_str("6")
      ->group(group);
}

bool has_volume_options(const pipeline::ShapeOptions& how) {
  const ForegroundOptions& f = how.foreground;
  return f.threshold || f.label || how.otsu || how.recommended || how.preparation.any() || f.close > 0 ||
         f.connectivity != 6;
}

void add_shape_options(CLI::App& app, ShapeOptions& o) {
  app.add_option("SHAPE", o.file,
                 "A mesh (.ply .obj .off .stl ...), a volume (.nrrd .nii.gz .mha .map .vol .npy .tif, a folder of "
                 "slices ...) or an image (.png .tif .bmp .jpg .pgm ...)")
      ->type_name("")
      ->required();
  const auto group = "Shape";
  add_resolution(app, o,
                 "Mesh: voxels along the longest side, 1 to 16384, or 'auto': the smallest of 128, 256 ... 2048 that "
                 "keeps the topology; polygons: pixels (1024)")
      ->default_str("256")
      ->group(group);
  add_fill(app, o,
           "Mesh: overlapping and nested parts are united ('nonzero') or alternate between inside and outside "
           "('evenodd', for faces that point either way). What holes leave open, the generalized winding number "
           "decides; 'winding': faces are turned and duplicates dropped first, even if the mesh is closed; 'auto': "
           "one of these, and says why")
      ->default_str("nonzero")
      ->group(group);
  add_topology(app, o,
               "Mesh: 'mesh' puts in and takes out a few voxels where the voxel shape would break or join what the "
               "mesh does not, so that it has as many components, tunnels and cavities; 'voxels': every voxel whose "
               "centre is inside, and no other")
      ->default_str("mesh")
      ->group(group);
  add_parsed(app, "--pixel",
             "Polygons: the side of a pixel in the units of the file, instead of a resolution (of 1024)",
             [&o](const std::string&, const std::string& text) {
               double side = 0;
               if (!is_number(text, side) || !(side > 0) || !std::isfinite(side))
                 throw Error(ErrorCode::usage, fmt::format("--pixel '{}' is not a length above 0", text));
               o.how.pixel = side;
             })
      ->type_name("LENGTH")
      ->group(group);
  add_parsed(app, "--feature", "Polygons: the number of the feature of the file, from 0",
             [&o](const std::string&, const std::string& text) {
               std::int64_t number = 0;
               if (!is_number(text, number) || number < 0)
                 throw Error(ErrorCode::usage, fmt::format("--feature '{}' is not a whole number from 0 on", text));
               o.how.feature = static_cast<std::uint64_t>(number);
             })
      ->type_name("K")
      ->group(group);
  ForegroundOptions& f = o.how.foreground;
  add_volume_options(app, o.how, "Volume, image: ", group);
  add_parsed(
      app, "--spacing", "Volume, image: voxel size x,y,z or pixel size x,y (or one number), instead of the file's",
      [&o](const std::string&, const std::string& text) {
        o.how.spacing = pipeline::spacing_in(text);
        o.how.spacing_text = text;
        if (!o.how.spacing)
          throw Error(
              ErrorCode::usage,
              fmt::format("--spacing '{}' is not a voxel or pixel size; give one positive number, three as x,y,z, or "
                          "two as x,y for an image",
                          text));
      })
      ->type_name("SIZE")
      ->group(group);
  add_channel(app, o.how.channel)->group(group);
  add_dimension(app, o.how.dimension)->group(group);
  app.add_flag("--invert", f.invert, "Volume, image: the shape is all other voxels or pixels")->group(group);
  app.add_flag("--largest-component", f.largest_component, "Keep the largest connected part only")->group(group);
  add_number<std::int64_t>(app, "--min-component", f.min_component, "Drop connected parts of fewer voxels", 0)
      ->type_name("N")
      ->group(group);
  app.add_flag("--fill-cavities,--fill-holes", f.fill_cavities,
               "Fill cavities that are closed all around; of an image its holes")
      ->group(group);
  add_number<std::int64_t>(app, "--min-hole", f.min_cavity,
                           "Fill holes (of a volume cavities) of fewer pixels or voxels", 0)
      ->type_name("N")
      ->group(group);
  add_parsed(
      app, "--surface",
      "What points and radii are fitted to: 'voxels' (nothing), the 'mesh', the 'grey' values of a volume at its "
      "threshold, 'smooth' (a smoothed surface of the voxels, for masks and labels), or 'auto': the mesh where its "
      "solid "
      "can be told, grey values where a threshold cuts more than two, else the voxels",
      [&o](const std::string&, const std::string& text) { o.how.surface = surface_kind_of(text); },
      [&o] { return std::string(o.how.surface ? name_of(*o.how.surface) : "auto"); })
      ->type_name("KIND")
      ->check(one_of({"auto", "voxels", "mesh", "grey", "smooth"}))
      ->capture_default_str()
      ->group(group);
  add_number(app, "--subdivide", o.how.subdivide, "Split every voxel into K x K x K, K from 1 to 64", 1, 64)
      ->type_name("K")
      ->capture_default_str()
      ->group(group);
}

void say_ignored(const ShapeOptions& options, io::Kind kind, Session& session, bool plane) {
  const bool mesh = kind == io::Kind::surface, polygons = kind == io::Kind::polygons;
  const ForegroundOptions& f = options.how.foreground;
  std::vector<std::string> given, recorded;
  const auto add = [&](const char* name, bool is_set) {
    const bool was_recorded = std::ranges::find(options.recorded, name) != options.recorded.end();
    if (is_set) (was_recorded ? recorded : given).emplace_back(name);
  };
  if (mesh || polygons) {
    add("--threshold", f.threshold || options.how.otsu || options.how.recommended);
    add("--label", f.label.has_value());
    add("--interpolate", options.how.preparation.interpolate);
    add("--median", options.how.preparation.median > 0);
    add("--blur", options.how.preparation.blur > 0);
    add("--close", f.close > 0);
    add("--connectivity", f.connectivity != 6);
    add("--invert", f.invert);
    add("--spacing", options.how.spacing.has_value());
    add("--channel", !options.how.channel.empty());
    add("--dimension", options.how.dimension.has_value());
  } else {
    add("--resolution", options.how.resolution.has_value());
    add("--fill", options.how.fill.has_value());
  }
  if (!mesh) add("--topology", options.how.topology.has_value());
  if (!polygons) {
    add("--pixel", options.how.pixel.has_value());
    add("--feature", options.how.feature.has_value());
  }
  if (!mesh) recorded.clear();
  const auto say = [&](const std::vector<std::string>& names, const std::string& where) {
    if (names.empty()) return;
    const char* verb = names.size() == 1 ? "is" : "are";
    if (polygons)
      return session.say(fmt::format("note: {}{} {} ignored for polygons", fmt::join(names, ", "), where, verb));
    session.say(fmt::format("note: {}{} {} for {} and {} ignored for {}", fmt::join(names, ", "), where, verb,
                            mesh ? "volumes" : "meshes", verb,
                            mesh    ? "a mesh"
                            : plane ? "an image"
                                    : "a volume"));
  };
  say(given, "");
  say(recorded, fmt::format(" (recorded in '{}')", options.recorded_in));
}

void check_exists(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(io::place_of_input(file), ignored))
    throw Error(ErrorCode::failed, fmt::format("'{}' does not exist", file.string()));
}

void check_shape_options(const ShapeOptions& options) {
  const pipeline::ShapeOptions& how = options.how;
  if ((how.foreground.threshold || how.otsu || how.recommended) && how.foreground.label)
    throw Error(ErrorCode::usage, "--threshold and --label cannot be combined; give one of them");
  if (how.pixel && how.resolution)
    throw Error(ErrorCode::usage, "--pixel and --resolution cannot be combined; give one of them");
  check_exists(options.file);
  if (io::kind_of(options.file) == io::Kind::unknown) pipeline::refuse_unknown_kind(options.file);
}

void refuse_result(const Record& data, const std::string& file) {
  const std::string_view name = pipeline::result_name(data);
  if (name.empty()) return;
  const bool is_said = pipeline::field_text(data, "stage").has_value();
  throw Error(
      ErrorCode::input,
      fmt::format("'{}' is a {}, not a shape; give the mesh, volume or image it was made of, or give it to {}{}", file,
                  name,
                  name == "skeleton"      ? "'quench view' or 'quench tree'"
                  : name == "medial axis" ? "'quench burn' or 'quench skeleton'"
                                          : "'quench skeleton' or 'quench view'",
                  is_said ? "" : "; if it is a mesh, remove its point array 'radius'"));
}

static LoadedShape load_mesh(const ShapeOptions& options, Session& session) {
  Record data = pipeline::read_surface(options.file, &session.context);
  refuse_result(data, options.file);
  return pipeline::shape_of(std::move(data), options.file, options.how, &session.context);
}

void choose_surface_in_bricks(ShapeOptions& shape, Session& session) {
  if (shape.how.surface || io::kind_of(shape.file) != io::Kind::volume) return;
  shape.how.surface = SurfaceKind::voxels;
  if (shape.how.foreground.threshold || shape.how.otsu || shape.how.recommended)
    session.say(
        "note: in bricks the axis of a volume is that of its voxels, as with --surface voxels; with --surface grey "
        "every task has all of that surface in memory");
}

LoadedShape load_shape(const ShapeOptions& options, Session& session) {
  check_shape_options(options);
  const io::Kind kind = io::kind_of(options.file);
  const bool perhaps_plane = kind == io::Kind::volume;  // known when it is read
  if (!perhaps_plane) say_ignored(options, kind, session);
  LoadedShape shape = kind == io::Kind::surface ? load_mesh(options, session)
                                                : pipeline::load_shape(options.file, options.how, &session.context);
  take_units(shape.coordinates, options.file, session);
  if (shape.values) shape.values->coordinates.units = shape.coordinates.units;
  if (perhaps_plane) say_ignored(options, kind, session, shape.shape.grid().is_plane());
  if (shape.from_mesh)
    say_voxelization(options, shape, session);
  else
    say_volume(options, shape, session);
  say_prepared(options, shape, session);
  if (shape.cleaned && is_cleaned(options.how.foreground))
    say_cleaned(*shape.cleaned, shape.shape.grid().is_plane(), session);
  say_shape(options, shape, session);
  return shape;
}

/// "mesh", "volume", "image", "polygons".
static std::string kind_text(const LoadedShape& shape) {
  if (shape.from_mesh) return "mesh";
  if (shape.polygon) return "polygons";
  return shape.shape.grid().is_plane() ? "image" : "volume";
}

Json input_section(const ShapeOptions& options, const LoadedShape& shape) {
  const bool plane = shape.shape.grid().is_plane();
  Json input = {{"file", options.file}, {"kind", kind_text(shape)}};
  if (shape.from_mesh) {
    add_mesh(input, shape);
    if (!shape.coordinates.units.empty()) input["units"] = shape.coordinates.units;
  } else {
    if (!shape.coordinates.units.empty()) input["units"] = shape.coordinates.units;
    if (!shape.coordinates.space.empty()) input["space"] = shape.coordinates.space;
    input["spacing"] = spacing_json(shape.image);
    if (plane) input["y_axis"] = shape.coordinates.y_down ? "down" : "up";
    const std::string from = options.how.spacing ? "--spacing" : shape.spacing_source;
    if (!from.empty()) input["spacing_source"] = from;
  }
  const ForegroundOptions& f = options.how.foreground;
  if (const auto& p = shape.prepared)
    input["prepared"] = {{"done", p->done},
                         {"dims_before", {p->before.dims[0], p->before.dims[1], p->before.dims[2]}},
                         {"spacing_before", spacing_json(p->before)}};
  if (const auto& c = shape.chosen) {
    const auto number = [](const Threshold& threshold) {
      return std::visit([](auto t) { return Json(t); }, threshold);
    };
    input["threshold"] = {{"value", number(c->value)}, {"rule", c->rule}, {"reason", c->reason}};
    if (c->seed) input["threshold"]["seed"] = number(*c->seed);
  }
  if (const auto& c = shape.cleaned) {
    if (f.seed_threshold || (shape.chosen && shape.chosen->seed))
      input["hysteresis"] = {{"voxels_dropped", c->weak_dropped}};
    if (f.close > 0) input["closed"] = {{"voxels_added", c->voxels_closed}};
    if (f.connectivity != 6)
      input["joined"] = {{"voxels_added", c->voxels_joined}, {"components_joined", c->components_joined}};
    if (is_cleaned(f))
      input["cleaned"] = {{"voxels_before", c->voxels_before},
                          {"components_removed", c->components_removed},
                          {"voxels_removed", c->voxels_removed},
                          {"cavities_filled", c->cavities_filled},
                          {"voxels_filled", c->voxels_filled}};
  }
  if (!shape.from_mesh) {
    input["euler"] = shape.topology.euler;
    input["components"] = shape.topology.betti[0];
  }
  input["longest_side"] = shape.longest_side;
  return input;
}

void take_recorded(ShapeOptions& options, const Record& result, const std::string& file) {
  options.recorded = pipeline::take_recorded(options.how, result, file);
  for (std::string& name : options.recorded) name.insert(0, "--");
  options.recorded_in = file;
}

}  // namespace quench::program
