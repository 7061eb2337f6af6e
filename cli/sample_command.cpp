// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <ostream>

#include "base/text.h"
#include "option_checks.h"
#include "program.h"
#include "quench/io.h"
#include "quench/pipeline.h"
#include "quench/samples.h"
#include "quench/voxelize.h"

namespace quench::program {
namespace {

void write_truth(const std::string& file, const std::vector<RootBranch>& branches) {
  using Json = nlohmann::ordered_json;
  Json list = Json::array();
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const RootBranch& branch = branches[b];
    double mean = 0;
    for (double r : branch.radius) mean += r / static_cast<double>(branch.radius.size());
    Json points = Json::array();
    for (std::size_t i = 0; i < branch.points.size(); ++i)
      points.push_back({branch.points[i][0], branch.points[i][1], branch.points[i][2], branch.radius[i]});
    list.push_back({{"id", b},
                    {"parent", branch.parent},
                    {"parent_point", branch.parent_point},
                    {"length", branch.length()},
                    {"radius", mean},
                    {"points", std::move(points)}});
  }
  const Json truth = {{"branches", std::move(list)}};
  io::write_atomically(file, [&](std::ostream& out) { out << truth.dump(1) << '\n'; });
}

/// Triangles grow with the square of the detail, and a root has about a thousand per branch.
void check_sample_memory(const std::string& name, const SampleOptions& options, const Session& session) {
  const double triangles =
      (name == "root" ? 1000.0 * options.branches : 4e5) * std::max(options.fineness * options.fineness, 0.01);
  if (triangles > 8e9)  // two triangles a vertex
    throw Error(ErrorCode::usage,
                fmt::format("a sample of about {:.0f} triangles has more vertices than the 4,294,967,294 that can be "
                            "numbered; use a smaller --fineness or fewer --branches",
                            triangles));
  constexpr double bytes = 80;  // the mesh, and the copy that is written
  pipeline::require_memory(static_cast<std::int64_t>(triangles * bytes),
                           fmt::format("a sample of about {:.0f} triangles", triangles),
                           {"a smaller --fineness", "fewer --branches"}, &session.context);
}

/// "branching root with known branches (--seed, --branches)"
std::string description_of(const SampleInfo& info) {
  if (info.options.empty()) return std::string(info.description);
  std::string options = "--" + std::string(info.options);
  for (std::size_t at = 0; (at = options.find(", ", at)) != std::string::npos; at += 2) options.insert(at + 2, "--");
  return fmt::format("{} ({})", info.description, options);
}

}  // namespace

void check_mesh_format(const std::filesystem::path& output, const std::string& formats) {
  const std::string extension = extension_of(output);
  for (const char* known : {".ply", ".obj", ".vtp"})
    if (extension == known) return;
  throw Error(ErrorCode::usage, fmt::format("cannot write '{}': {}", output.string(), formats));
}

Action add_sample(CLI::App& app) {
  struct Options {
    std::string name, output;
    SampleOptions sample;
    std::int64_t resolution = 256;
  };
  auto o = std::make_shared<Options>();
  std::string names;
  for (const SampleInfo& info : built_in_samples())
    names += fmt::format("\n  {:<18}{}", info.name, description_of(info));
  app.add_option("NAME", o->name, "The shape:" + names)->type_name("")->required();
  app.add_option("-o,--output", o->output,
                 "A mesh (.ply .obj .vtp) or a volume (.nrrd); root also writes FILE.json, its true branches")
      ->type_name("FILE")
      ->required();
  add_number(app, "--seed", o->sample.seed, "root: another seed, another root")->type_name("N")->capture_default_str();
  add_number(app, "--branches", o->sample.branches, "root: number of branches, 1 to 100000", 1, 100000)
      ->type_name("N")
      ->capture_default_str();
  add_number(app, "--noise", o->sample.noise,
             "rippled-box, bumpy-sphere: height of the ripples or bumps as a fraction of the longest side, up to "
             "0.1; 0: the shape's own",
             0.0, 0.1)
      ->type_name("FRACTION")
      ->capture_default_str();
  add_number(app, "--fineness", o->sample.fineness,
             "Multiplies the number of triangles along each direction, 0.01 to 16", 0.01, 16.0)
      ->type_name("FACTOR")
      ->capture_default_str();
  add_number<std::int64_t>(app, "--resolution", o->resolution, "Volumes: voxels along the longest side, 1 to 16384", 1,
                           16384)
      ->type_name("N")
      ->capture_default_str();
  return [o](Session& session) {
    namespace fs = std::filesystem;
    session.check_output(o->output, {});
    const bool volume = io::kind_of(o->output) == io::Kind::volume;
    if (volume)
      check_volume_format(o->output);
    else
      check_mesh_format(o->output, "samples are written as .ply, .obj, .vtp or .nrrd");
    fs::path truth = o->output;
    truth.replace_extension(".json");
    if (o->name == "root") session.check_output(truth, {});
    check_sample_memory(o->name, o->sample, session);
    const Sample sample = make_sample(o->name, o->sample);
    std::vector<std::string> lines;
    io::OutputGroup outputs;
    if (volume) {
      pipeline::require_voxelization_memory(sample.mesh, o->resolution, &session.context);
      const Voxelization v = voxelize(sample.mesh, {.resolution = o->resolution}, &session.context);
      io::write_volume(o->output, v.shape, {}, &session.context);
      lines.push_back(fmt::format("{}: {} inside", o->output, base::counted(v.shape.voxel_count(), "voxel")));
    } else {
      io::write_record(o->output, to_record(sample.mesh));
      lines.push_back(fmt::format("{}: {} vertices, {} triangles", o->output, sample.mesh.points.size(),
                                  sample.mesh.triangles.size()));
    }
    if (!sample.branches.empty()) {
      write_truth(truth.string(), sample.branches);
      lines.push_back(
          fmt::format("{}: {}", truth.string(), base::counted(sample.branches.size(), "true branch", "true branches")));
    }
    outputs.commit();
    for (const std::string& line : lines) session.say(line);
    return 0;
  };
}

}  // namespace quench::program
