// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "quench/context.h"
#include "quench/geometry.h"
#include "quench/record.h"
#include "quench/shape.h"

namespace quench {

/// One thing that was checked about a result.
struct Check {
  std::string name;  ///< e.g. "euler and Betti numbers"
  bool passed = false;
  std::string detail;  ///< figures when it passed, the first counterexample when it did not
  /// The arrays of the file it covers, as "point radius", "cell kind" or "field betti".
  std::vector<std::string> arrays{};
};

/// An array of the file that no check covers.
struct UncheckedArray {
  std::string array;   ///< as in Check
  std::string reason;  ///< e.g. "only bounds are checked"
};

struct Certificate {
  std::vector<Check> checks;
  /// Every array of the file is in one of the checks or here; the last check has the same in one sentence.
  std::vector<UncheckedArray> not_checked;
  /// Arrays that Quench writes for the stage of the file and that the file does not have, as in Check; of a file
  /// without one, "field stage". The last check has them in its sentence, too.
  std::vector<std::string> absent;
  bool passed() const;
};

struct VerifyOptions {
  std::optional<double> lambda = std::nullopt;  ///< world units; default: the result's FieldData, else 0
  std::optional<double> detail = std::nullopt;  ///< the same of a core pruned by detail; not both
  std::size_t samples = 20000;                  ///< cells per sampled check
  std::optional<double> longest_side =
      std::nullopt;  ///< of what the voxel shape was made of; without it that array is not checked
  /// What the points and radii of a fitted result refer to: closed, with triangles facing outward, and its kind
  /// ("mesh", "grey" or "smooth"). Without it the arrays that refer to it are not checked. Must outlive the call.
  const TriangleMesh* surface = nullptr;
  std::string surface_kind = {};
  std::optional<bool> y_down = std::nullopt;  ///< in the plane: Coordinates::y_down; without it `y_axis` is not checked
  int subdivided = 1;                         ///< into so many along each side the voxels of the input were split
  /// Of a surface of grey values: these, and the threshold they were cut at. Must outlive the call.
  const ImageView* image = nullptr;
  double threshold = 0;
  bool inverted = false;  ///< the shape is what is below it
  /// Of a file that is the whole core: the erosion thickness of its points, one per point, burned again. Without it only bounds of
  /// `core_erosion_thickness` and `relative_erosion_thickness` are checked. Must outlive the call.
  const std::vector<double>* erosion_of_core = nullptr;
  /// The result was written in full and in a format that holds all arrays (VTP): it is an error when an array is absent
  /// without which its stage cannot be checked. Otherwise absent arrays are only named.
  bool format_holds_all = false;
};

/// Verifies a result against its shape, by code of its own. What is checked in full, what on a sample, and
/// which code is shared with what made the result: docs/user/guarantees.md, "What is checked, and by whom". `result` is
/// what a file holds: complex by points, verts, lines and polys, point array `radius`; it must be of the dimension of
/// the shape. Throws Error(usage) when both lambda and detail are given, or one of them for a core that says it was
/// pruned by the other.
Certificate verify(const VoxelShape& shape, const Record& result, const VerifyOptions& options = {},
                   Context* context = nullptr);

}  // namespace quench
