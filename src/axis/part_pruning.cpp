// SPDX-License-Identifier: Apache-2.0
// docs/algorithms/pruning_in_parts.md
#include "axis/part_pruning.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "axis/caps_on_surface.h"
#include "axis/cover_needs.h"
#include "axis/measures.h"
#include "axis/rest_of_core.h"
#include "axis/significant_parts.h"
#include "base/parallel.h"
#include "complex/certain_thinning.h"

namespace quench::axis {
namespace {

using dual::bricks::Box;
using dual::bricks::FaceValue;
using dual::bricks::Part;
using dual::bricks::PartComplex;

using Flags = std::vector<std::uint8_t>;

class PartPruner {
 public:
  PartPruner(Part& part, const dual::Hulls& hulls, const PartPruning& how, Context* context)
      : part_(part), how_(how), context_(context), least_(auto_detail(how.grid)) {
    part_.extend();
    complex_ = complex_of(part_, hulls, context_);
    set_contacts();
    carried_ = carried_of(part_, complex_);
    known_ = known_heights(part_, complex_.dual);
    axis_ = axis_of(complex_.dual, std::move(part_.sites), how_.grid, how_.rule, carried_, context_);
    uncertain_vertex_ = complex_.vertex_incomplete;
    uncertain_edge_ = complex_.edge_incomplete;
  }

  void run(const Box& region, std::span<const LatticePoint> around_pending) {
    const bool by_detail = how_.measure == kDetail;
    if (by_detail) find_details(region, around_pending);
    const CellValues value = by_detail ? std::move(detail_) : least_lambda();
    // As in pruned().
    const complex::CellFlags gone = complex::certainly_removed(
        {axis_.complex, value.vertex, value.edge, value.face, uncertain_vertex_, uncertain_edge_},
        how_.cutoff * (1 - 1e-12), context_, "prune");
    carry(axis_.measure(kLambda).value, gone, part_.link_lambda, part_.vertex_lambda);
    if (by_detail) carry(value, gone, part_.link_detail, part_.vertex_detail);
    complex_.dual.complex = std::move(axis_.complex);
    complex_.dual.face_sites = std::move(axis_.face_sites);
    part_.sites = std::move(axis_.sites);
    remove(part_, complex_, {gone.vertex, gone.edge},
           static_cast<std::uint64_t>(std::ranges::count(gone.face, std::uint8_t{1})));
  }

 private:
  // Before any face is gone.
  void set_contacts() {
    const dual::DualComplex& dual = complex_.dual;
    for (std::size_t f = 0; f < dual.face_sites.size(); ++f)
      for (const std::uint32_t v : dual.complex.corners(f)) {
        const auto sites = dual.sites_of(v);
        for (const std::uint32_t s : dual.face_sites[f]) {
          const auto place = std::ranges::lower_bound(sites, s) - sites.begin();
          part_.contact[dual.vertex_site_offsets[v] + static_cast<std::size_t>(place)] = 1;
        }
      }
  }

