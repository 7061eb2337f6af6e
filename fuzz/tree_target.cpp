// SPDX-License-Identifier: Apache-2.0
// A reader of trees: QUENCH_FUZZ_READER names it. What it hands over must keep the promises of Tree.
#include <cmath>

#include "io/tree/tree_samples.h"
#include "target.h"

namespace {

void check(const quench::Tree& tree) {
  using quench::kNone;
  using quench::fuzz::defect;
  if (tree.branches.empty()) defect("a tree has no branches");
  for (std::size_t b = 0; b < tree.branches.size(); ++b) {
    const quench::Tree::Branch& branch = tree.branches[b];
    if (branch.parent != kNone && branch.parent >= b) defect("a parent comes after its child");
    if (branch.plant >= tree.plants.size()) defect("a branch is of no plant");
    if (branch.points.size() < 2 || branch.radius.size() != branch.points.size())
      defect("a branch lacks points or radii");
    if (!branch.bridged.empty() && branch.bridged.size() + 1 != branch.points.size())
      defect("flags of segments are missing");
    const quench::Vec3& base =
        branch.parent == kNone ? tree.plants[branch.plant].root : tree.branches[branch.parent].points.back();
    if (branch.points[0] != base) defect("a branch does not begin at its parent");
    for (std::size_t i = 0; i < branch.points.size(); ++i)
      if (!branch.points[i].allFinite() || !(branch.radius[i] >= 0)) defect("a point or radius is none");
    if (!tree.axes.empty() && branch.axis >= tree.axes.size()) defect("a branch is of no axis");
  }
  for (std::size_t a = 0; a < tree.axes.size(); ++a) {
    const quench::Tree::Axis& axis = tree.axes[a];
    if (axis.parent != kNone && axis.parent >= a) defect("an axis comes before its parent");
    if (axis.branches.empty() || axis.plant >= tree.plants.size()) defect("an axis has no branches or no plant");
    if (axis.points.size() != axis.radius.size()) defect("an axis lacks radii");
    if (!(axis.position >= 0)) defect("an axis has no position");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quench;
  const io::FileText file{"file", {reinterpret_cast<const char*>(data), size}};
  fuzz::reads_or_refuses([&] { check(io::QUENCH_FUZZ_READER(file, nullptr)); });
  return 0;
}
