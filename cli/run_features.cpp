// SPDX-License-Identifier: Apache-2.0
// FeatureFiles of many polygons: each has its own result; lines and tables hold those of all.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <ostream>

#include "base/text.h"
#include "plane_files.h"
#include "quench/io.h"
#include "quench/picture.h"
#include "quench/polygons.h"
#include "report.h"
#include "run_command.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;

// A picture holds so many features and points of lines and outlines; what comes later is in the files.
constexpr std::size_t kMostDrawn = 2'000'000;
// Sentences that a report lists.
constexpr std::size_t kMostListed = 1000;

struct FeatureFiles {
  FeatureFiles(const fs::path& folder, bool with_page, bool with_picture)
      : geojson(folder / "skeleton.geojson"),
        svg(folder / "skeleton.svg"),
        branches(folder / "branches.csv"),
        features(folder / "features.csv"),
        report(folder / "report.json"),
        view(with_page ? folder / "view.html" : fs::path()),
        picture(with_picture ? folder / "picture.png" : fs::path()) {}
  fs::path geojson, svg, branches, features, report, view, picture;
};

// A text in a field of a CSV file (RFC 4180).
std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + '"';
}

// The folder of the results, which goes again where nothing was written into it.
class NewFolder {
 public:
  explicit NewFolder(const std::string& folder) : folder_(folder) {
    std::error_code error;
    is_new_ = !fs::exists(folder, error);
    create_folder(folder);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  ~NewFolder() {
    std::error_code not_empty;
    if (is_new_) fs::remove(folder_, not_empty);
  }

 private:
  fs::path folder_;
  bool is_new_;
};

// The id of a feature, JSON text, as it is read.
std::string id_text(const std::string& id) {
  const Json json = Json::parse(id, nullptr, false);
  return json.is_string() ? json.get<std::string>() : id;
}

// What is summed up over all features.
struct Totals {
  std::uint64_t features = 0, failed = 0, branches = 0;
  double length = 0;
};

class Tables {
 public:
  Tables(std::ostream& features, std::ostream& branches) : features_(features), branches_(branches) {
    branches_ << "feature,branch,from,to,from_x,from_y,to_x,to_y,from_kind,to_kind,length,mean_radius,min_radius,"
                 "max_radius,thickness,tortuosity\n";
  }

  void add(const pipeline::FeatureRun& run, Totals& totals) {
    const Json properties = Json::parse(run.properties, nullptr, false);
    if (totals.features++ == 0) begin(properties);
    std::string carried;
    for (const std::string& name : properties_) {
      const auto value = properties.is_object() ? properties.find(name) : properties.end();
      const bool there = properties.is_object() && value != properties.end() && !value->is_null();
      carried += ',';
      if (there) carried += quoted(value->is_string() ? value->get<std::string>() : json_text(*value));
    }
    if (!run.result) {
      ++totals.failed;
      features_ << fmt::format("{},{},,,,,,,,,,,,{}{}\n", run.number, quoted(id_text(run.id)), quoted(run.failure),
                               carried);
      return;
    }
    const CurveGraph& graph = run.result->axis.graph;
    const VoxelShape& shape = run.shape->shape;
    double length = 0, weighted = 0, largest = 0;
    std::size_t ends = 0;
    for (const auto& b : graph.branches) {
      length += b.length;
      weighted += b.length * b.mean_radius;
      largest = std::max(largest, b.max_radius);
    }
    for (const auto& n : graph.nodes) {
      ends += n.kind == CurveGraph::NodeKind::end;
      if (graph.branches.empty()) largest = std::max(largest, n.radius);
    }
    features_ << fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", run.number, quoted(id_text(run.id)),
                             shape.grid().spacing[0], shape.voxel_count(), run.shape->topology.betti[0],
                             run.shape->topology.betti[1], graph.branches.size(), ends, length,
                             length > 0 ? weighted / length : largest, largest, run.result->core.coverage,
                             *run.result->axis.skeleton.reconstructed, carried);
    for (std::size_t i = 0; i < graph.branches.size(); ++i) {
      const auto& b = graph.branches[i];
      const auto &from = graph.nodes[b.from], &to = graph.nodes[b.to];
      branches_ << fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", run.number, i, b.from, b.to,
                               from.point[0], from.point[1], to.point[0], to.point[1], name_of(from.kind),
                               name_of(to.kind), b.length, b.mean_radius, b.min_radius, b.max_radius, b.thickness,
                               b.tortuosity);
    }
    totals.branches += graph.branches.size();
    totals.length += length;
  }

 private:
  // The properties of the first feature are columns of all.
  void begin(const Json& properties) {
    features_ << "feature,id,pixel,pixels,components,holes,branches,ends,length,mean_radius,max_radius,coverage,"
                 "reconstructed,failure";
    if (properties.is_object())
      for (const auto& [name, value] : properties.items()) {
        properties_.push_back(name);
        features_ << ',' << quoted(name);
      }
    features_ << '\n';
  }

  std::ostream &features_, &branches_;
  std::vector<std::string> properties_;
};

