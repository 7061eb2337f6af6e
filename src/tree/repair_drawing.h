// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "quench/tree.h"
#include "tree/repair_polyline.h"

namespace quench::tree {

/// Lines between nodes that become a curve graph: what is left over of cuts goes, and lines that meet at a node of
/// two become one branch.
class Drawing {
 public:
  std::uint32_t add_node(const Vec3& point, double radius, std::uint32_t vertex);
  /// A node where a line was cut.
  std::uint32_t add_cut(const Vec3& point, double radius);
  void add_line(Polyline course, std::uint32_t from, std::uint32_t to);
  /// Fills in the graph and its bridges. The drawing is used up.
  void finish(Repaired& repaired);

 private:
  struct Node {
    Vec3 point;
    double radius;
    std::uint32_t vertex;
    bool cut;
    std::vector<std::uint32_t> lines;  // twice for a closed line
  };
  struct Line {
    Polyline course;
    std::uint32_t from, to;
    bool gone = false;
  };
  void drop_rests();
  void drop(std::uint32_t line);
  void join_lines();
  void make_graph(Repaired& repaired);

  std::vector<Node> nodes_;
  std::vector<Line> lines_;
};

}  // namespace quench::tree