  // Details as far as they are known; others are not below those that are given, and their cells are uncertain.
  void find_details(const Box& region, std::span<const LatticePoint> around_pending) {
    detail_ = heights_of(axis_, carried_, known_, nullptr, context_);
    leave_out_incomplete(detail_.edge, complex_.edge_incomplete);
    leave_out_incomplete(detail_.vertex, complex_.vertex_incomplete);
    if (how_.surface) lower_faces();
    const TopCells cells(axis_.complex, detail_);
    SignificantParts parts(cells, axis_.complex.vertex_count, least_);
    parts.set_details();
    const Flags significant = vertices_of(cells, [&](std::uint32_t c) { return cells.value(c) >= least_; });
    CoverNeeds needs(axis_, least_, {significant, complex_.vertex_incomplete}, part_.pending, around_pending,
                           region, context_);
    part_.pending = needs.pending();
    const Flags touching = vertices_at(needs.thin_sites());
    settle(cells, parts, significant, touching);
    const Flags possible =
        vertices_of(cells, [&](std::uint32_t c) { return parts.is_above(c) && !settled_[component(cells, parts, c)]; });
    keep(needs.of_paths(possible, touching), needs.thin_sites(), touching);
    spread(carried_.edge_detail, carried_.vertex_detail, detail_);
    note_faces(cells, parts, significant);
  }
  static void leave_out_incomplete(std::vector<double>& height, const Flags& incomplete) {
    for (std::size_t i = 0; i < height.size(); ++i)
      if (incomplete[i]) height[i] = kNoTopCell;
  }
  void lower_faces() {
    if (known_.empty()) known_.assign(detail_.face.size(), -1);
    Flags looked_at(known_.size());
    for (std::size_t f = 0; f < known_.size(); ++f) looked_at[f] = known_[f] < 0 && detail_.face[f] >= least_;
    lower_to_surface(axis_, *how_.surface, least_, known_, detail_, context_);
    for (std::size_t f = 0; f < known_.size(); ++f)
      if (looked_at[f]) known_[f] = detail_.face[f];
  }
  template <class Which>
  Flags vertices_of(const TopCells& cells, const Which& which) const {
    Flags flags(axis_.complex.vertex_count, 0);
    for (std::uint32_t c = 0; c < cells.count(); ++c)
      if (cells.value(c) != kNoTopCell && which(c)) cells.for_corners(c, [&](std::uint32_t v) { flags[v] = 1; });
    return flags;
  }
  Flags vertices_at(const Flags& sites) const {
    Flags flags(axis_.complex.vertex_count, 0);
    for (std::uint32_t v = 0; v < flags.size(); ++v)
      flags[v] = std::ranges::any_of(complex_.dual.sites_of(v), [&](std::uint32_t s) { return sites[s] != 0; });
    return flags;
  }
  static std::uint32_t component(const TopCells& cells, SignificantParts& parts, std::uint32_t cell) {
    return parts.component_of(cells.first_corner(cell));
  }

