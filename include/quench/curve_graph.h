// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "quench/geometry.h"
#include "quench/skeleton.h"

namespace quench {

/// The curve part of a skeleton as a graph: what plant and neuro labs measure on.
struct CurveGraph {
  enum class NodeKind : std::uint8_t { end, junction, sheet, loop, isolated };
  struct Node {
    Vec3 point;
    double radius = 0;
    NodeKind kind =
        NodeKind::end;            ///< `sheet`: where curves meet a sheet; `loop`: an arbitrary point of a closed curve
    std::uint32_t component = 0;  ///< of the whole skeleton, sheets included
    std::uint32_t degree = 0;     ///< branch ends at the node
  };
  /// A polyline from node to node. All lengths in world units.
  struct Branch {
    std::uint32_t from = 0, to = 0;
    std::vector<Vec3> points;  ///< the first and last are those of the nodes
    std::vector<double> radius;
    double length = 0;
    double mean_radius = 0, min_radius = 0, max_radius = 0;  ///< mean along the length
    double thickness = 0;                                    ///< largest ET_MC on it; infinite on loops
    double tortuosity = 1;  ///< length over distance of the ends; infinite for a closed branch
    std::uint32_t component = 0;
  };
  std::vector<Node> nodes;
  std::vector<Branch> branches;
  std::uint32_t components = 0;
  std::vector<std::uint32_t> sheet_only;  ///< components without any curve
};

/// Nodes are vertices with other than two curve edges, or on a sheet; branches run between them; a closed curve without
/// node gets one. Deterministic, O(n).
CurveGraph curve_graph(const Skeleton& skeleton);

}  // namespace quench
