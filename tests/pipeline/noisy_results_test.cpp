// SPDX-License-Identifier: Apache-2.0
// Noise on the surface of a mesh adds nothing to curves (theta2 infinite, else default options): neither branches nor
// ends.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "full_run.h"
#include "quench/axis.h"
#include "quench/pipeline.h"
#include "quench/samples.h"

namespace quench::pipeline {
namespace noisy_results_test {

struct Curves {
  std::size_t branches = 0, ends = 0;
  bool operator==(const Curves&) const = default;
};

void PrintTo(const Curves& curves, std::ostream* out) {
  *out << curves.branches << " branches, " << curves.ends << " ends";
}

Curves pure_curves(LoadedShape shape) {
  RunOptions options;
  options.skeleton.theta2 = Length{std::numeric_limits<double>::infinity(), Length::Unit::infinite};
  const RunResult result = run(shape, options);
  EXPECT_LE(result.core.coverage, 2 * auto_detail(shape.shape.grid()) * (1 + 1e-9));
  Curves curves{result.axis.graph.branches.size(), 0};
  for (const auto& node : result.axis.graph.nodes) curves.ends += node.kind == CurveGraph::NodeKind::end;
  return curves;
}

// Moves every vertex along its normal, with this share of the longest side as the standard deviation.
void add_noise(TriangleMesh& mesh, double share, std::uint64_t seed) {
  std::vector<Vec3> normals(mesh.points.size(), Vec3::Zero());
  for (const auto& t : mesh.triangles) {
    const Vec3 normal = (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]);
    for (const std::uint32_t v : t) normals[v] += normal;
  }
  Vec3 low = mesh.points[0], high = low;
  for (const Vec3& p : mesh.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double deviation = share * (high - low).maxCoeff();
  std::mt19937_64 random(seed);
  const auto unit = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  for (std::size_t v = 0; v < normals.size(); ++v) {
    const double normal = std::sqrt(-2 * std::log(unit())) * std::cos(6.283185307179586 * unit());
    mesh.points[v] += deviation * normal * normals[v].normalized();
  }
}

TEST(NoisyResults, CurvesOfMeshesAreThoseWithoutNoise) {
  struct Known {
    const char* name;
    double fineness;
    Curves curves;
  };
  const std::uint64_t seeds = repeats(3, 1);
  for (const Known& known : {Known{"torus", 0.2, {1, 0}}, {"ellipsoid", 0.3, {1, 2}}})
    for (const double share : full_run() ? std::vector{0.0, 0.001, 0.002, 0.005} : std::vector{0.005})
      for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        SCOPED_TRACE(std::string(known.name) + ", noise " + std::to_string(share) + ", seed " + std::to_string(seed));
        TriangleMesh mesh = make_sample(known.name, {.fineness = known.fineness}).mesh;
        add_noise(mesh, share, seed);
        EXPECT_EQ(pure_curves(shape_of(std::move(mesh), {.resolution = 160})), known.curves);
      }
}

}  // namespace noisy_results_test
}  // namespace quench::pipeline