// What is drawn of all features together.
class Drawing {
 public:
  explicit Drawing(const RunProgram& o) : builder_(o.max_triangles), left_(o.max_triangles) {
    builder_.page.limit_name = "--max-triangles";
  }

  // False where the page is full.
  bool add(const pipeline::FeatureRun& run) {
    Page& page = builder_.page;
    const VoxelShape& shape = run.shape->shape;
    if (!page.plane) {
      const Grid& grid = shape.grid();
      const Vec3 dims(static_cast<double>(grid.dims[0]), static_cast<double>(grid.dims[1]), 0);
      builder_.set_origin(grid.world(Vec3::Zero()), grid.world(dims));
      page.plane = true;
      page.y_down = run.shape->coordinates.y_down;
      page.theta1_radii = run.result->axis.skeleton.skeleton.theta1_radii;
    }
    if (left_ == 0) return false;
    const std::size_t used = add_surface(page, shape, std::max<std::size_t>(left_ / 8, 1000));
    left_ -= std::min(used, left_);
    append(graph_, run.result->axis.graph, skeleton_.complex.vertex_count);
    append(skeleton_, run.result->axis.skeleton.skeleton);
    return true;
  }
  pipeline::PageBuilder& finished() {
    builder_.page.side = (builder_.page.high - builder_.page.low).maxCoeff();
    builder_.add_skeleton(skeleton_, graph_);
    return builder_;
  }

 private:
  pipeline::PageBuilder builder_;
  std::size_t left_;
  Skeleton skeleton_;
  CurveGraph graph_;
};

std::size_t points_of(const io::PlaneLines& lines) {
  std::size_t points = lines.graph.nodes.size();
  for (const auto& branch : lines.graph.branches) points += branch.points.size();
  for (const auto& ring : lines.outline.rings) points += ring.size();
  return points;
}

}  // namespace

