// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "quench/tree.h"
#include "tree/repair_model.h"

namespace quench::tree {

/// Where a bridge ends: at a free arm, an isolated joint, or a place on a piece.
struct BridgeEnd {
  std::uint32_t vertex = 0;     ///< of the forest
  std::uint32_t arm = kNone;    ///< a free end
  std::uint32_t joint = kNone;  ///< without arms
  std::uint32_t piece = kNone;
  double at = 0;  ///< along the piece
};

struct Bridge {
  BridgeEnd ends[2];
  Polyline course;  ///< from the first to the second
  double cost = 0, grey = 0;
};

/// What is kept of a model, and what is added.
struct Choice {
  std::vector<std::uint8_t> piece;  ///< per piece; bars count as kept
  std::vector<Contact> contacts;    ///< all
  std::vector<std::uint8_t> contact;
  std::vector<Bridge> bridges;         ///< those that are added
  std::vector<std::uint8_t> left_out;  ///< per vertex of the forest
};

/// Vertices of the forest: arms, then joints (those without arms count).
inline std::uint32_t vertex_of_joint(const Model& model, std::uint32_t joint) {
  return static_cast<std::uint32_t>(model.arms.size()) + joint;
}

/// The graph that a choice leaves, with its cuts and bridges as edits.
Repaired result_of(const Model& model, const Choice& choice);

}  // namespace quench::tree
