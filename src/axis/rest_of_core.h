// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "dual/bricks/part.h"
#include "dual/dual_complex.h"
#include "quench/axis.h"

/// A voxel core of which cells are gone already: pruned in bricks, where it was certain that they would go. What
/// follows from the rest is what follows from the whole (docs/algorithms/bricks.md).
namespace quench::axis {

/// What the cells that are gone have left behind at those that are there: the largest values of faces around an edge
/// and of edges around a vertex, -1 where none are gone. Empty: nothing is gone.
struct Carried {
  std::vector<double> edge_lambda, edge_detail, vertex_lambda, vertex_detail;
};
Carried carried_of(const dual::bricks::Part& part, const dual::bricks::PartComplex& complex);

/// Per face of the complex of a part dual::bricks::FaceValue::value; -1 where it is not known.
std::vector<double> known_heights(const dual::bricks::Part& part, const dual::DualComplex& complex);

/// The axis with points, radii and lambda. `sites`: that the complex refers to. Takes the complex and the sites of
/// faces and edges out of `dual`.
MedialAxis axis_of(dual::DualComplex& dual, std::vector<LatticePoint> sites, const Grid& grid, LambdaRule rule,
                   const Carried& carried, Context* context);

/// The cap heights that details follow from: of the cells that are part of no larger one, also of none that is gone;
/// others have kNoTopCell. They are below ties, and those of faces are lowered to the surface, where there is one.
/// `known`: as known_heights(), which then count; empty: none are.
CellValues heights_of(const MedialAxis& axis, const Carried& carried, std::span<const double> known,
                      const Surface* surface, Context* context);

/// A voxel core, or what is left of one.
struct RestOfCore {
  MedialAxis axis = {};
  Carried carried = {};
  std::vector<double> known = {};  ///< known_heights(); empty: none
  /// Boundary vertices of which it is not certain that a significant ball is near; none: those of the axis.
  std::optional<std::vector<LatticePoint>> pending = {};
  /// Sites of each vertex, and whether one of the faces around it in the whole core has the site; empty: all of these
  /// faces are there.
  std::vector<std::uint32_t> corner_begin = {}, corners = {};
  std::vector<std::uint8_t> contact = {};
  dual::bricks::Counts gone = {};  ///< cells

  bool is_whole() const { return gone.vertices + gone.edges + gone.faces == 0; }
};

/// What is left in a part in which all is complete. `contacts`: contact_sites() will be asked for. Frees the part on
/// the way.
RestOfCore rest_of(dual::bricks::Part&& part, const dual::Hulls& hulls, const Grid& grid, LambdaRule rule,
                   bool contacts, Context* context);

/// quench::add_detail() and quench::contact_sites() of the whole core, at what is left. Of details below the automatic
/// one only those are the same that prunings above the one in parts need.
void add_detail(RestOfCore& core, const Surface* surface, Context* context);
ContactSites contact_sites(const RestOfCore& core, double threshold, std::string_view measure);

}  // namespace quench::axis