int run_features(const RunProgram& o, Session& session) {
  const FeatureFiles files(o.folder, !o.no_view && pipeline::has_page_program(), !o.no_picture);
  check_folder(o.folder);
  std::error_code error;
  if (fs::exists(o.folder, error))
    for (const fs::path& file :
         {files.geojson, files.svg, files.branches, files.features, files.report, files.view, files.picture})
      if (!file.empty()) session.check_output(file, {o.shape.file});
  session.check_report({o.shape.file});
  check_shape_options(o.shape);
  say_ignored(o.shape, io::Kind::polygons, session);
  say_not_of_plane(o.run.skeleton, o.run.burning, session);
  if (o.graph.root || o.graph.swc_type != GraphFileOptions().swc_type)
    session.say(
        "note: --root and --swc-type are for SWC, which is not written of many polygons; --feature K takes one");
  const NewFolder folder(o.folder);

  pipeline::RunOptions options = o.run;
  options.graph = o.graph.graph;
  Totals totals;
  Json failures = Json::array(), notes = Json::array();
  io::OutputGroup outputs;
  bool y_down = false;
  std::size_t drawn = 0, left_out = 0, not_drawn = 0, noted = 0;
  const bool draws = !files.view.empty() || !files.picture.empty();
  Drawing drawing(o);
  std::optional<io::LineWriter> geojson, svg;
  const auto open = [&] {  // when the first feature says which way y goes
    geojson.emplace(files.geojson, io::LineOptions{.y_down = y_down});
    svg.emplace(files.svg, io::LineOptions{.y_down = y_down});
  };
  io::write_atomically(files.features, [&](std::ostream& features) {
    io::write_atomically(files.branches, [&](std::ostream& branches) {
      Tables tables(features, branches);
      const auto take = [&](pipeline::FeatureRun&& run) {
        tables.add(run, totals);
        if (!run.result) {
          if (failures.size() < kMostListed) failures.push_back({{"feature", run.number}, {"sentence", run.failure}});
          return;
        }
        for (const std::string& sentence : run.notes)
          if (noted++ < kMostListed) notes.push_back({{"feature", run.number}, {"sentence", sentence}});
        if (!geojson) {
          y_down = run.shape->coordinates.y_down;
          open();
        }
        io::PlaneLines lines = plane_lines(*run.shape, *run.result);
        geojson->append(lines);
        const std::size_t points = points_of(lines);
        if (drawn + points <= kMostDrawn) {
          drawn += points;
          svg->append(lines);
          if (draws && !drawing.add(run)) ++not_drawn;
        } else {
          ++left_out;
        }
      };
      pipeline::run_features(o.shape.file, o.shape.how, options, take, &session.context);
    });
  });
  if (totals.failed == totals.features)
    throw Error(ErrorCode::input, totals.features == 0
                                      ? fmt::format("'{}' holds no polygons", o.shape.file)
                                      : fmt::format("none of the {} of '{}' can be used; the first: {}",
                                                    base::counted(totals.features, "feature"), o.shape.file,
                                                    failures[0]["sentence"].get<std::string>()));
  geojson->finish();
  svg->finish();
  session.finished("features");

  Json report = {{"input", {{"file", o.shape.file}, {"kind", "polygons"}, {"y_axis", y_down ? "down" : "up"}}},
                 {"features", totals.features},
                 {"failed", totals.failed},
                 {"branches", totals.branches},
                 {"length", totals.length},
                 {"failures", failures},
                 {"notes", notes}};
  if (!session.options.units.empty()) report["input"]["units"] = session.options.units;
  session.finished("write");
  if (draws) {
    pipeline::PageBuilder& builder = drawing.finished();
    builder.page.unit = session.options.units;
    builder.page.command = session.options.command;
    builder.page.title = pipeline::title_of(o.shape.file);
    if (!files.view.empty()) write_page(builder, files.view, report, outputs);
    session.finished("page");
    if (!files.picture.empty()) write_picture(builder.page, {}, files.picture, report, session);
  }
  write_report(files.report.string(), report, session);
  write_report(outputs, report, session);
  if (totals.failed > 0)
    session.say(fmt::format("warning: {} of {} cannot be used; {} says why, e.g. {}", totals.failed,
                            base::counted(totals.features, "feature"), files.features.string(),
                            failures[0]["sentence"].get<std::string>()));
  if (noted > 0)
    session.say(fmt::format("note: {} of features in {}, e.g. of feature {}: {}", base::counted(noted, "note"),
                            files.report.string(), notes[0]["feature"].get<std::uint64_t>(),
                            notes[0]["sentence"].get<std::string>()));
  if (not_drawn > 0)
    session.say(fmt::format("note: page and picture have no room for {}; a larger --max-triangles has",
                            base::counted(not_drawn, "feature")));
  if (left_out > 0)
    session.say(fmt::format("note: {} left out of {}, which holds what can be drawn",
                            base::counted(left_out, "feature is", "features are"), files.svg.string()));
  session.say(fmt::format("{}: {} of {}, {} long in all; also {}, {} and {}; {:.1f} s", files.geojson.string(),
                          base::counted(totals.branches, "branch", "branches"),
                          base::counted(totals.features - totals.failed, "feature"),
                          fmt::format("{:.6g}", totals.length), files.svg.string(), files.features.string(),
                          files.branches.string(), session.total_seconds()));
  return 0;
}

}  // namespace quench::program
