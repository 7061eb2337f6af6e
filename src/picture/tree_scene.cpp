// SPDX-License-Identifier: Apache-2.0
#include "picture/tree_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "quench/error.h"

namespace quench::picture {
namespace {

using Numbers = std::vector<std::uint32_t>;
using Floats = std::vector<float>;

constexpr std::array<std::string_view, 5> kParted{"level", "axis", "plant", "branch", "bridged"};

/// The array, of the size that it must have.
template <class T>
const std::vector<T>& values(const Page& page, const std::string& name, std::size_t size) {
  const std::vector<T>* const found = find_values<T>(page, "tree/" + name);
  if (!found || found->size() != size)
    throw Error(ErrorCode::usage, fmt::format("the array 'tree/{}' of a page does not fit its other arrays", name));
  return *found;
}

std::size_t size_of(const Page& page, const std::string& name) {
  const Numbers* const found = find_values<std::uint32_t>(page, "tree/" + name);
  return found ? found->size() : 0;
}

/// The branches of a page with what is known of each.
class Branches {
 public:
  explicit Branches(const Page& page)
      : page_(page),
        axes(size_of(page, "axis_level")),
        count(std::max<std::size_t>(1, size_of(page, "branch_offsets")) - 1),
        offsets(values<std::uint32_t>(page, "branch_offsets", count + 1)),
        axis(values<std::uint32_t>(page, "branch_axis", count)) {
    const Floats* const points = find_values<float>(page, "tree/points");
    const bool good = offsets.front() == 0 && points && 3 * std::size_t{offsets.back()} == points->size() &&
                      std::ranges::is_sorted(offsets) &&
                      std::ranges::all_of(axis, [&](std::uint32_t a) { return a < axes; });
    if (!good) throw Error(ErrorCode::usage, "the branches of the tree of a page do not fit its other arrays");
  }

  std::uint32_t part(std::uint32_t branch, const std::string& color) const {
    if (color == "branch") return branch;
    if (color == "axis") return axis[branch];
    return values<std::uint32_t>(page_, "axis_" + color, axes)[axis[branch]];
  }
  /// Per branch.
  Floats measure(const std::string& color) const {
    if (color.starts_with("branches/")) return values<float>(page_, color, count);
    Floats of(count);
    if (color.starts_with("axes/")) {
      const Floats& by_axis = values<float>(page_, color, axes);
      for (std::size_t b = 0; b < count; ++b) of[b] = by_axis[axis[b]];
    } else {
      const Numbers& numbers = values<std::uint32_t>(page_, "branch_" + color, count);
      of.assign(numbers.begin(), numbers.end());
    }
    return of;
  }

 private:
  const Page& page_;

 public:
  const std::size_t axes, count;
  const Numbers &offsets, &axis;
};

/// Levels have names in the legend, with how many axes they have.
void name_parts(const Page& page, const std::string& color, Scene& scene) {
  if (color == "bridged") scene.part_names = {{"in the shape", 0}, {"bridged", 1}};
  if (color != "level") return;
  Numbers counts;
  for (const std::uint32_t level : values<std::uint32_t>(page, "axis_level", axes_of(page))) {
    if (level >= counts.size()) counts.resize(level + 1, 0);
    ++counts[level];
  }
  for (std::uint32_t level = 0; level < counts.size(); ++level)
    scene.part_names.emplace_back(fmt::format("level {} ({})", level, counts[level]), level);
}

}  // namespace

const PageColumn* column_of(const Page& page, const std::string& color) {
  if (!page.tree) return nullptr;
  for (const PageColumn& column : page.tree->columns)
    if (column.table + "/" + column.name == color) return &column;
  return nullptr;
}

bool is_colour_of_tree(const Page& page, const std::string& color) {
  if (std::ranges::find(kParted, color) != kParted.end() || color == "order" || color == "strahler") return true;
  if (page.find("tree/point/" + color)) return true;
  const PageColumn* const column = column_of(page, color);
  return column && column->words.empty() && (column->table == "axes" || column->table == "branches");
}

void add_tree_cells(const Page& page, const ViewState& state, Scene& scene) {
  const Branches branches(page);
  const std::string& color = state.color;
  const bool parts = std::ranges::find(kParted, color) != kParted.end();
  scene.radius = values<float>(page, "point/radius", branches.offsets.back());
  for (float& r : scene.radius) r *= static_cast<float>(scene.placement.scale);
  std::vector<char> bridged(scene.points.size(), 0);
  for (const std::uint32_t p : values<std::uint32_t>(page, "bridged", size_of(page, "bridged")))
    if (p < bridged.size()) bridged[p] = 1;
  const bool by_branch = !parts && color != "none" && scene.values.empty();
  const Floats measure = by_branch ? branches.measure(color) : Floats();
  for (std::uint32_t b = 0; b < branches.count; ++b) {
    for (std::uint32_t p = branches.offsets[b]; p + 1 < branches.offsets[b + 1]; ++p) {
      scene.curves.push_back({p, p + 1});
      if (parts)
        scene.curve_parts.push_back(color == "bridged" ? static_cast<std::uint32_t>(bridged[p])
                                                       : branches.part(b, color));
    }
    if (by_branch) scene.values.insert(scene.values.end(), branches.offsets[b + 1] - branches.offsets[b], measure[b]);
  }
  for (float& x : scene.values) x = std::isnan(x) ? kCodeMissing : x;
  name_parts(page, color, scene);
}

std::size_t axes_of(const Page& page) { return size_of(page, "axis_level"); }

double sample_value(const Page& page, const std::string& name) {
  const PageArray* const array = page.find("tree/sample/" + name);
  const Floats* const found = array ? std::get_if<Floats>(&array->values) : nullptr;
  return found && !found->empty() ? found->front() : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace quench::picture
