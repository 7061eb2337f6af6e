// SPDX-License-Identifier: Apache-2.0
// The main job on real data against independent results. QUENCH_TEST_FULL=1 adds every closed mesh at 512.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "data.h"
#include "quench/axis.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "quench/verify.h"
#include "quench/voxelize.h"

namespace quench {
namespace real_data_test {

struct ExpectedCore {
  const char* file;
  double threshold;
  std::int64_t voxels;
  std::size_t sites;
  Topology topology;
  std::size_t vertices, edges, faces;
};

// references/expected_core_sizes.tsv: from an independent exact computation.
class ExpectedCores : public testing::TestWithParam<ExpectedCore> {};

TEST_P(ExpectedCores, SizesAndTopologyAreExact) {
  const ExpectedCore& expected = GetParam();
  REQUIRE_DATA(expected.file);
  const std::string name = expected.file;
  const VoxelShape shape =
      foreground(io::read_volume(data_file(expected.file)), {.threshold = expected.threshold, .label = {}});
  EXPECT_EQ(shape.voxel_count(), expected.voxels);
  const Topology wanted = topology(shape);
  EXPECT_EQ(wanted, expected.topology);
  MedialAxis core = voxel_core(shape);
  EXPECT_EQ(core.sites.size(), expected.sites);
  EXPECT_EQ(core.complex.vertex_count, expected.vertices);
  EXPECT_EQ(core.complex.edges.size(), expected.edges);
  EXPECT_EQ(core.complex.face_count(), expected.faces);
  EXPECT_EQ(topology(core.complex), wanted);
  prune_levels(core);
  const Reconstruction reconstruction(shape, core);
  EXPECT_EQ(reconstruction.share(0), 1);
  const double lambda = auto_lambda(reconstruction, shape.longest_side(), shape.grid().spacing.minCoeff());
  EXPECT_GE(reconstruction.share(lambda), 0.95);
  EXPECT_EQ(topology(pruned(core, lambda).complex), wanted);
  EXPECT_EQ(topology(pruned(core, 3).complex), wanted);
}

INSTANTIATE_TEST_SUITE_P(
    Data, ExpectedCores,
    testing::Values(
        ExpectedCore{"references/bunny7.nrrd", 1, 305679, 45855, {1, {1, 0, 0}}, 56317, 120282, 63966},
        ExpectedCore{"volumes/Al.100.vol", 1, 70413, 21534, {-1, {1, 2, 0}}, 24083, 51634, 27550},
        ExpectedCore{"volumes/xyz-dragon-256.vol", 1, 422542, 104776, {-1, {1, 2, 0}}, 129368, 275001, 145632},
        ExpectedCore{"volumes/emd_5625.map", 1.991, 10609, 11482, {-7, {5, 12, 0}}, 10293, 22459, 12159},
        ExpectedCore{"volumes/lobster.vol", 80, 157904, 120407, {-355, {396, 772, 21}}, 104077, 219493, 115061},
        ExpectedCore{
            "volumes/maize_root_ct.nrrd", 20, 189697, 310756, {1241, {3116, 1880, 5}}, 189692, 379570, 191119}),
    [](const auto& test) {
      std::string name = std::filesystem::path(test.param.file).stem().string();
      std::replace_if(
          name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
      return name;
    });

TEST(Bunny7, PruningGivesThePublishedVerticesAndRadii) {
  REQUIRE_DATA("references/bunny7.nrrd");
  const VoxelShape shape = foreground(io::read_volume(data_file("references/bunny7.nrrd")), {});
  MedialAxis core = voxel_core(shape);
  prune_levels(core);
  const MedialAxis kept = pruned(core, 2.85);
  std::ifstream file(data_file("references/bunny7_lambda0.025.r"));
  std::size_t count = 0;
  file >> count;
  ASSERT_EQ(count, 14353u);
  ASSERT_EQ(kept.points.size(), count);
  std::vector<char> edge_used(kept.complex.edges.size(), 0);
  for (std::uint32_t e : kept.complex.face_edges) edge_used[e] = 1;
  EXPECT_EQ(std::count(edge_used.begin(), edge_used.end(), 0), 0) << "the published core has no lone edge";

  // Six printed digits: coordinates below 128 are rounded by at most 5e-4. Both lists in order of rounded coordinates.
  struct Row {
    std::array<double, 4> v;
  };
  std::vector<Row> published(count), ours(count);
  for (Row& r : published) file >> r.v[0] >> r.v[1] >> r.v[2] >> r.v[3];
  ASSERT_TRUE(file.good());
  for (std::size_t i = 0; i < count; ++i)
    ours[i].v = {kept.points[i][0], kept.points[i][1], kept.points[i][2], kept.radius[i]};
  // Match each published row with the nearest of ours through a coarse sort by x.
  std::sort(ours.begin(), ours.end(), [](const Row& a, const Row& b) { return a.v < b.v; });
  std::vector<char> taken(count, 0);
  for (const Row& p : published) {
    auto at =
        std::lower_bound(ours.begin(), ours.end(), p.v[0] - 1e-3, [](const Row& a, double x) { return a.v[0] < x; });
    bool found = false;
    for (; at != ours.end() && at->v[0] <= p.v[0] + 1e-3 && !found; ++at) {
      bool close = !taken[static_cast<std::size_t>(at - ours.begin())];
      for (int i = 0; i < 4; ++i) close = close && std::abs(at->v[i] - p.v[i]) <= 6e-4;
      if (close) {
        taken[static_cast<std::size_t>(at - ours.begin())] = 1;
        found = true;
      }
    }
    ASSERT_TRUE(found) << "published vertex " << p.v[0] << ' ' << p.v[1] << ' ' << p.v[2] << " radius " << p.v[3];
  }
}

void expect_main_job(const VoxelShape& shape, double longest_side, const std::string& where) {
  const Topology wanted = topology(shape);
  MedialAxis core = voxel_core(shape);
  ASSERT_EQ(topology(core.complex), wanted) << where;
  prune_levels(core);
  const Reconstruction reconstruction(shape, core);
  EXPECT_EQ(reconstruction.share(0), 1) << where;
  const double lambda = auto_lambda(reconstruction, longest_side, shape.grid().spacing.minCoeff());
  EXPECT_GE(reconstruction.share(lambda), 0.95) << where;
  for (double l : {lambda, 0.025 * longest_side}) {
    const MedialAxis kept = pruned(core, l);
    ASSERT_NO_THROW(kept.complex.validate()) << where;
    Record data = to_record(kept);
    data.field_data.push_back({"stage", 1, std::vector<std::string>{"core"}});
    const Certificate certificate = verify(shape, data, {.lambda = l, .samples = 5000});
    for (const Check& check : certificate.checks)
      EXPECT_TRUE(check.passed) << where << ": " << check.name << ": " << check.detail;
  }
}

TEST(Torso, AnisotropicSpacing) {
  REQUIRE_DATA("volumes/torsoLabel.nii.gz");
  const VoxelShape shape =
      foreground(io::read_volume(data_file("volumes/torsoLabel.nii.gz")), {.threshold = {}, .label = 5});
  EXPECT_EQ(integer_spacing(shape.grid()), (std::array<std::int64_t, 3>{391, 391, 2500}));
  expect_main_job(shape, shape.longest_side(), "torsoLabel");
}

class RealMeshes : public testing::TestWithParam<const char*> {};

TEST_P(RealMeshes, MainJob) {
  const std::string name = std::string("meshes/") + GetParam();
  REQUIRE_DATA(name.c_str());
  const std::int64_t resolution = std::getenv("QUENCH_TEST_FULL") ? 512 : 96;
  const TriangleMesh mesh = to_triangle_mesh(io::read_record(data_file(name.c_str())));
  const Voxelization v = voxelize(mesh, {.resolution = resolution});
  expect_main_job(v.shape, v.longest_side, name);
}

INSTANTIATE_TEST_SUITE_P(Data, RealMeshes,
                         testing::Values("abc_00000802.obj", "armadillo.off", "block.off", "bunny_closed.off",
                                         "casting.off", "elk.off", "fandisk.off", "fertility.off", "kitten.obj",
                                         "lucy.ply", "neptune.off", "octopus.off", "vessel.off"),
                         [](const auto& test) { return std::filesystem::path(test.param).stem().string(); });

}  // namespace real_data_test
}  // namespace quench
