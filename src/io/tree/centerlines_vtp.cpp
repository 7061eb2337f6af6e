// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "io/common/formats.h"
#include "quench/tree.h"

namespace quench::io {
namespace {

/// Points and segments, branch by branch; write_vtp() joins the segments of a branch to a polyline.
class CenterlineRecord {
 public:
  explicit CenterlineRecord(const Tree& tree) : tree_(tree) {
    std::vector<std::uint32_t> root(tree.plants.size(), kNone), end(tree.branches.size(), kNone);
    for (std::uint32_t b = 0; b < tree.branches.size(); ++b) {
      const Tree::Branch& branch = tree.branches[b];
      std::uint32_t& base = branch.parent == kNone ? root[branch.plant] : end[branch.parent];
      if (base == kNone) base = add_point(branch.points[0], branch.radius[0], false);
      std::uint32_t last = base;
      for (std::size_t i = 1; i < branch.points.size(); ++i) {
        const bool gap = !branch.bridged.empty() && branch.bridged[i - 1] != 0;
        const std::uint32_t next = add_point(branch.points[i], branch.radius[i], gap);
        data_.lines.push_back({last, next});
        branch_of_line_.push_back(b);
        last = next;
      }
      end[b] = last;
    }
  }

  Record take() {
    data_.point_data.push_back({"radius", 1, radius_});
    data_.point_data.push_back({"MaximumInscribedSphereRadius", 1, radius_});  // as VMTK names it
    data_.point_data.push_back({"Radius", 1, std::move(radius_)});             // as its modules in 3D Slicer do
    if (std::ranges::find(gap_, 1) != gap_.end()) data_.point_data.push_back({"bridged", 1, std::move(gap_)});
    const auto per_branch = [&](const char* name, const auto& value_of) {
      std::vector<std::int32_t> values;
      for (const std::uint32_t b : branch_of_line_) values.push_back(static_cast<std::int32_t>(value_of(b)));
      data_.cell_data.push_back({name, 1, std::move(values)});
    };
    const auto& branches = tree_.branches;
    per_branch("branch", [](std::uint32_t b) { return b; });
    if (!tree_.axes.empty()) {
      per_branch("axis", [&](std::uint32_t b) { return branches[b].axis; });
      per_branch("level", [&](std::uint32_t b) { return tree_.axes[branches[b].axis].level; });
    }
    per_branch("order", [&](std::uint32_t b) { return branches[b].order; });
    per_branch("strahler", [&](std::uint32_t b) { return branches[b].strahler; });
    per_branch("plant", [&](std::uint32_t b) { return branches[b].plant; });
    per_branch("type", [&](std::uint32_t b) { return branches[b].type; });
    const auto say = [&](const char* name, const std::string& text) {
      if (!text.empty()) data_.field_data.push_back({name, 1, std::vector<std::string>{text}});
    };
    say("units", tree_.coordinates.units);
    if (tree_.coordinates.space == "LPS") say("SPACE", "LPS");
    say("version", QUENCH_VERSION);
    return std::move(data_);
  }

 private:
  std::uint32_t add_point(const Vec3& point, double radius, bool gap) {
    data_.points.push_back(point);
    radius_.push_back(radius);
    gap_.push_back(gap);
    return static_cast<std::uint32_t>(data_.points.size() - 1);
  }

  const Tree& tree_;
  Record data_;
  std::vector<double> radius_;
  std::vector<std::uint8_t> gap_;  ///< per point: the segment before it
  std::vector<std::uint32_t> branch_of_line_;
};

}  // namespace

void write_centerlines(const std::filesystem::path& file, const Tree& tree) {
  const Record data = CenterlineRecord(tree).take();
  write_atomically(file, [&](std::ostream& out) { write_vtp(out, data); });
}

}  // namespace quench::io
