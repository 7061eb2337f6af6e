// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "quench/context.h"
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
  /// `root`: number of branches. Up to some hundred they keep clear of each other; where there is no room left they run
  /// into each other, which Sample::damage lists.
  int branches = 60;
  double fineness = 1;   ///< multiplies the number of triangles along each direction
  int touching = 0;      ///< `root`: pairs of branches that touch each other on purpose
  int gaps = 0;          ///< `root`: places where a branch of its image is interrupted; the mesh has none
  double thickness = 1;  ///< `root`: multiplies the radii of all branches, from 0.01 to 1
};

/// A place where the `root` sample is not what its branches alone would be.
struct RootDamage {
  enum class Kind : std::uint8_t {
    gap,       ///< of an image: the branch is interrupted or dimmed
    touching,  ///< two branches that are not parent and child run into each other
  } kind = Kind::gap;
  std::uint32_t branch = 0, other = 0;          ///< the two that touch; equal for a gap
  std::uint32_t from_point = 0, to_point = 0;   ///< points of `branch` and of `other`
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  ///< these: the ends of the gap, or the centre lines where they touch
  double contrast = 1;                          ///< of a gap: what is left of it between its ends, 0 to 1
  bool on_purpose = true;                       ///< false: there was no room, see SampleOptions::branches
};

struct Sample {
  TriangleMesh mesh;                    ///< closed; parts may overlap (inside is winding number != 0)
  std::vector<RootBranch> branches;     ///< `root` only: the truth
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

/// The `root` sample as a scanner would see it.
struct GreyOptions {
  std::int64_t resolution = 256;  ///< voxels along the longest side
  double blur = 0;                ///< standard deviation of the Gaussian point spread, voxels
  double noise = 0;               ///< standard deviation of white Gaussian noise, fraction of the contrast
  std::uint64_t seed = 1;         ///< of the noise
};
inline constexpr int kGreyBackground = 50, kGreyObject = 200;

/// Where the voxels of its image lie: the box of the root, and a margin that the blur does not leave.
Grid grey_grid(const Sample& root, const GreyOptions& options);

/// Hands the slices of the image over, in order of z. A voxel has the share of its volume that is in a branch (of 4^3
/// points), blurred, between kGreyBackground and kGreyObject, plus noise, rounded. What is in memory is a slab of
/// slices, of each the box around the branches in it; the same on every number of threads.
void grey_slices(const Sample& root, const GreyOptions& options,
                 const std::function<void(std::span<const std::uint8_t>)>& take, Context* context = nullptr);

/// A function that makes the same image in cubes: `side`^3 voxels from voxel `begin` on, x fastest, kGreyBackground
/// beyond the image; none where no branch comes near and there is no noise. Several threads may call it. In memory are
/// the branches, in pieces, and per call a cube of floats and one of bytes; time is that of the branches in the cube.
std::function<std::vector<std::uint8_t>(const std::array<std::int64_t, 3>& begin)> grey_cubes(
    const Sample& root, const GreyOptions& options, std::int64_t side);

}  // namespace quench
