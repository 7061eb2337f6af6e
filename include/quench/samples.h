// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "quench/geometry.h"

namespace quench {

/// One branch of the `root` sample: a polyline with a radius per point, from its parent to its tip.
struct RootBranch {
  std::int32_t parent = -1;       ///< index of the branch it grows from; -1 for the main root
  std::int32_t parent_point = 0;  ///< index of the point of the parent it starts at
  std::vector<Vec3> points;
  std::vector<double> radius;
  double length() const;
};

struct SampleOptions {
  double noise = 0;        ///< height of ripples and bumps, fraction of the longest side; 0: the shape's own
  std::uint64_t seed = 1;  ///< `root`, `bead-pack`, `rough-plate`: another seed, another shape
  int branches = 60;       ///< `root`: number of branches
  double fineness = 1;     ///< multiplies the number of triangles along each direction
  int touching = 0;        ///< `root`: pairs of branches that touch each other on purpose
  int gaps = 0;            ///< `root` in grey values: places where a branch is interrupted
};

/// A place where the `root` sample was damaged on purpose.
struct RootDamage {
  enum class Kind : std::uint8_t { gap, touching } kind = Kind::gap;
  std::uint32_t branch = 0, other = 0;  ///< the two that touch; equal for a gap
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
};

struct Sample {
  TriangleMesh mesh;                 ///< closed; parts may overlap (inside is winding number != 0)
  std::vector<RootBranch> branches;  ///< `root` only: the truth
  std::vector<RootDamage> damage = {};  ///< `root` only
};

/// Names and one-line descriptions of the built-in shapes, in the order of the list.
struct SampleInfo {
  std::string_view name;
  std::string_view description;
  std::string_view options;  ///< which of SampleOptions matter, beside fineness, separated by ", "; empty: none
};
const std::vector<SampleInfo>& built_in_samples();

/// A built-in shape as a closed mesh. Deterministic on one machine. Throws Error(usage) listing the names when there is
/// no such shape.
Sample make_sample(std::string_view name, const SampleOptions& options = {});

}  // namespace quench
