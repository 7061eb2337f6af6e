// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/io.h"
#include "quench/picture.h"
#include "quench/preparation.h"
#include "quench/tree.h"
#include "report.h"
#include "run_command.h"
#include "stage_options.h"
#include "tree_report.h"
#include "units.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;
using pipeline::LoadedShape;
using pipeline::TreeRun;

/// The options of `quench tree`; of those of `quench run` the ones that lead to curves.
struct TreeProgram : RunProgram {
  std::string shape_file;  ///< of a result that is read
  pipeline::TreeKind kind = pipeline::TreeKind::root;
  RepairRule repair = RepairRule::all;
  std::vector<Vec3> roots;
  std::optional<std::uint64_t> plants;
  std::optional<Vec3> down;
  std::optional<AxisRule> axes;
  std::optional<SomaRule> soma;
  std::optional<pipeline::Length> reach, sholl_step;
  bool toporoot = false;
  bool blur_given = false, connectivity_given = false;  ///< also where they are as by default
};

struct TreeFiles {
  TreeFiles(const fs::path& folder, bool with_page, bool with_picture)
      : swc(folder / "tree.swc"),
        rsml(folder / "tree.rsml"),
        mtg(folder / "tree.mtg"),
        graphml(folder / "tree.graphml"),
        centerlines(folder / "centerlines.vtp"),
        axes(folder / "axes.csv"),
        branches(folder / "branches.csv"),
        traits(folder / "traits.csv"),
        sholl(folder / "sholl.csv"),
        depths(folder / "depths.csv"),
        edits(folder / "edits.csv"),
        edited(folder / "edited.nrrd"),
        report(folder / "report.json"),
        view(with_page ? folder / "view.html" : fs::path()),
        picture(with_picture ? folder / "picture.png" : fs::path()) {}
  std::vector<fs::path> all() const {
    return {swc,   rsml,   mtg,   graphml, centerlines, axes, branches, traits,
            sholl, depths, edits, edited,  report,      view, picture};
  }
  /// Those of this folder that a run with other options or inputs writes, too.
  std::vector<fs::path> of_some_runs() const {
    const fs::path folder = report.parent_path();
    return {edits, edited, folder / "view.html", folder / "picture.png"};
  }
  bool has_page() const { return !view.empty() || !picture.empty(); }
  fs::path swc, rsml, mtg, graphml, centerlines, axes, branches, traits, sholl, depths, edits, edited, report, view,
      picture;
};

// -------------------------------------------------------------------------------------------------------------- input

/// A medial axis or a skeleton: a file that may be one and has a radius per vertex.
std::optional<Record> result_in(const std::string& file, Session& session) {
  constexpr std::array kExtensions{".vtp", ".ply", ".obj", ".ma"};
  if (std::ranges::find(kExtensions, extension_of(file)) == kExtensions.end()) return {};
  Record data = pipeline::read_surface(file, &session.context);
  if (!find_array(data.point_data, "radius")) return {};
  return data;
}

[[noreturn]] void refuse_plane(const std::string& file, const std::string& folder) {
  throw Error(
      ErrorCode::usage,
      fmt::format("'{0}' is of the plane, and trees are made in space; 'quench run {0} -o {1}' finds its curves, "
                  "and 'quench tree {1}/skeleton.swc' measures them as a tree",
                  file, folder));
}

/// A folder is one of slices; that of results is not, and its files are.
void refuse_results_folder(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) return;
  for (const char* name : {"tree.swc", "core.vtp"})
    if (fs::exists(folder / name, ignored))
      throw Error(ErrorCode::usage,
                  fmt::format("'{}' is a folder of results; give '{}'", folder.string(), (folder / name).string()));
}

void check_tree_options(const TreeProgram& o, const TreeFiles& files, const Session& session) {
  check_exists(o.shape.file);
  if (!o.shape_file.empty()) check_exists(o.shape_file);
  if (o.plants && !o.roots.empty())
    throw Error(ErrorCode::usage,
                "--plants and --root cannot be combined: there are as many plants as there are root nodes");
  if (io::kind_of(o.shape.file) == io::Kind::polygons) refuse_plane(o.shape.file, o.folder);
  refuse_results_folder(o.shape.file);
  check_folder(o.folder);
  std::vector<fs::path> inputs{o.shape.file};
  if (!o.shape_file.empty()) inputs.emplace_back(o.shape_file);
  std::error_code error;
  if (fs::exists(o.folder, error))
    for (const fs::path& file : files.all())
      if (!file.empty()) session.check_output(file, inputs);
  session.check_report(inputs);
}

