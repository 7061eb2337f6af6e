// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "parts/border_lines.h"
#include "quench/parts.h"

namespace quench::parts {

/// Triangles of sheets while they are split, collapsed and flipped. All operations leave the complex homeomorphic to
/// what it was, part by part; those that would not are refused.
class LiveSheets {
 public:
  enum class Kind : char { inner, border, fixed };
  LiveSheets(const SheetMesh& mesh, const BorderLines& lines);

  /// Halves an edge: a border in the middle of its way along the line, else at `place`. The new vertex.
  std::uint32_t split(std::uint32_t a, std::uint32_t b, const SheetPoint& place);
  /// Makes `gone` and `kept` one vertex along their edge, and takes away what has no area then: at the place of `kept`
  /// or, where both may move, at `place` (of a border: at `along` on its line). False, and nothing is done, where
  /// `gone` may not go there, where the topology would change, where a triangle would turn over, or where an edge would
  /// become longer than `longest`.
  bool collapse(std::uint32_t gone, std::uint32_t kept, double longest);
  bool collapse(std::uint32_t gone, std::uint32_t kept, double longest, const SheetPoint& place, double along);
  /// Turns an edge between two triangles, where they are nearly in a plane and that makes the larger of its opposite
  /// angles smaller.
  bool flip(std::uint32_t a, std::uint32_t b);
  /// Moves a vertex that is not fixed, where no triangle turns over or becomes much worse. `along`: its place on its
  /// line, of a border.
  bool move(std::uint32_t v, const SheetPoint& to, double along = 0);

  Kind kind(std::uint32_t v) const { return kind_[v]; }
  bool alive(std::uint32_t v) const { return !triangles_at_[v].empty(); }
  std::uint32_t vertices() const { return static_cast<std::uint32_t>(points_.size()); }
  const SheetPoint& point(std::uint32_t v) const { return points_[v]; }
  const Vec3& at(std::uint32_t v) const { return points_[v].point; }
  double length(std::uint32_t a, std::uint32_t b) const { return (at(a) - at(b)).norm(); }
  bool adjacent(std::uint32_t a, std::uint32_t b) const;
  std::int32_t sheet_of(std::uint32_t v) const { return sheet_[triangles_at_[v].front()]; }  ///< of an inner vertex
  const std::vector<std::uint32_t>& triangles_at(std::uint32_t v) const { return triangles_at_[v]; }
  const std::array<std::uint32_t, 3>& corners(std::uint32_t t) const { return triangles_[t]; }

  /// Of a border vertex: its line, its place, and the places of its neighbours on it.
  struct OnLine {
    std::int32_t line = -1;
    double at = 0, before = 0, behind = 0;
  };
  OnLine on_line(std::uint32_t v) const;
  /// Of the middle of a border edge: its line and place.
  OnLine middle(std::uint32_t a, std::uint32_t b) const;

  struct LiveEdge {
    double length;
    std::uint32_t a, b;
  };
  /// All edges whose length is between two bounds, the shortest first.
  std::vector<LiveEdge> edges(double least, double most) const;

  SheetMesh mesh(bool with_erosion) const;

 private:
  // A border edge as its end has it: the other end, the line, the place of the own end on the line, and of the other.
  struct Link {
    std::uint32_t to;
    std::int32_t line;
    double at, to_at;
  };
  const Link* link(std::uint32_t a, std::uint32_t b) const;
  void place_on_line(std::uint32_t v, double along);
  bool has_edge(std::uint32_t a, std::uint32_t b) const;
  bool has_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  void find_triangles(std::uint32_t a, std::uint32_t b, std::vector<std::uint32_t>& found) const;
  std::uint32_t third(std::uint32_t t, std::uint32_t a, std::uint32_t b) const;
  Vec3 area(std::uint32_t t) const;
  Vec3 area_with(std::uint32_t t, std::uint32_t v, const Vec3& to) const;
  double quality_with(std::uint32_t t, std::uint32_t v, const Vec3& to) const;
  bool may_move(std::uint32_t v, std::uint32_t but, const Vec3& to, double longest) const;
  bool keeps_topology(std::uint32_t gone, std::uint32_t kept, bool border);
  void mark(std::uint32_t around);
  void detach(std::uint32_t t, std::uint32_t v);

  const BorderLines& lines_;
  std::vector<SheetPoint> points_;
  std::vector<Kind> kind_;
  std::vector<std::vector<std::uint32_t>> triangles_at_;
  std::vector<std::vector<Link>> links_;                 // per vertex: of inner ones none
  std::vector<std::array<std::uint32_t, 3>> triangles_;  // of those that are gone the first corner is kNone
  std::vector<std::int32_t> sheet_;
  std::vector<std::uint32_t> mark_, found_, others_;
  std::uint32_t marked_ = 0;
};

}  // namespace quench::parts
