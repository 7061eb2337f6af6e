// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_invoke.h>

#include <algorithm>

#include "base/constants.h"
#include "base/parallel.h"
#include "quench/skeleton.h"
#include "skeleton/member.h"

namespace quench {
namespace {

using skeleton::Member;

// Why nothing changes above the floor is proved in src/page/skeleton_layer.cpp: with the member K0 of the floor, the
// members above it follow by the same rules.
//
// What stays keeps its order. New numbers are not above the old ones, so arrays are compacted where they are.
class Compaction {
 public:
  Compaction(SkeletonFamily& family, Member& stays) : family_(family), k_(family.refined), stays_(stays) {}

  void run() {
    keep_halves();
    number_vertices();
    number_edges();
    std::vector<std::uint32_t>& incomplete = k_.incomplete;
    for (std::size_t f = 0; f < stays_.face.size(); ++f)
      if (!stays_.face[f] && (incomplete.empty() || incomplete.back() != k_.polygon_of[f]))
        incomplete.push_back(k_.polygon_of[f]);
    tbb::parallel_invoke([&] { compact_vertices(); }, [&] { compact_edges(); }, [&] { compact_faces(); });
  }

 private:
  // Doors have two halves, in order, whether members have both or not.
  void keep_halves() {
    for (std::uint32_t d = 0; d < k_.doors; ++d)
      if (stays_.vertex[k_.nodes + d])
        for (const std::size_t half : {2 * std::size_t{d}, 2 * std::size_t{d} + 1}) {
          if (!stays_.edge[half]) family_.edge_sheet_level[half] = -1;
          stays_.edge[half] = 1;
          for (const std::uint32_t v : k_.complex.edges[half]) {
            if (!stays_.vertex[v]) family_.vertex_sheet_level[v] = -1;
            stays_.vertex[v] = 1;
          }
        }
  }

  static std::vector<std::uint32_t> numbers(const std::vector<char>& stays) {
    std::vector<std::uint32_t> number(stays.size(), kNone);
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < stays.size(); ++i)
      if (stays[i]) number[i] = next++;
    return number;
  }
  void number_vertices() {
    vertex_ = numbers(stays_.vertex);
    const auto first = stays_.vertex.begin();
    const auto count = [&](std::uint32_t begin, std::uint32_t end) {
      return static_cast<std::uint32_t>(std::count(first + begin, first + end, 1));
    };
    const std::uint32_t original = count(0, k_.original), nodes = original + count(k_.original, k_.nodes);
    doors_before_ = k_.doors;
    const std::uint32_t doors = count(k_.nodes, k_.nodes + k_.doors);
    k_.original = original;
    k_.nodes = nodes;
    k_.doors = doors;
  }
  void number_edges() { edge_ = numbers(stays_.edge); }

  template <class T>
  static void compact(std::vector<T>& values, const std::vector<char>& stays, std::size_t first = 0) {
    std::size_t next = 0;
    for (std::size_t i = first; i < stays.size(); ++i)
      if (stays[i]) values[next++] = values[i - first];
    cut(values, next);
  }
  // Gives memory back where that is worth the copy.
  template <class T>
  static void cut(std::vector<T>& values, std::size_t size) {
    values.resize(size);
    if (size < values.capacity() / 4 * 3) values.shrink_to_fit();
  }

  void compact_vertices() {
    const std::vector<char>& stays = stays_.vertex;
    compact(k_.points, stays);
    compact(k_.radius, stays);
    compact(k_.burn_time, stays);
    if (!k_.mgf.empty()) compact(k_.mgf, stays);
    compact(k_.curve_vertex, stays);
    compact(k_.curve_burn_time, stays);
    compact(k_.medial_point, stays);
    for (std::uint32_t& e : k_.exit)
      if (e != kNone) e = edge_[e];
    compact(k_.exit, stays);
    compact(family_.vertex_sheet_level, stays);
    k_.complex.vertex_count = static_cast<std::uint32_t>(k_.points.size());
  }
  void compact_edges() {
    const std::vector<char>& stays = stays_.edge;
    compact(k_.complex.edges, stays);
    for (auto& ends : k_.complex.edges) ends = {vertex_[ends[0]], vertex_[ends[1]]};
    compact(k_.curve_edge, stays);
    compact(family_.edge_sheet_level, stays);
    compact(family_.curve_thickness, stays, 2 * std::size_t{doors_before_});
    compact(family_.curve_level, stays, 2 * std::size_t{doors_before_});
  }
  void compact_faces() {
    CellComplex& c = k_.complex;
    std::uint32_t corners = 0, begin = 0;
    std::size_t faces = 0;
    for (std::size_t f = 0; f < stays_.face.size(); ++f) {
      const std::uint32_t end = c.face_offsets[f + 1];
      if (stays_.face[f]) {
        for (std::uint32_t i = begin; i < end; ++i, ++corners) {
          c.face_vertices[corners] = vertex_[c.face_vertices[i]];
          c.face_edges[corners] = edge_[c.face_edges[i]];
          family_.corner_sheet_level[corners] = family_.corner_sheet_level[i];
        }
        c.face_offsets[++faces] = corners;
      }
      begin = end;
    }
    cut(c.face_offsets, faces + 1);
    cut(c.face_vertices, corners);
    cut(c.face_edges, corners);
    cut(family_.corner_sheet_level, corners);
    compact(k_.polygon_of, stays_.face);
    compact(k_.face_thickness, stays_.face);
    compact(family_.face_sheet_level, stays_.face);
  }

  SkeletonFamily& family_;
  RefinedAxis& k_;
  Member& stays_;
  std::vector<std::uint32_t> vertex_, edge_;  // new numbers, or kNone
  std::uint32_t doors_before_ = 0;
};

}  // namespace

SkeletonFamily with_floor(SkeletonFamily family, double theta2, double theta1, Context* context) {
  theta2 = std::max(theta2, family.theta2_floor);
  theta1 = std::max(theta1, family.theta1_floor);
  if (theta2 == family.theta2_floor && theta1 == family.theta1_floor) return family;
  base::in_arena(context, [&] {
    Member stays = skeleton::cells_from(family, theta2, theta1);
    checkpoint(context, "skeleton", 1);
    Compaction(family, stays).run();
  });
  family.theta2_floor = theta2;
  family.theta1_floor = theta1;
  return family;
}

}  // namespace quench