/// Which of the options that are given have no effect, by their groups.
void say_without_effect(const CLI::App& app, const std::vector<std::string>& groups, const std::string& why,
                        Session& session) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    if (option->count() > 0 && std::ranges::find(groups, option->get_group()) != groups.end())
      names.push_back(option->get_name());
  if (!names.empty())
    session.say(fmt::format("note: {} {} ignored: {}", fmt::join(names, ", "), names.size() == 1 ? "is" : "are", why));
}

/// Where the program chooses the threshold of grey values and nothing is said of preparing them: noise so strong that
/// it leaves no room for the two thresholds of `thin` makes loops and specks, and a light blur takes most of them away.
/// It would take thin roots and narrow gaps away, too, where it is not needed.
void blur_noise(const Volume& volume, ShapeOptions& how, Session& session) {
  constexpr double kLight = 0.8;
  if (how.how.preparation.any()) return;
  const std::vector<ProposedThreshold> proposals = proposed_thresholds(volume, &session.context);
  if (proposals.empty()) return;
  if (std::ranges::find(proposals, "thin", &ProposedThreshold::rule) != proposals.end()) return;
  how.how.preparation.blur = kLight;
  session.say(
      fmt::format("note: the grey values are noisy: they are blurred by {} voxels before a threshold is chosen; "
                  "--blur and --threshold take others, quench info shows the values",
                  kLight));
}

/// Where nobody has said what the shape is, the threshold is chosen: of grey values, not of labels.
void choose_by_values(ShapeOptions& how, const TreeProgram& o, Session& session) {
  const ForegroundOptions& foreground = how.how.foreground;
  const bool asked = how.how.recommended;
  if (foreground.threshold || foreground.label || how.how.otsu) return;
  const io::VolumeReadOptions reading = pipeline::read_options(how.how);
  if (const auto slices = io::open_slices(how.file, reading, &session.context);
      slices && !slices->grid.is_plane() && !pipeline::samples_fit(*slices, &session.context))
    return;  // a mask, or the sentence on its values
  const Volume volume = io::read_volume(how.file, reading, &session.context);
  if (volume.grid.is_plane()) refuse_plane(how.file, o.folder);
  if (const auto labels = labels_in(volume); !asked && !labels.empty())
    throw Error(ErrorCode::usage,
                fmt::format("'{}' holds the labels {}: give the one of the tree as --label K; --threshold 1 takes all "
                            "of them, --threshold auto takes them for grey values",
                            how.file, labels_text(labels)));
  if (!asked) how.how.recommended = how.how.thin = true;
  if (!o.blur_given) blur_noise(volume, how, session);
}

/// What fills space is no tree, and neither is noise.
void note_if_no_tree(const LoadedShape& shape, Session& session) {
  constexpr double kMuch = 0.5, kMuchOfAll = 0.25;  // of the box
  const VoxelShape::Box box = shape.shape.foreground_box();
  double voxels = 1;
  bool all_sides = !shape.from_mesh;
  for (std::size_t a = 0; a < 3; ++a) {
    voxels *= static_cast<double>(box.end[a] - box.begin[a]);
    all_sides = all_sides && box.begin[a] == 0 && box.end[a] == shape.shape.grid().dims[a];
  }
  const double share = voxels > 0 ? static_cast<double>(shape.shape.voxel_count()) / voxels : 0;
  if (share > (all_sides ? kMuchOfAll : kMuch))
    session.say(
        fmt::format("note: this does not look like a tree: the shape fills {:.0f} % of its box{}; is it what "
                    "was meant? --threshold, --label and --invert choose others",
                    100 * share, all_sides ? " and touches all six sides of the image" : ""));
}

