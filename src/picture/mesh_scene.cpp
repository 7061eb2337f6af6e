// SPDX-License-Identifier: Apache-2.0
// As viewer/src/collapses.ts.
#include "picture/mesh_scene.h"

#include <algorithm>
#include <array>
#include <set>

#include "quench/error.h"

namespace quench::picture {
namespace {

using Rows = std::vector<std::uint32_t>;
using Reals = std::vector<float>;

[[noreturn]] void refuse_meshes() { throw Error(ErrorCode::usage, "the medial meshes of a page do not fit together"); }

template <class T>
const std::vector<T>& array_of(const Page& page, const char* name) {
  const std::vector<T>* const found = find_values<T>(page, std::string("simple/") + name);
  if (!found) refuse_meshes();
  return *found;
}

/// The arrays of the layer, and where its vertices are after some of its steps.
class Meshes {
 public:
  explicit Meshes(const Page& page)
      : points(array_of<float>(page, "points")),
        radius(array_of<float>(page, "point/radius")),
        triangles(array_of<std::uint32_t>(page, "triangles")),
        edges(array_of<std::uint32_t>(page, "edges")),
        steps_(array_of<std::uint32_t>(page, "steps")),
        step_points_(array_of<float>(page, "step_points")),
        step_radius_(array_of<float>(page, "step_radius")),
        into(radius.size()) {
    const auto inside = [&](std::uint32_t v) { return v < radius.size(); };
    if (points.size() != 3 * radius.size() || triangles.size() % 3 != 0 || edges.size() % 2 != 0 ||
        step_points_.size() != 3 * step_radius_.size() || steps_.size() != 2 * step_radius_.size() ||
        !std::ranges::all_of(triangles, inside) || !std::ranges::all_of(edges, inside) ||
        !std::ranges::all_of(steps_, inside))
      refuse_meshes();
    for (std::uint32_t v = 0; v < into.size(); ++v) into[v] = v;
  }

  std::size_t merges() const {
    std::size_t count = 0;
    for (std::size_t s = 0; s < steps_.size(); s += 2) count += steps_[s] != steps_[s + 1] ? 1 : 0;
    return count;
  }

  /// Takes all steps before the one that would take away one more.
  void go_to(std::size_t vertices) {
    std::size_t left = radius.size();
    for (std::size_t s = 0; s < step_radius_.size(); ++s) {
      const std::uint32_t kept = steps_[2 * s], removed = steps_[2 * s + 1];
      if (kept != removed) {
        if (left <= vertices) break;
        into[removed] = kept;
        --left;
      }
      std::copy_n(step_points_.begin() + static_cast<std::ptrdiff_t>(3 * s), 3,
                  points.begin() + static_cast<std::ptrdiff_t>(3 * kept));
      radius[kept] = step_radius_[s];
    }
  }

  std::uint32_t find(std::uint32_t v) {
    for (std::size_t steps = 0; into[v] != v; v = into[v])
      if (++steps > into.size()) refuse_meshes();
    return v;
  }

  Reals points, radius;
  const Rows &triangles, &edges;

 private:
  const Rows& steps_;
  const Reals &step_points_, &step_radius_;

 public:
  Rows into;  ///< per vertex the one that it became one with, or itself
};

}  // namespace

std::size_t mesh_vertices(const Page& page, const ViewState& state) {
  const Meshes meshes(page);
  const std::size_t most = meshes.radius.size();
  return std::clamp(state.vertices, most - std::min(most - 1, meshes.merges()), most);
}

void add_mesh_cells(const Page& page, const ViewState& state, Scene& scene) {
  Meshes meshes(page);
  meshes.go_to(mesh_vertices(page, state));
  Rows row(meshes.radius.size(), kNone);
  for (std::uint32_t v = 0; v < row.size(); ++v) {
    if (meshes.into[v] != v) continue;
    row[v] = static_cast<std::uint32_t>(scene.points.size());
    const Vec3 world = page.origin + Vec3(meshes.points[3 * v], meshes.points[3 * v + 1], meshes.points[3 * v + 2]);
    scene.points.push_back(scene.placement.to_scene(world).cast<float>());
    if (state.color == "radius") scene.values.push_back(meshes.radius[v]);
  }
  std::set<std::array<std::uint32_t, 2>> offered, sides;
  std::set<std::array<std::uint32_t, 3>> faces;
  const auto pair = [](std::uint32_t a, std::uint32_t b) { return std::array{std::min(a, b), std::max(a, b)}; };
  for (std::size_t t = 0; t < meshes.triangles.size(); t += 3) {
    std::array<std::uint32_t, 3> c{};
    for (std::size_t k = 0; k < 3; ++k) c[k] = row[meshes.find(meshes.triangles[t + k])];
    for (std::size_t k = 0; k < 3; ++k) offered.insert(pair(c[k], c[(k + 1) % 3]));
    std::ranges::sort(c);
    if (c[0] == c[1] || c[1] == c[2] || !faces.insert(c).second) continue;
    for (std::size_t k = 0; k < 3; ++k) sides.insert(pair(c[k], c[(k + 1) % 3]));
    scene.sheets.corners.insert(scene.sheets.corners.end(), c.begin(), c.end());
    scene.sheets.offsets.push_back(static_cast<std::uint32_t>(scene.sheets.corners.size()));
  }
  for (std::size_t e = 0; e < meshes.edges.size(); e += 2)
    offered.insert(pair(row[meshes.find(meshes.edges[e])], row[meshes.find(meshes.edges[e + 1])]));
  std::vector<char> used(scene.points.size(), 0);
  for (const auto& c : faces)
    for (const std::uint32_t v : c) used[v] = 1;
  for (const auto& ends : offered) {
    if (ends[0] == ends[1] || sides.contains(ends)) continue;
    scene.curves.push_back(ends);
    used[ends[0]] = used[ends[1]] = 1;
  }
  for (std::uint32_t v = 0; v < used.size(); ++v)
    if (!used[v]) scene.isolated.push_back(v);
}

}  // namespace quench::picture
