// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "quench/graph.h"
#include "tree/repair_forest.h"
#include "tree/repair_polyline.h"

/// What is known of a graph before it is repaired. A *piece* is a branch; an *arm* is an end of a piece, the number of
/// the piece twice plus 1 for its far end. A *joint* is where arms meet: a node, or several that short pieces (*bars*)
/// connect. At a joint two arms may *continue* each other; a *pass* is a row of pieces that do.
namespace quench::tree {

struct Piece {
  Polyline course;
  std::array<std::uint32_t, 2> node{0, 0};
  double length = 0;
  bool bar = false;   ///< inside a joint
  bool link = false;  ///< a straight way across a sheet
  double neck = 0;    ///< least radius over that of what it connects, where it is a neck between two; else 0
  double cut_at = 0;  ///< where it would be cut, a distance along it
  double gain = 0;    ///< of keeping it
  std::uint32_t pass = kNone;
};

struct Arm {
  std::uint32_t joint = 0;
  double skip = 0;                  ///< how far along its piece it lies in the ball of the joint
  Vec3 place;                       ///< there
  Vec3 direction;                   ///< of the piece from there on, away from the joint
  double span = 0;                  ///< the length that the direction is taken over
  double radius = 0;                ///< median over some radii from there on
  std::uint32_t continued = kNone;  ///< by this arm
  double straight = 0;              ///< how well: 0 to 1
};

struct Joint {
  std::vector<std::uint32_t> nodes, bars, arms;  ///< ascending
  double radius = 0;                             ///< largest of its nodes
};

struct Pass {
  std::array<std::uint32_t, 2> arms{kNone, kNone};  ///< its ends; kNone: closed
  std::array<double, 2> radius{0, 0};               ///< means over the thirds at its ends
  double length = 0, widest = 0;
};

struct Model {
  std::vector<CurveGraph::Node> nodes;
  std::vector<Piece> pieces;
  std::vector<Arm> arms;
  std::vector<std::uint32_t> joint_of;  ///< per node
  std::vector<Joint> joints;
  std::vector<Pass> passes;
  std::vector<std::uint32_t> component;  ///< per node: of the graph, 0 .. components - 1
  std::uint32_t components = 0;
  double finest = 0;  ///< a voxel or, where that is not known, the median of radii

  std::uint32_t far(std::uint32_t arm) const { return arm ^ 1u; }
  const Piece& piece_of(std::uint32_t arm) const { return pieces[arm / 2]; }
  /// Whether the arm is a free end.
  bool is_free(std::uint32_t arm) const { return joints[arms[arm].joint].arms.size() == 1; }
};

/// `voxel`: smallest step of the voxels, 0: not known.
Model model_of(const CurveGraph& graph, double voxel);

/// An edge between two arms of a joint: how likely the one belongs to the other.
struct Contact {
  std::uint32_t joint = 0;
  ForestEdge edge;
};
std::vector<Contact> contacts_of(const Model& model);

}  // namespace quench::tree