LoadedShape load_tree_shape(ShapeOptions how, const TreeProgram& o, bool with_mesh, Session& session) {
  ForegroundOptions& foreground = how.how.foreground;
  const bool volume = io::kind_of(how.file) == io::Kind::volume;
  how.how.keep_mesh = with_mesh;
  if (volume) {
    choose_by_values(how, o, session);
    how.how.keep_values = !foreground.label && (o.repair == RepairRule::gaps || o.repair == RepairRule::all);
    if (!o.connectivity_given) foreground.connectivity = 26;
    foreground.fill_cavities = true;  // a tree has none
  }
  LoadedShape shape = load_shape(how, session);
  if (shape.shape.grid().is_plane()) refuse_plane(how.file, o.folder);
  if (shape.topology.betti[2] > 0) {
    session.say("note: cavities are filled, as a tree has none");
    foreground.fill_cavities = true;
    shape = load_shape(how, session);
  }
  note_if_no_tree(shape, session);
  return shape;
}

/// The curves of a shape, and what is said of it.
pipeline::TreeCurves tree_curves_of(const TreeProgram& o, LoadedShape& shape, Json& report, Session& session) {
  pipeline::RunOptions options = o.run;
  options.graph = pipeline::graph_for_trees(o.graph.graph, shape.scale());
  std::size_t vertices = 0;
  options.on_core = [&](const pipeline::CoreResult& core) {
    vertices = core.axis.points.size();
    say_core(shape, core, session);
  };
  options.on_burned = [&](const pipeline::BurnFigures& burned) { say_burned(burned, vertices, session); };
  pipeline::RunResult result = pipeline::run(shape, options, &session.context);
  report["input"] = input_section(o.shape, shape);
  add_core_sections(report, shape, result.core);
  add_axis_sections(report, result.axis);
  pipeline::TreeCurves curves{std::move(result.axis.graph), shape.scale(), Vec3::Zero(), shape.coordinates};
  if (!shape.surface) curves.voxel = shape.shape.grid().spacing;
  return curves;
}

// ------------------------------------------------------------------------------------------------------------- options

pipeline::TreeOptions tree_options(const TreeProgram& o, const pipeline::Scale& scale) {
  pipeline::TreeOptions options = pipeline::defaults_of(o.kind);
  options.repair.rule = o.repair;
  options.repair.roots = o.roots;
  if (o.plants) options.repair.plants = static_cast<std::uint32_t>(*o.plants);
  if (o.reach) options.repair.reach = scale.resolve(*o.reach, "reach");
  if (o.axes) options.hierarchy.rule = *o.axes;
  if (o.down) {
    options.hierarchy.down = *o.down;
    options.find_down = false;
  }
  if (o.soma) options.hierarchy.soma = *o.soma;
  options.hierarchy.roots = o.roots;
  if (o.sholl_step) options.traits.sholl_step = scale.resolve(*o.sholl_step, "sholl_step");
  return options;
}

void add_parameters(Json& report, const TreeProgram& o, const pipeline::TreeOptions& options) {
  Json& parameters = report["parameters"];
  if (parameters.is_null()) parameters = Json::object();
  parameters["kind"] = pipeline::name_of(o.kind);
  parameters["theta1"] = pipeline::text_of(o.run.skeleton.theta1);
  parameters["tips"] = o.run.skeleton.full_tips ? "full" : "pruned";
  parameters["smooth"] = o.graph.graph.smooth;
  parameters["resample"] = pipeline::text_of(o.graph.graph.resample);
  parameters["repair"] = name_of(options.repair.rule);
  parameters["reach"] = pipeline::text_of(o.reach);
  parameters["plants"] = o.roots.empty() ? options.repair.plants : o.roots.size();
  Json& roots = parameters["roots"] = Json::array();
  for (const Vec3& p : o.roots) roots.push_back({p[0], p[1], p[2]});
  parameters["axes"] = name_of(options.hierarchy.rule);
  parameters["soma"] = name_of(options.hierarchy.soma);
  parameters["down"] = o.down ? Json({(*o.down)[0], (*o.down)[1], (*o.down)[2]}) : Json("auto");
}

// -------------------------------------------------------------------------------------------------------------- write

