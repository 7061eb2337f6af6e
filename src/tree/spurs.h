// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/tree.h"

namespace quench::tree {

/// Takes branches off a tree without axes that end within what they leave: whose last ball reaches out of the balls of
/// the branches around its fork by less than three voxels or three quarters of the radius there. Such are left by noise
/// in tubes of few voxels, where they run along the tube and are longer than its radius. Shortest first; branches that
/// follow each other without a fork then stay apart. Returns how many were taken off; others may end after that. At
/// least one branch of a tree stays.
std::size_t drop_spurs(Tree& tree, double voxel);

}  // namespace quench::tree
