// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "io/common/formats.h"
#include "quench/tree.h"

/// What readers of trees share.
namespace quench::io {

/// A point of a tree, with the segment from its parent.
struct TreeSample {
  Vec3 point = Vec3::Zero();
  double radius = 0;
  int type = 0;
  std::uint32_t parent = kNone;  ///< index of a sample before it; kNone: a root node
  std::uint32_t axis = kNone;    ///< a branch ends where it changes
  bool bridged = false;          ///< the segment
  std::optional<double> base_radius =
      {};  ///< of a branch that begins with the segment, where it is not the parent's there
};

/// Branches and plants of a forest of samples, parents before children; a root node without a child is left out.
/// `plant_of_root`: becomes the plant per root node in order, or kNone. O(n).
Tree tree_of_samples(std::span<const TreeSample> samples, std::vector<std::uint32_t>* plant_of_root = nullptr);

/// Strahler numbers and centrifugal orders of all branches. O(n).
void number_branches(Tree& tree);

/// Numbers of the branches that begin at the far end of each.
std::vector<std::uint32_t> children_of_branches(const Tree& tree);

Tree read_swc(const FileText& file, Context* context);
Tree read_rsml(const FileText& file, Context* context);

/// Throws Error(usage) where with_hierarchy() has not found the axes.
void require_axes(const Tree& tree, const char* format);

}  // namespace quench::io