void write_tree_files(const TreeProgram& o, const TreeFiles& files, const TreeRun& run, bool repaired,
                      Session& session) {
  const Tree& tree = run.tree;
  const Traits& traits = run.traits;
  io::write_swc(files.swc, tree, io::swc_type_of(o.graph.swc_type, "--swc-type"));
  io::write_rsml(files.rsml, tree, &traits.axes);
  io::write_mtg(files.mtg, tree);
  io::write_graphml(files.graphml, tree);
  io::write_centerlines(files.centerlines, tree);
  io::write_table(files.axes, o.toporoot ? toporoot_table(tree, traits) : traits.axes);
  io::write_table(files.branches, traits.branches);
  io::write_table(files.traits, traits.sample);
  io::write_table(files.sholl, traits.sholl);
  io::write_table(files.depths, traits.depths);
  if (repaired) io::write_table(files.edits, pipeline::table_of(run.edits, tree.coordinates));
  if (run.edited) io::write_volume(files.edited, *run.edited, tree.coordinates, &session.context);
}

void build_tree_page(const TreeProgram& o, const TreeFiles& files, const TreeRun& run, LoadedShape* shape,
                     pipeline::PageBuilder& builder, const Session& session) {
  Page& page = builder.page;
  page.command = session.options.command;
  page.limit_name = "--max-triangles";
  page.title = pipeline::title_of(o.shape.file);
  page.files = {{"tree", files.rsml.string()}};
  std::vector<Vec3> points;
  for (const Tree::Branch& branch : run.tree.branches)
    points.insert(points.end(), branch.points.begin(), branch.points.end());
  Vec3 low = points.front(), high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  builder.set_origin(low, high);
  if (shape) {
    page.files.emplace_back("shape", o.shape_file.empty() ? o.shape.file : o.shape_file);
    builder.add_shape(*shape);
  }
  builder.add_tree(run.tree, run.traits, run.edits, o.kind == pipeline::TreeKind::root);
}

void say_tree_results(const TreeFiles& files, const TreeRun& run, Session& session) {
  session.say(fmt::format("{}: {}; {:.1f} s; report in {}", files.rsml.string(), tree_text(run),
                          session.total_seconds(), files.report.string()));
  session.say(fmt::format("also {}, {}, {} and {}", files.swc.string(), files.mtg.string(), files.graphml.string(),
                          files.centerlines.string()));
  session.say(fmt::format("{}, {} and {}: a row per axis, per branch, and of the whole; {} and {}: profiles",
                          files.axes.string(), files.branches.string(), files.traits.string(), files.sholl.string(),
                          files.depths.string()));
  if (run.edited)
    session.say(fmt::format(
        "{}: the shape after repair: {}, without tunnels and cavities", files.edited.string(),
        run.tree.plants.size() == 1 ? "one component" : fmt::format("{} components", run.tree.plants.size())));
  if (!files.picture.empty()) session.say(fmt::format("{}: a picture of the tree", files.picture.string()));
  if (!files.view.empty())
    session.say(fmt::format("{}: the interactive page; open it in a browser", files.view.string()));
}

// ---------------------------------------------------------------------------------------------------------------- run

/// A tree, and the shape it is of, where there is one.
struct Made {
  TreeRun run;
  std::optional<LoadedShape> shape;
  bool repaired = true;
};

Made made_of_tree(const TreeProgram& o, const CLI::App& app, Json& report, Session& session) {
  say_without_effect(app, {"Shape", "Medial axis", "Burning", "Skeleton", "Repair"},
                     fmt::format("'{}' is a tree already, which is measured as it is", o.shape.file), session);
  bool axes_known = false;
  Tree tree = io::read_tree(o.shape.file, &axes_known, &session.context);
  take_units(tree.coordinates, o.shape.file, session);
  session.finished("read");
  std::vector<Vec3> points;
  for (const Tree::Branch& branch : tree.branches)
    points.insert(points.end(), branch.points.begin(), branch.points.end());
  const pipeline::TreeOptions options = tree_options(o, {.longest_side = longest_side_of(points)});
  report["input"] = {{"file", o.shape.file}, {"kind", "tree"}, {"axes_known", axes_known}};
  add_parameters(report, o, options);
  const bool new_axes = !axes_known || o.axes || o.soma || !o.roots.empty();
  return {pipeline::run_tree(std::move(tree), new_axes, options), {}, false};
}

