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

using Json = nlohmann::ordered_json;

Json json_of_point(const Vec3& p) { return {p[0], p[1], p[2]}; }

Json damage_of(const RootDamage& d) {
  if (d.kind == RootDamage::Kind::gap)
    return {{"kind", "gap"},          {"branch", d.branch},       {"from_point", d.from_point},
            {"to_point", d.to_point}, {"from", json_of_point(d.from)}, {"to", json_of_point(d.to)},
            {"contrast", d.contrast}};
  return {{"kind", "touching"},    {"branch", d.branch},        {"other", d.other},
          {"point", d.from_point}, {"other_point", d.to_point}, {"from", json_of_point(d.from)},
          {"to", json_of_point(d.to)},  {"on_purpose", d.on_purpose}};
}

void write_truth(const std::string& file, const Sample& sample) {
  const std::vector<RootBranch>& branches = sample.branches;
  Json list = Json::array();
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const RootBranch& branch = branches[b];
    double mean = 0;
    for (double r : branch.radius) mean += r / static_cast<double>(branch.radius.size());
    int level = 0;
    for (std::int32_t p = branch.parent; p >= 0; p = branches[static_cast<std::size_t>(p)].parent) ++level;
    Json points = Json::array();
    for (std::size_t i = 0; i < branch.points.size(); ++i)
      points.push_back({branch.points[i][0], branch.points[i][1], branch.points[i][2], branch.radius[i]});
    list.push_back({{"id", b},
                    {"parent", branch.parent},
                    {"parent_point", branch.parent_point},
                    {"level", level},
                    {"length", branch.length()},
                    {"radius", mean},
                    {"points", std::move(points)}});
  }
  Json damage = Json::array();
  for (const RootDamage& d : sample.damage) damage.push_back(damage_of(d));
  const Json truth = {{"branches", std::move(list)}, {"damage", std::move(damage)}};
  io::write_atomically(file, [&](std::ostream& out) { out << truth.dump(1) << '\n'; });
}

/// Zarr, chunk by chunk, or NRRD, uint8, raw, slice by slice.
void write_grey(const std::string& file, const Sample& sample, const GreyOptions& options, Context* context) {
  const Grid grid = grey_grid(sample, options);
  if (io::is_zarr_name(file))
    return io::write_zarr(file, grid, kGreyBackground, grey_cubes(sample, options, io::kZarrSide), {}, context);
  io::write_atomically(file, [&](std::ostream& out) {
    const double h = grid.spacing[0];
    out << fmt::format(
        "NRRD0004\n# background {}, object {}\ntype: uint8\ndimension: 3\nspace dimension: 3\nsizes: {} {} {}\n"
        "space directions: ({},0,0) (0,{},0) (0,0,{})\nkinds: domain domain domain\nencoding: raw\n"
        "space origin: ({},{},{})\n\n",
        kGreyBackground, kGreyObject, grid.dims[0], grid.dims[1], grid.dims[2], h, h, h, grid.origin[0], grid.origin[1],
        grid.origin[2]);
    grey_slices(
        sample, options,
        [&](std::span<const std::uint8_t> slice) {
          out.write(reinterpret_cast<const char*>(slice.data()), static_cast<std::streamsize>(slice.size()));
        },
        context);
  });
}

