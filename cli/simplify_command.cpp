// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "axis_input.h"
#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/io.h"
#include "quench/solid_stages.h"
#include "report.h"
#include "shape_input.h"
#include "stage_options.h"

namespace quench::program {
namespace {

/// What is done to the envelope of an axis, and compared with a boundary.
struct Reshaping {
  AxisInput input;
  std::string output;
};

struct Loaded {
  pipeline::LoadedAxis axis;
  std::optional<pipeline::LoadedShape> shape;
  BoundaryPoints boundary;
  std::string boundary_is;  ///< of "mesh", "grey", "smooth", "voxels", "envelope"
};

Loaded load(const Reshaping& o, Session& session) {
  session.check_output(o.output, o.input.inputs());
  io::check_writable_format(o.output);
  AxisInput input = o.input;
  input.shape.clear();  // read as a shape, not only for its size
  if (!o.input.shape.empty()) {
    check_exists(o.input.shape);
    input.how = {};
  }
  Loaded loaded{load_axis(input, session), {}, {}, {}};
  if (loaded.axis.axis.grid.is_plane())
    throw Error(ErrorCode::usage,
                fmt::format("'{}' is of the plane; only axes of solids can be made simpler or smoother", o.input.file));
  if (!o.input.shape.empty()) {
    loaded.shape = load_shape_of(o.input, loaded.axis, session);
    loaded.axis.scale.longest_side = loaded.shape->longest_side;
    if (loaded.shape->shape.grid().is_plane())
      throw Error(ErrorCode::usage,
                  fmt::format("'{}' is a shape of the plane, '{}' is not", o.input.shape, o.input.file));
  }
  loaded.boundary = pipeline::boundary_of(loaded.axis.axis, loaded.shape ? &*loaded.shape : nullptr,
                                          &loaded.boundary_is, &session.context);
  session.finished("boundary");
  return loaded;
}

std::string boundary_text(const Loaded& loaded, const std::string& shape) {
  return loaded.boundary_is == "envelope" ? "the envelope of the medial axis"
         : loaded.boundary_is == "voxels" ? fmt::format("the boundary vertices of '{}'", shape)
                                          : fmt::format("the surface of '{}'", shape);
}

Json figures(const DistanceFigures& f) { return {{"mean", f.mean}, {"p99", f.p99}, {"largest", f.largest}}; }
Json errors_json(const OneSidedDistances& d) {
  return {{"outside", figures(d.outside)}, {"either_side", figures(d.either)}, {"points", d.places}};
}

Json cells_json(const CellComplex& complex, const Topology& topology) {
  return {{"vertices", complex.vertex_count},
          {"edges", complex.edges.size()},
          {"triangles", complex.face_count()},
          {"euler", topology.euler},
          {"betti", topology.betti}};
}

void say_errors(const OneSidedDistances& d, const std::string& boundary, double side, Session& session) {
  session.say(
      fmt::format("errors: {} lies mean {:.3g}, 99 % {:.3g}, largest {:.3g} thousandths of the longest side "
                  "from that of the result; outside of it {:.3g}, {:.3g}, {:.3g}",
                  boundary, 1000 * d.either.mean / side, 1000 * d.either.p99 / side, 1000 * d.either.largest / side,
                  1000 * d.outside.mean / side, 1000 * d.outside.p99 / side, 1000 * d.outside.largest / side));
}

/// How far the envelope sticks out of the surface of a shape, on a grid.
std::optional<OneSidedDistances> other_way(const MedialAxis& axis, const Loaded& loaded, Session& session) {
  if (!loaded.shape || !loaded.shape->surface) return {};
  const Envelope envelope(axis, EnvelopeKind::full, &session.context);
  constexpr double kVoxels = 128;
  const Grid grid = grid_around(envelope, (envelope.high() - envelope.low()).maxCoeff() / kVoxels);
  auto distances = distances_from_surface(envelope, voxels_of(envelope, grid, &session.context), *loaded.shape->surface,
                                          50000, &session.context);
  session.finished("errors");
  return distances;
}

}  // namespace

Action add_simplify(CLI::App& app) {
  struct Options {
    Reshaping reshaping;
    std::size_t vertices = 200;
    std::optional<pipeline::Length> error;
    int fits = SimplifyOptions{}.fits;
    std::string levels;
  };
  auto o = std::make_shared<Options>();
  add_axis_options(app, o->reshaping.input);
  const auto group = "Simplification";
  CLI::Option* vertices = add_number(app, "--vertices", o->vertices,
                                     "How many vertices are left, or as few as the topology allows", std::size_t{1})
                              ->type_name("N")
                              ->capture_default_str()
                              ->group(group);
  add_parsed(
      app, "--error",
      "Instead: as few vertices as will do, so that no point of the boundary (of --shape, else of the envelope of "
      "AXIS) is farther outside of the result, or deeper in a ball, cone or slab of it; checked point by point",
      [o](const std::string&, const std::string& text) { o->error = pipeline::parse_length(text, "error"); })
      ->type_name("LENGTH")
      ->excludes(vertices)
      ->group(group);
  add_number(app, "--fits", o->fits, "Rounds of fitting the vertices that are left to the boundary", 0, 1000)
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  app.add_option("--levels", o->levels,
                 "Also write a table: the errors of the fitted axis of 1000, 500, 250, ... vertices, each of the same "
                 "topology")
      ->type_name("FILE.csv")
      ->group(group);
  app.add_option("-o,--output", o->reshaping.output,
                 "The simplified axis, of triangles, edges and radii: .ma .vtp .ply .obj .r .csv")
      ->type_name("FILE")
      ->required();
  return [o](Session& session) {
    if (!o->levels.empty()) {
      session.check_output(o->levels, o->reshaping.input.inputs(), "--levels");
      if (extension_of(o->levels) != ".csv" || is_same_place(o->levels, o->reshaping.output))
        throw Error(ErrorCode::usage, fmt::format("--levels '{}' must end in .csv and not be the output", o->levels));
    }
    const Loaded loaded = load(o->reshaping, session);
    const double side = loaded.axis.scale.longest_side;
    SimplifyOptions options{o->vertices, {}, o->fits};
    if (o->error) options.error = loaded.axis.scale.resolve(*o->error, "error");
    const Simplified result = pipeline::simplified(loaded.axis.axis, loaded.boundary, options, &session.context);
    session.finished("simplify");
    const Topology topology = quench::topology(result.axis.complex);
    Json report = {{"input", input_section(o->reshaping.input, loaded.axis)},
                   {"parameters",
                    {{"vertices", o->error ? Json(nullptr) : Json(o->vertices)},
                     {"error", o->error ? Json(pipeline::text_of(*o->error)) : Json(nullptr)},
                     {"fits", o->fits},
                     {"boundary", loaded.boundary_is}}},
                   {"simplified", cells_json(result.axis.complex, topology)}};
    report["simplified"]["fewest_vertices"] = result.sequence.least();
    report["errors"] = {{"longest_side", side}, {"boundary_from_envelope", errors_json(result.errors)}};
    const auto out = other_way(result.axis, loaded, session);
    if (out) report["errors"]["envelope_from_boundary"] = errors_json(*out);

    io::OutputGroup outputs;
    io::write_record(o->reshaping.output, pipeline::reshaped_file(result.axis, loaded.axis.data, "simplified"));
    if (!o->levels.empty()) {
      const std::vector<SimplifiedLevel> table =
          errors_of_levels(result.sequence, loaded.boundary, o->fits, &session.context);
      io::write_atomically(o->levels, [&](std::ostream& file) {
        file << "vertices,edges,triangles,mean,p99,largest,outside_mean,outside_p99,outside_largest\n";
        for (const SimplifiedLevel& l : table)
          file << fmt::format("{},{},{},{},{},{},{},{},{}\n", l.vertices, l.edges, l.triangles, l.errors.either.mean,
                              l.errors.either.p99, l.errors.either.largest, l.errors.outside.mean, l.errors.outside.p99,
                              l.errors.outside.largest);
      });
    }
    session.finished("write");
    write_report(outputs, report, session);
    say_errors(result.errors, boundary_text(loaded, o->reshaping.input.shape), side, session);
    if (out)
      session.say(fmt::format("the result sticks out of it by mean {:.3g}, 99 % {:.3g}, largest {:.3g} thousandths",
                              1000 * out->outside.mean / side, 1000 * out->outside.p99 / side,
                              1000 * out->outside.largest / side));
    if (!o->error && result.axis.points.size() > o->vertices)
      session.say(fmt::format("note: the topology allows no fewer than {} vertices", result.axis.points.size()));
    session.say(fmt::format("{}: {}, components/tunnels/cavities {}/{}/{} as those of the medial axis; {:.1f} s",
                            o->reshaping.output, cells_text(pipeline::counts_of(result.axis.complex)),
                            topology.betti[0], topology.betti[1], topology.betti[2], session.total_seconds()));
    return 0;
  };
}

Action add_smooth(CLI::App& app) {
  struct Options {
    Reshaping reshaping;
    std::optional<pipeline::Length> most;
    int iterations = 10;
  };
  auto o = std::make_shared<Options>();
  add_axis_options(app, o->reshaping.input);
  const auto group = "Smoothing";
  add_parsed(app, "--most",
             "No vertex moves, and no radius changes, by more [default: half a voxel, where AXIS has no voxels 0.2%]",
             [o](const std::string&, const std::string& text) { o->most = pipeline::parse_length(text, "most"); })
      ->type_name("LENGTH")
      ->group(group);
  add_number(app, "--iterations", o->iterations, "Rounds of smoothing", 0, 10000)
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  app.add_option("-o,--output", o->reshaping.output, "The smoothed axis: .vtp .ply .obj .ma .r .csv")
      ->type_name("FILE")
      ->required();
  return [o](Session& session) {
    Loaded loaded = load(o->reshaping, session);
    const pipeline::Scale& scale = loaded.axis.scale;
    constexpr double kWithoutVoxels = 0.002;
    const double most = o->most           ? scale.resolve(*o->most, "most")
                        : scale.voxel > 0 ? scale.voxel / 2
                                          : kWithoutVoxels * scale.longest_side;
    MedialAxis axis;
    axis.complex = loaded.axis.axis.complex;
    axis.points = loaded.axis.axis.points;
    axis.radius = loaded.axis.axis.radius;
    const OneSidedDistances before = errors_of(axis, loaded.boundary, &session.context);
    smooth(axis, most, o->iterations, &session.context);
    const OneSidedDistances after = errors_of(axis, loaded.boundary, &session.context);
    session.finished("smooth");
    double mean = 0, largest = 0;
    for (std::size_t v = 0; v < axis.points.size(); ++v) {
      const double move = (axis.points[v] - loaded.axis.axis.points[v]).norm();
      mean += move / static_cast<double>(axis.points.size());
      largest = std::max(largest, move);
    }
    const Topology topology = quench::topology(axis.complex);
    Json report = {
        {"input", input_section(o->reshaping.input, loaded.axis)},
        {"parameters", {{"most", most}, {"iterations", o->iterations}, {"boundary", loaded.boundary_is}}},
        {"smoothed",
         {{"mean_move", mean}, {"largest_move", largest}, {"euler", topology.euler}, {"betti", topology.betti}}},
        {"errors",
         {{"longest_side", scale.longest_side}, {"before", errors_json(before)}, {"after", errors_json(after)}}}};
    io::OutputGroup outputs;
    io::write_record(o->reshaping.output, pipeline::reshaped_file(axis, loaded.axis.data, "smoothed"));
    session.finished("write");
    write_report(outputs, report, session);
    say_errors(after, boundary_text(loaded, o->reshaping.input.shape), scale.longest_side, session);
    session.say(fmt::format("{}: vertices moved by mean {:.3g}, largest {:.3g}; {:.1f} s", o->reshaping.output, mean,
                            largest, session.total_seconds()));
    return 0;
  };
}

}  // namespace quench::program