Made made_of_result(const TreeProgram& o, Record&& result, const CLI::App& app, Json& report, Session& session) {
  Made made;
  const bool skeleton = pipeline::field_text(result, "stage") == "skeleton";
  std::vector<std::string> groups{"Medial axis"};
  if (o.shape_file.empty()) groups.emplace_back("Shape");
  if (skeleton) groups.insert(groups.end(), {"Burning", "Skeleton"});
  say_without_effect(app, groups,
                     fmt::format("'{}' is a {} already", o.shape.file, skeleton ? "skeleton" : "medial axis"), session);
  report["input"] = {{"file", o.shape.file}, {"kind", skeleton ? "skeleton" : "medial axis"}};
  if (!o.shape_file.empty()) {
    ShapeOptions how = o.shape;
    how.file = o.shape_file;
    take_recorded(how, result, o.shape.file);
    how.how.surface = SurfaceKind::voxels;  // the axis is fitted already
    how.how.core_follows = false;
    report["input"]["shape"] = o.shape_file;
    made.shape = load_tree_shape(how, o, !o.no_view || !o.no_picture, session);
  }
  take_units(result, o.shape.file, session);
  pipeline::RunOptions run = o.run;
  run.graph = o.graph.graph;
  const pipeline::TreeCurves curves = pipeline::curves_in(std::move(result), o.shape.file, std::move(run),
                                                          made.shape ? &*made.shape : nullptr, &session.context);
  const pipeline::TreeOptions options = tree_options(o, curves.scale);
  add_parameters(report, o, options);
  made.run = pipeline::run_tree(curves, options, made.shape ? &*made.shape : nullptr, &session.context);
  return made;
}

Made made_of_shape(const TreeProgram& o, bool with_mesh, Json& report, Session& session) {
  Made made;
  if (!o.shape_file.empty())
    throw Error(ErrorCode::usage,
                fmt::format("--shape is the shape of a result that is read, and '{}' is a shape itself", o.shape.file));
  made.shape = load_tree_shape(o.shape, o, with_mesh, session);
  const pipeline::TreeCurves curves = tree_curves_of(o, *made.shape, report, session);
  const pipeline::TreeOptions options = tree_options(o, curves.scale);
  add_parameters(report, o, options);
  made.run = pipeline::run_tree(curves, options, &*made.shape, &session.context);
  return made;
}

/// Removes what an earlier run left and this one has not written, which would not belong to the rest.
void remove_stale(const TreeFiles& files, const Made& made) {
  std::error_code ignored;
  for (const fs::path& file : files.of_some_runs()) {
    const bool written = file == files.edits    ? made.repaired
                         : file == files.edited ? made.run.edited.has_value()
                                                : file == files.view || file == files.picture;
    if (!written) fs::remove(file, ignored);
  }
}