/// A slab of slices, twice, of values that are 4 bytes; of Zarr on each of 16 threads a chunk, painted, in bytes and
/// compressed.
std::int64_t grey_bytes(const Grid& grid, const GreyOptions& options, bool zarr) {
  const double slice = zarr ? io::kZarrSide * io::kZarrSide : static_cast<double>(grid.dims[0] * grid.dims[1]);
  const double slices = zarr ? 16 * io::kZarrSide : 32;
  return static_cast<std::int64_t>(slice * (slices * 6 + 16 * 6 * options.blur * 4));
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
    double noise = 0, blur = 0;
    bool grey = false;
  };
  auto o = std::make_shared<Options>();
  std::string names;
  std::vector<std::string> words;
  for (const SampleInfo& info : built_in_samples()) {
    names += fmt::format("\n  {:<18}{}", info.name, description_of(info));
    words.emplace_back(info.name);
  }
  app.add_option("NAME", o->name, "The shape:" + names)->type_name("")->required()->check(also(words));
  app.add_option("-o,--output", o->output,
                 "A mesh (.ply .obj .vtp) or a volume (.nrrd, .zarr); root also writes FILE.json, its true branches")
      ->type_name("FILE")
      ->required();
  add_number(app, "--seed", o->sample.seed, "root: another seed, another root")->type_name("N")->capture_default_str();
  add_number(app, "--branches", o->sample.branches, "root: number of branches, 1 to 100000", 1, 100000)
      ->type_name("N")
      ->capture_default_str();
  add_number(app, "--thickness", o->sample.thickness, "root: multiplies the radii of all branches, 0.01 to 1", 0.01,
             1.0)
      ->type_name("FACTOR")
      ->capture_default_str();
  add_number(app, "--touching", o->sample.touching, "root: pairs of branches that are bent until they touch", 0, 100000)
      ->type_name("N")
      ->capture_default_str();
  auto* grey = app.add_flag("--grey", o->grey,
                            fmt::format("root: an image of 8-bit values instead of a mask, {} outside and {} inside, "
                                        "voxels at the surface by the share of them that is inside",
                                        kGreyBackground, kGreyObject));
  add_number(app, "--gaps", o->sample.gaps, "root, with --grey: places where a branch is interrupted or dimmed", 0,
             100000)
      ->type_name("N")
      ->capture_default_str()
      ->needs(grey);
  add_number(app, "--blur", o->blur, "root, with --grey: standard deviation of a Gaussian blur, voxels", 0.0, 20.0)
      ->type_name("SIGMA")
      ->capture_default_str()
      ->needs(grey);
  add_number(app, "--noise", o->noise,
             "rippled-box, bumpy-sphere, rough-plate: height of the ripples or bumps as a fraction of the longest "
             "side, up to 0.1; 0: the shape's own. root, with --grey: standard deviation of Gaussian noise as a "
             "fraction of the contrast",
             0.0, 10.0)
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
    const bool volume = io::is_zarr_name(o->output) || io::kind_of(o->output) == io::Kind::volume;
    if (volume)
      check_volume_format(o->output);
    else
      check_mesh_format(o->output, "samples are written as .ply, .obj, .vtp, .nrrd or .zarr");
    fs::path truth = o->output;
    if (!truth.has_filename()) truth = truth.parent_path();  // the slash behind a folder
    truth.replace_extension(".json");
    if (o->name == "root") session.check_output(truth, {});
    if (o->grey && (o->name != "root" || !volume))
      throw Error(ErrorCode::usage, "--grey makes a volume (.nrrd, .zarr) of the sample root");
    if (!o->grey && o->noise > 0.1) throw Error(ErrorCode::usage, "--noise goes from 0 to 0.1 without --grey");
    check_sample_memory(o->name, o->sample, session);
    SampleOptions options = o->sample;
    if (!o->grey) options.noise = o->noise;
    const Sample sample = make_sample(o->name, options);
    std::vector<std::string> lines;
    io::OutputGroup outputs;
    if (o->grey) {
      const GreyOptions image{.resolution = o->resolution, .blur = o->blur, .noise = o->noise, .seed = o->sample.seed};
      const Grid grid = grey_grid(sample, image);
      pipeline::require_memory(grey_bytes(grid, image, io::is_zarr_name(o->output)), "an image of this resolution",
                               {"a smaller --resolution"}, &session.context);
      write_grey(o->output, sample, image, &session.context);
      lines.push_back(fmt::format("{}: {} x {} x {} grey values", o->output, grid.dims[0], grid.dims[1], grid.dims[2]));
    } else if (volume) {
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
      write_truth(truth.string(), sample);
      lines.push_back(fmt::format("{}: {}, {}", truth.string(),
                                  base::counted(sample.branches.size(), "true branch", "true branches"),
                                  base::counted(sample.damage.size(), "damaged place")));
    }
    outputs.commit();
    for (const std::string& line : lines) session.say(line);
    return 0;
  };
}

}  // namespace quench::program
