// SPDX-License-Identifier: Apache-2.0
// The sheet of a plate with a known outline ends along it: at the seam, as far from the side as the plate is thick on
// one half, or where theta2 cuts it; smoothly in both cases.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "full_run.h"
#include "quench/pipeline.h"

namespace quench::pipeline {
namespace sheet_rims_test {

using Loop = std::vector<std::array<double, 2>>;

Loop circle(double radius) {
  Loop loop;
  for (int i = 0; i < 360; ++i) loop.push_back({radius * std::cos(M_PI * i / 180), radius * std::sin(M_PI * i / 180)});
  return loop;
}

// An outline, with a hole of as many points or none, and what lies inside it by a distance.
struct Plate {
  const char* name;
  Loop outer, hole;
  double (*inward)(double x, double y);  // distance of a point inside to the outline
  double (*length)(double inward);       // of the line so far inside
};

const Plate kPlates[]{
    {"disk",
     circle(1),
     {},
     [](double x, double y) { return 1 - std::hypot(x, y); },
     [](double d) { return 2 * M_PI * (1 - d); }},
    {"square",
     {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}},
     {},
     [](double x, double y) { return 1 - std::max(std::abs(x), std::abs(y)); },
     [](double d) { return 8 * (1 - d); }},
    {"ring", circle(1), circle(0.4),
     [](double x, double y) { return std::min(1 - std::hypot(x, y), std::hypot(x, y) - 0.4); },
     [](double d) { return 2 * M_PI * (1 - d) + 2 * M_PI * (0.4 + d); }},
};

TriangleMesh mesh_of(const Plate& plate, double half, const Eigen::Matrix3d& turned) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(plate.outer.size());
  const Loop inner = plate.hole.empty() ? Loop(n, {0, 0}) : plate.hole;
  for (const Loop* loop : {&plate.outer, &inner})
    for (const double z : {-half, half})
      for (const auto& [x, y] : *loop) mesh.points.push_back(turned * Vec3(x, y, z));
  const auto at = [&](std::uint32_t loop, std::uint32_t top, std::uint32_t i) { return (2 * loop + top) * n + i % n; };
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    quad(at(0, 0, i), at(0, 0, i + 1), at(0, 1, i + 1), at(0, 1, i));
    if (plate.hole.empty()) {
      mesh.triangles.push_back({at(0, 1, i), at(0, 1, i + 1), at(1, 1, 0)});
      mesh.triangles.push_back({at(0, 0, i + 1), at(0, 0, i), at(1, 0, 0)});
    } else {
      quad(at(0, 1, i), at(0, 1, i + 1), at(1, 1, i + 1), at(1, 1, i));
      quad(at(0, 0, i + 1), at(0, 0, i), at(1, 0, i), at(1, 0, i + 1));
      quad(at(1, 0, i + 1), at(1, 0, i), at(1, 1, i), at(1, 1, i + 1));
    }
  }
  return mesh;
}

// How far inside the outline the rims of a skeleton lie, weighted by length; lengths in voxels.
struct Rim {
  double length = 0, mean = 0, off = 0;  // off: mean distance to `from` inside
};

Rim rim_of(const Skeleton& skeleton, const Plate& plate, const Eigen::Matrix3d& turned, double from, bool from_mean) {
  const CellComplex& c = skeleton.complex;
  std::vector<int> faces(c.edges.size(), 0);
  for (const std::uint32_t e : c.face_edges) ++faces[e];
  Rim rim;
  for (const bool measured : {false, true}) {
    for (std::size_t e = 0; e < faces.size(); ++e) {
      if (faces[e] != 1) continue;
      const Vec3 a = skeleton.points[c.edges[e][0]], b = skeleton.points[c.edges[e][1]];
      const Vec3 middle = turned.transpose() * (0.5 * (a + b));
      const double length = (a - b).norm(), inward = plate.inward(middle[0], middle[1]);
      if (!measured) {
        rim.length += length;
        rim.mean += length * inward;
      } else {
        rim.off += length * std::hypot(inward - (from_mean ? rim.mean : from), middle[2]);
      }
    }
    (measured ? rim.off : rim.mean) /= rim.length;
  }
  return rim;
}

class SheetRims : public testing::TestWithParam<std::size_t> {};

TEST_P(SheetRims, AreSmoothWhereASheetEnds) {
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.6, Vec3(1, 2, 3).normalized()) * Eigen::AngleAxisd(0.37, Vec3::UnitY())).toRotationMatrix();
  const Plate& plate = kPlates[GetParam()];
  for (const double half : {0.06, 0.16})
    for (const Eigen::Matrix3d& turned : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), turn})
      for (const bool full : {true, false}) {
        const std::size_t number = GetParam() + (half < 0.1) + turned.isIdentity() + full;
        if (!full_run() && number % 2 != 0) continue;  // every second one of a chessboard
        SCOPED_TRACE(testing::Message() << plate.name << " of half thickness " << half
                                        << (turned.isIdentity() ? "" : " turned") << (full ? ", full" : ", pruned"));
        LoadedShape shape = shape_of(mesh_of(plate, half, turned), {.resolution = 128});
        RunOptions options;
        options.skeleton.full_tips = full;
        options.skeleton.theta2 = Length{0.05, Length::Unit::fraction};
        const RunResult result = run(shape, options);
        const double voxel = shape.scale().voxel;
        const Rim rim = rim_of(result.axis.skeleton.skeleton, plate, turned, half, !full);
        EXPECT_LE(rim.off, 0.3 * voxel) << rim.off / voxel << " voxels";
        EXPECT_NEAR(rim.length / plate.length(full ? half : rim.mean), 1, 0.02);
        // The fire starts half a voxel to one and a half inside the edges of the plate, where the axis is pruned.
        const double cut = 0.05 * shape.longest_side + half - (std::sqrt(2.0) - 1) * half;
        if (!full) {
          EXPECT_NEAR(rim.mean / voxel, cut / voxel, 1.5);
        }
      }
}

INSTANTIATE_TEST_SUITE_P(Plates, SheetRims, testing::Range(std::size_t{0}, std::size(kPlates)),
                         [](const auto& of) { return kPlates[of.param].name; });

}  // namespace sheet_rims_test
}  // namespace quench::pipeline