int make_tree(TreeProgram o, const CLI::App& app, Session& session) {
  const TreeFiles files(o.folder, !o.no_view && pipeline::has_page_program(), !o.no_picture);
  check_tree_options(o, files, session);
  o.run.skeleton = pipeline::skeleton_for_trees(o.run.skeleton);
  o.blur_given = app.get_option("--blur")->count() > 0;
  o.connectivity_given = app.get_option("--connectivity")->count() > 0;
  Json report;
  std::optional<Record> result;
  const bool is_tree = io::is_tree_file(o.shape.file);
  if (!is_tree) result = result_in(o.shape.file, session);
  Made made = is_tree  ? made_of_tree(o, app, report, session)
              : result ? made_of_result(o, std::move(*result), app, report, session)
                       : made_of_shape(o, files.has_page(), report, session);
  const TreeRun& run = made.run;
  session.finished("tree");
  if (o.soma == SomaRule::thickest &&
      std::ranges::any_of(run.tree.plants, [](const Tree::Plant& plant) { return !plant.soma; }))
    session.say("note: a thickest ball that holds a whole tree is no soma");
  if (made.repaired) say_repair(run, files.edits.string(), session);
  if (made.repaired && o.plants && run.tree.plants.size() < *o.plants)
    session.say(fmt::format("only {} found: where else the curves could be cut, a part would be too short for a plant",
                            base::counted(run.tree.plants.size(), "plant")));
  if (o.kind == pipeline::TreeKind::root && !o.down)
    session.say(fmt::format("down is {} (auto); --down says where else", direction_text(run.tree.down)));

  pipeline::PageBuilder builder(o.max_triangles);
  if (files.has_page()) build_tree_page(o, files, run, made.shape ? &*made.shape : nullptr, builder, session);
  session.finished("page");
  create_folder(o.folder);
  std::error_code ignored;
  const bool replaces_results = session.options.overwrite && fs::exists(files.report, ignored);
  io::OutputGroup outputs;
  write_tree_files(o, files, run, made.repaired, session);
  session.finished("write");
  if (made.repaired) report["repair"] = repair_section(run, files.edits.string());
  report["tree"] = tree_section(run);
  report["traits"] = traits_section(run.traits.sample);
  if (!files.view.empty()) write_page(builder, files.view, report, outputs);
  session.finished("page");
  if (!files.picture.empty()) write_picture(builder.page, {}, files.picture, report, session);
  write_report(files.report.string(), report, session);
  write_report(outputs, report, session);
  if (replaces_results) remove_stale(files, made);
  say_tree_results(files, run, session);
  return 0;
}

// -------------------------------------------------------------------------------------------------------- command line

/// "-z", "+y", "x", or three numbers.
Vec3 direction_of(const std::string& option, const std::string& text) {
  const bool sign = text.starts_with('-') || text.starts_with('+');
  const std::string letter = sign ? text.substr(1) : text;
  if (letter.size() == 1 && letter[0] >= 'x' && letter[0] <= 'z')
    return (text[0] == '-' ? -1 : 1) * Vec3::Unit(letter[0] - 'x');
  const std::vector<double> numbers = numbers_in(text, ',');
  const Vec3 direction = numbers.size() == 3 ? Vec3(numbers[0], numbers[1], numbers[2]) : Vec3(Vec3::Zero());
  if (!(direction.norm() > 0) || !std::isfinite(direction.norm()))
    throw Error(ErrorCode::usage, fmt::format("{} '{}' is not a direction; give -x, +x, -y, +y, -z, +z, or three "
                                              "numbers x,y,z that are not all 0",
                                              option, text));
  return direction.normalized();
}

/// An option that is one of the names of an enum.
template <class Value, class Parse>
CLI::Option* add_choice(CLI::App& app, const std::string& name, Value& value, const std::vector<std::string>& names,
                        const Parse& parse, const std::string& type, const std::string& help) {
  return add_parsed(app, name, help,
                    [&value, parse](const std::string&, const std::string& text) { value = *parse(text); })
      ->type_name(type)
      ->check(one_of(names));
}