  // Components are settled that are certainly not significant and that no uncovered site may need, or that certainly
  // are significant. The values of those of faces alone are kept.
  void settle(const TopCells& cells, SignificantParts& parts, const Flags& significant, const Flags& touching) {
    settled_.assign(parts.member_count(), 1);
    for (std::uint32_t v = 0; v < axis_.complex.vertex_count; ++v)
      if (const std::uint32_t c = parts.component_of(v); c != kNone && (complex_.vertex_incomplete[v] || touching[v]))
        settled_[c] = 0;
    for (std::uint32_t c = static_cast<std::uint32_t>(detail_.face.size()); c < cells.count(); ++c)
      if (parts.is_above(c)) settled_[component(cells, parts, c)] = 0;
    for (std::uint32_t v = 0; v < significant.size(); ++v)
      if (significant[v]) settled_[parts.component_of(v)] = 1;
    for (std::uint32_t c = 0; c < cells.count(); ++c)
      if (parts.is_above(c) && !settled_[component(cells, parts, c)]) make_uncertain(cells, c);
  }
  void make_uncertain(const TopCells& cells, std::uint32_t cell) {
    if (cell < detail_.face.size())
      for (const std::uint32_t e : axis_.complex.sides(cell)) uncertain_edge_[e] = 1;
    else if (cell < detail_.face.size() + detail_.edge.size())
      uncertain_edge_[cell - detail_.face.size()] = 1;
    else
      uncertain_vertex_[cells.first_corner(cell)] = 1;
  }
  void keep(const CoverNeeds::Cells& paths, const Flags& thin_sites, const Flags& touching) {
    for (std::size_t v = 0; v < touching.size(); ++v) uncertain_vertex_[v] |= paths.vertex[v] | touching[v];
    for (std::size_t e = 0; e < uncertain_edge_.size(); ++e) {
      const auto [a, b] = axis_.complex.edges[e];
      uncertain_edge_[e] |= paths.edge[e] | (touching[a] & touching[b]);
    }
    for (std::size_t f = 0; f < axis_.face_sites.size(); ++f) {
      const auto [a, b] = axis_.face_sites[f];
      if (thin_sites[a] || thin_sites[b])
        for (const std::uint32_t e : axis_.complex.sides(f)) uncertain_edge_[e] = 1;
    }
  }
  // Lambda, of cells that are not complete what is known to be below it.
  CellValues least_lambda() const {
    CellValues value = axis_.measure(kLambda).value;
    for (std::size_t e = 0; e < value.edge.size(); ++e)
      if (complex_.edge_incomplete[e]) value.edge[e] = 0;
    for (std::size_t v = 0; v < value.vertex.size(); ++v)
      if (complex_.vertex_incomplete[v]) value.vertex[v] = 0;
    spread(carried_.edge_lambda, carried_.vertex_lambda, value);
    return value;
  }
  void spread(const std::vector<double>& to_edges, const std::vector<double>& to_vertices, CellValues& value) const {
    const auto raise = [](std::vector<double>& values, const std::vector<double>& by) {
      for (std::size_t i = 0; i < by.size(); ++i) values[i] = std::max(values[i], by[i]);
    };
    raise(value.edge, to_edges);
    raise(value.vertex, to_vertices);
    spread_to_sides(axis_.complex, value);
    for (auto* values : {&value.vertex, &value.edge})
      for (double& v : *values) v = std::max(v, 0.0);
  }
  // What others need not find again: final details, and heights that took a look at the surface.
  void note_faces(const TopCells& cells, SignificantParts& parts, const Flags& significant) {
    std::vector<FaceValue> faces;
    auto before = part_.faces.begin();
    for (std::uint32_t f = 0; f < detail_.face.size(); ++f) {
      const auto& sites = axis_.face_sites[f];
      while (before != part_.faces.end() && before->sites < sites) ++before;
      const bool was_final = before != part_.faces.end() && before->sites == sites && before->final;
      const bool is_final =
          parts.is_above(f) && !significant[cells.first_corner(f)] && settled_[component(cells, parts, f)];
      if (is_final || was_final)
        faces.push_back({sites, detail_.face[f], true});
      else if (!known_.empty() && known_[f] >= 0)
        faces.push_back({sites, known_[f], false});
    }
    part_.faces = std::move(faces);
  }

  // What removed cells leave behind at others.
  void carry(const CellValues& value, const complex::CellFlags& gone, std::vector<double>& of_links,
             std::vector<double>& of_vertices) {
    for (std::size_t f = 0; f < gone.face.size(); ++f) {
      if (!gone.face[f]) continue;
      for (const std::uint32_t e : axis_.complex.sides(f)) {
        if (gone.edge[e]) continue;
        for (const std::uint32_t link : {complex_.link_of[e], complex_.twin_of[e]})
          of_links[link] = std::max(of_links[link], value.face[f]);
      }
    }
    for (std::size_t e = 0; e < gone.edge.size(); ++e) {
      if (!gone.edge[e]) continue;
      for (const std::uint32_t v : axis_.complex.edges[e]) of_vertices[v] = std::max(of_vertices[v], value.edge[e]);
    }
  }

  Part& part_;
  const PartPruning& how_;
  Context* context_;
  double least_;
  PartComplex complex_;
  Carried carried_;
  std::vector<double> known_;  // per face, or empty
  MedialAxis axis_;
  CellValues detail_;
  Flags settled_;  // per component, as SignificantParts numbers them
  Flags uncertain_vertex_, uncertain_edge_;
};

}  // namespace

void prune_part(Part& part, const dual::Hulls& hulls, const PartPruning& how, const Box& region,
                std::span<const LatticePoint> around_pending, Context* context) {
  PartPruner(part, hulls, how, context).run(region, around_pending);
}

}  // namespace quench::axis