void add_tree_options(CLI::App& app, TreeProgram& o) {
  const auto group = "Tree";
  add_choice(app, "--kind", o.kind, {"root", "neuron", "vessel", "airway"}, pipeline::tree_kind_of, "KIND",
             "What it is the tree of, for defaults: 'root' has a stem and grows down, a 'neuron' has a soma, the root "
             "node of a 'vessel' or an 'airway' is its thickest end")
      ->default_str("root")
      ->group(group);
  app.add_option("--root", CLI::callback_t([&o](const CLI::results_t& given) {
                   for (const std::string& text : given) o.roots.push_back(point_of("--root", text));
                   return true;
                 }),
                 "The root node is the one nearest to this point; several: one per plant [default: the thickest]")
      ->type_name("X,Y,Z")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->group(group);
  add_parsed(
      app, "--down",
      "Where gravity points: -z, +z, -y ... or x,y,z; 'auto': of roots -z or +z, so that most of the volume lies at "
      "the top, else -z",
      [&o](const std::string& option, const std::string& text) {
        o.down = text == "auto" ? std::optional<Vec3>() : direction_of(option, text);
      })
      ->type_name("DIRECTION")
      ->default_str("auto")
      ->group(group);
  add_choice(
      app, "--axes", o.axes, {"depth", "length", "radius", "strahler", "continuation"}, axis_rule_of, "RULE",
      "Which child continues its parent at a fork: so that levels are as small as can be ('depth'), the one of the "
      "largest 'length' to a tip, 'radius' or 'strahler' number [default: of roots continuation, of neurons length, of "
      "vessels and airways radius; "
      "of a file the axes it has]")
      ->group(group);
  add_choice(app, "--soma", o.soma, {"auto", "none", "thickest"}, soma_rule_of, "RULE",
             "Whether the root node is a soma: 'auto' where its ball is clearly thicker than the rest, 'thickest' "
             "always [default: none; of neurons auto]")
      ->group(group);
  add_swc_type(app, o.graph.swc_type)->group(group);
  add_parsed(app, "--columns", "Columns of axes.csv: those of 'quench' or those of 'toporoot', in its order",
             [&o](const std::string&, const std::string& text) { o.toporoot = text == "toporoot"; })
      ->type_name("SET")
      ->check(one_of({"quench", "toporoot"}))
      ->default_str("quench")
      ->group(group);
  add_length(app, "--sholl-step", o.sholl_step,
             "Distance of the spheres of the Sholl profile; 'auto': a fiftieth of the largest distance")
      ->group(group);
}

void add_repair_options(CLI::App& app, TreeProgram& o) {
  const auto group = "Repair";
  add_choice(app, "--repair", o.repair, {"off", "loops", "gaps", "all"}, repair_rule_of, "RULE",
             "Cut 'loops', bridge 'gaps', 'all' or 'off'; what is left must have no loops")
      ->default_str("all")
      ->group(group);
  add_parsed(app, "--plants",
             "So many trees, those that are worth most; 0: every part stays a tree of its own [default: 1]",
             [&o](const std::string& option, const std::string& text) {
               o.plants = number_of<std::uint64_t>(option, text, 0, 1'000'000);
             })
      ->type_name("N")
      ->group(group);
  add_length(app, "--reach", o.reach, "The longest gap that is bridged; 'auto': some radii of what ends there")
      ->group(group);
}

}  // namespace

Action add_tree(CLI::App& app) {
  auto o = std::make_shared<TreeProgram>();
  add_shape_options(app, o->shape);
  app.get_option("SHAPE")->description(
      "A volume (.nrrd .nii.gz .mha .tif, a folder of slices ...), a mesh (.ply .obj .off .stl ...), a result "
      "(core.vtp or skeleton.vtp of 'quench run'), or a tree that is measured as it is (.swc .rsml)");
  app.get_option("--connectivity")->default_str("26");
  app.add_option("--shape", o->shape_file, "Of a result: the volume or mesh it is of, for edited.nrrd and the page")
      ->type_name("FILE")
      ->group("Shape");
  add_tree_options(app, *o);
  add_repair_options(app, *o);
  add_core_options(app, o->run.axis);
  add_burn_options(app, o->run.burning, true);
  add_curve_options(app, o->run.skeleton, o->graph,
                    "Drop branches that stick out of what they leave by less than this many of its radii (1r), or by "
                    "a length (0.02 or 2% of the longest side, 8vox, 3.5abs); 'auto': 1r, and what is thinner than 4.5 "
                    "times the automatic detail, 3.9 voxels");
  add_page_options(app, o->max_triangles);
  app.add_flag("--no-view", o->no_view, "Do not write view.html, the interactive page")->group("Page");
  app.add_flag("--no-picture", o->no_picture, "Do not write picture.png, a picture of the tree")->group("Page");
  app.add_option("-o,--output", o->folder,
                 "Folder for tree.swc, tree.rsml, tree.mtg, tree.graphml, centerlines.vtp, axes.csv, branches.csv, "
                 "traits.csv, sholl.csv, depths.csv, edits.csv, edited.nrrd, report.json, picture.png and view.html; "
                 "created if absent")
      ->type_name("DIR")
      ->required();
  return [o, &app](Session& session) { return make_tree(*o, app, session); };
}

}  // namespace quench::program
