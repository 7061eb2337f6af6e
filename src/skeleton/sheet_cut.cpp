// SPDX-License-Identifier: Apache-2.0
#include "skeleton/sheet_cut.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "base/constants.h"
#include "base/csr.h"
#include "base/parallel.h"
#include "base/rounded_down.h"

namespace quench::skeleton {
namespace {

using base::kNever;

// Cuts are at these shares of an edge, not nearer to its ends than the second: sheets cut an edge at one place, or at
// places that are apart.
constexpr double kCutStep = 1.0 / 1024, kShortestPiece = 1.0 / 64;

// Sheets whose radii rise so differently are not one.
constexpr double kBend = 0.35;
// A tree of the fire belongs to a sheet where its erosion thickness is this much of the radius.
constexpr double kWide = 0.5;
// Or where it comes to this share of theta2.
constexpr double kNearly = 0.8;

class SheetCutter {
 public:
  SheetCutter(const SkeletonFamily& family, double theta2, double rims, double minor_curve)
      : family_(family), k_(family.refined), theta2_(theta2), minor_curve_(minor_curve) {
    find_faces(rims);
  }

  Sheets run(bool in_parts) {
    const CellComplex& k = k_.complex;
    Member& member = sheets_.member;
    member.vertex.resize(k.vertex_count);
    member.edge.resize(k.edges.size());
    base::for_indices(k.vertex_count,
                      [&](std::size_t v) { member.vertex[v] = family_.vertex_sheet_level[v] >= theta2_; });
    base::for_indices(k.edges.size(), [&](std::size_t e) { member.edge[e] = family_.edge_sheet_level[e] >= theta2_; });
    member.face.assign(k.face_count(), Member::kNo);
    sheets_.faces_at.assign(k.edges.size(), base::Cofaces{});
    for (const std::uint32_t f : present_) {
      member.face[f] = Member::kWhole;
      for (const std::uint32_t e : k.sides(f)) {
        member.edge[e] = Member::kWhole;
        sheets_.faces_at[e].add(f);
      }
      for (const std::uint32_t v : k.corners(f)) member.vertex[v] = 1;
    }
    if (in_parts) {
      split_edges();
      collapse();
    }
    return std::move(sheets_);
  }

 private:
  const float* levels_of(std::uint32_t f) const {
    return family_.corner_sheet_level.data() + k_.complex.face_offsets[f];
  }
  bool above(float level) const { return level >= cut_at_; }

  // `present_` is a complex with the topology of K: with the curves, all faces above a level in some of the parts that
  // share no edge off the curves. `wanted_` is what should be left of it.
  void find_faces(double rims) {
    const auto faces = static_cast<std::uint32_t>(k_.complex.face_count());
    cut_at_ = base::rounded_down(theta2_);
    for (std::uint32_t f = 0; f < faces; ++f)
      if (family_.face_sheet_level[f] >= theta2_) wanted_.push_back(f);
    present_ = wanted_;
    if (rims >= theta2_ || wanted_.empty()) return;
    cut_at_ = base::rounded_down(rims);
    at_ = base::Csr<std::uint32_t>::group(k_.complex.edges.size(), [&](const auto& emit) {
      for (std::uint32_t f = 0; f < faces; ++f)
        if (family_.face_sheet_level[f] >= cut_at_)
          for (const std::uint32_t e : k_.complex.sides(f)) emit(e, f);
    });
    find_slopes();
    find_trees();
    grow_wanted();
    grow_present();
  }
  bool burns(std::uint32_t f) const { return family_.face_sheet_level[f] < kNever; }

  // The trees of the fire between seams: faces that are joined over edges of two, off the curves.
  void find_trees() {
    tree_.assign(k_.complex.face_count(), kNone);
    std::vector<std::uint32_t> reached;
    for (std::uint32_t first = 0; first < tree_.size(); ++first) {
      if (tree_[first] != kNone || family_.face_sheet_level[first] < cut_at_ || !burns(first)) continue;
      const auto tree = static_cast<std::uint32_t>(tree_faces_.size());
      reached.assign(1, first);
      tree_[first] = tree;
      bool dies_out = true, carries = false;
      for (std::size_t i = 0; i < reached.size(); ++i) {
        carries |= carries_on(reached[i]);
        for (const std::uint32_t e : k_.complex.sides(reached[i])) {
          if (k_.curve_edge[e]) {
            dies_out &= family_.thickness_of(e) < minor_curve_;
            continue;
          }
          if (at_[e].size() != 2 || bends(at_[e][0], at_[e][1])) continue;
          for (const std::uint32_t f : at_[e])
            if (tree_[f] == kNone) {
              tree_[f] = tree;
              reached.push_back(f);
            }
        }
      }
      tree_faces_.push_back(reached);
      spreads_.push_back(dies_out || carries);
    }
  }
  // About as wide as thick: a sheet, not the band around the curve of a limb. Or nearly above theta2, so that a sheet
  // whose erosion thickness is about theta2 all along goes or stays as a whole.
  bool carries_on(std::uint32_t f) const {
    const auto corners = k_.complex.corners(f);
    for (std::size_t i = 0; i < corners.size(); ++i)
      if (levels_of(f)[i] >= std::min(kWide * k_.radius[corners[i]], kNearly * theta2_)) return true;
    return false;
  }
  bool bends(std::uint32_t f, std::uint32_t g) const {
    return std::abs(slope_[k_.polygon_of[f]] - slope_[k_.polygon_of[g]]) > kBend;
  }
  // How the radius rises on each polygon, 0 to 1: the cosine of half the angle between its touching points.
  void find_slopes() {
    const std::size_t faces = k_.complex.face_count();
    slope_.assign(faces == 0 ? 0 : *std::max_element(k_.polygon_of.begin(), k_.polygon_of.end()) + std::size_t{1}, 0);
    base::for_indices(faces, [&](std::size_t f) {
      if (f > 0 && k_.polygon_of[f - 1] == k_.polygon_of[f]) return;
      std::size_t end = f;
      while (end < faces && k_.polygon_of[end] == k_.polygon_of[f]) ++end;
      slope_[k_.polygon_of[f]] = slope(f, end);
    });
  }
  double slope(std::size_t begin, std::size_t end) const {
    const auto each = [&](const auto& visit) {
      for (std::size_t f = begin; f < end; ++f)
        if (family_.face_sheet_level[f] >= cut_at_)
          for (const std::uint32_t v : k_.complex.corners(f))
            if (v < k_.nodes) visit(v);
    };
    Vec3 middle = Vec3::Zero();
    double radius = 0, count = 0;
    each([&](std::uint32_t v) {
      middle += k_.points[v];
      radius += k_.radius[v];
      ++count;
    });
    if (count == 0) return 0;
    middle /= count;
    radius /= count;
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    Vec3 rise = Vec3::Zero();
    each([&](std::uint32_t v) {
      const Vec3 d = k_.points[v] - middle;
      spread += d * d.transpose();
      rise += d * (k_.radius[v] - radius);
    });
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
    Vec3 gradient = Vec3::Zero();
    for (int i = 1; i < 3; ++i)  // the first axis is the normal
      if (axes.eigenvalues()[i] > 1e-3 * axes.eigenvalues()[2])
        gradient += axes.eigenvectors().col(i) * (axes.eigenvectors().col(i).dot(rise) / axes.eigenvalues()[i]);
    return std::min(1.0, gradient.norm());
  }
  // Trees that reach what theta2 leaves, and between them those that die out before they come to a curve.
  void grow_wanted() {
    std::vector<char> grown(tree_faces_.size(), 0);
    std::vector<std::uint32_t> trees;
    const auto grow = [&](std::uint32_t f) {
      if (tree_[f] != kNone && !std::exchange(grown[tree_[f]], 1)) trees.push_back(tree_[f]);
    };
    for (const std::uint32_t f : wanted_) grow(f);
    std::erase_if(wanted_, [&](std::uint32_t f) { return burns(f); });
    for (std::size_t i = 0; i < trees.size(); ++i)
      for (const std::uint32_t face : tree_faces_[trees[i]]) {
        wanted_.push_back(face);
        for (const std::uint32_t e : k_.complex.sides(face))
          if (k_.curve_edge[e])
            for (const std::uint32_t f : at_[e])
              if (tree_[f] != kNone && spreads_[tree_[f]]) grow(f);
      }
  }
  // All faces above the cut in the parts of K off the curves in which some are wanted.
  void grow_present() {
    std::vector<char> reached(k_.complex.face_count(), 0);
    for (const std::uint32_t f : wanted_) reached[f] = 1;
    present_ = wanted_;
    for (std::size_t i = 0; i < present_.size(); ++i) {
      if (!burns(present_[i])) continue;
      for (const std::uint32_t e : k_.complex.sides(present_[i])) {
        if (k_.curve_edge[e]) continue;
        for (const std::uint32_t f : at_[e])
          if (!std::exchange(reached[f], 1)) present_.push_back(f);
      }
    }
  }

  // Where the sides of a face cross the cut: `in` is on the side after which corners in order are above it.
  struct Crossings {
    std::size_t in = 0, out = 0;  // sides of the face
    bool any_above = false, any_below = false;
  };
  Crossings crossings_of(std::uint32_t f) const {
    const float* const level = levels_of(f);
    const std::size_t n = k_.complex.sides(f).size();
    Crossings found;
    for (std::size_t i = 0; i < n; ++i) {
      const bool here = above(level[i]), next = above(level[i + 1 == n ? 0 : i + 1]);
      (here ? found.any_above : found.any_below) = true;
      if (here && !next) found.out = i;
      if (!here && next) found.in = i;
    }
    return found;
  }
  double cut_on(std::uint32_t f, std::size_t side) const {
    const std::size_t n = k_.complex.sides(f).size();
    double from = levels_of(f)[side], to = levels_of(f)[side + 1 == n ? 0 : side + 1];
    if (!forward(f, side)) std::swap(from, to);
    const double along = (static_cast<double>(cut_at_) - from) / (to - from);
    return std::clamp(std::round(along / kCutStep) * kCutStep, kShortestPiece, 1 - kShortestPiece);
  }
  bool forward(std::uint32_t f, std::size_t side) const {
    return k_.complex.edges[k_.complex.sides(f)[side]][0] == k_.complex.corners(f)[side];
  }

  void split_edges() {
    SheetCut& cut = sheets_.member.cut;
    struct Crossing {
      std::uint32_t edge;
      double along;
      std::uint32_t chord;
      bool in;
    };
    std::vector<Crossing> crossings;
    std::sort(wanted_.begin(), wanted_.end());
    for (const std::uint32_t f : wanted_) {
      const Crossings found = crossings_of(f);
      if (!found.any_above || !found.any_below) continue;
      const auto chord = static_cast<std::uint32_t>(cut.chords.size());
      cut.chords.push_back({f, 0, 0});
      const auto sides = k_.complex.sides(f);
      crossings.push_back({sides[found.in], cut_on(f, found.in), chord, true});
      crossings.push_back({sides[found.out], cut_on(f, found.out), chord, false});
    }
    std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
      return std::tie(a.edge, a.along, a.chord) < std::tie(b.edge, b.along, b.chord);
    });
    const std::uint32_t first_point = k_.complex.vertex_count;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      const Crossing& c = crossings[i];
      if (i == 0 || c.edge != crossings[i - 1].edge || c.along != crossings[i - 1].along)
        cut.points.push_back({c.edge, c.along});
      SheetCut::Chord& chord = cut.chords[c.chord];
      (c.in ? chord.in : chord.out) = first_point + static_cast<std::uint32_t>(cut.points.size()) - 1;
    }
    add_pieces();
  }

  void add_pieces() {
    Member& member = sheets_.member;
    SheetCut& cut = member.cut;
    for (std::size_t i = 0; i < cut.points.size(); ++i) {
      const std::uint32_t e = cut.points[i].edge, point = k_.complex.vertex_count + static_cast<std::uint32_t>(i);
      if (i == 0 || cut.points[i - 1].edge != e) {
        cut.splits.push_back({e, static_cast<std::uint32_t>(cut.pieces.size()), 1});
        cut.pieces.push_back({e, k_.complex.edges[e]});
      }
      const std::uint32_t last = cut.pieces.back().ends[1];
      cut.pieces.back().ends[1] = point;
      cut.pieces.push_back({e, {point, last}});
      ++cut.splits.back().count;
    }
    member.vertex.resize(k_.complex.vertex_count + cut.points.size(), 1);
    member.edge.resize(k_.complex.edges.size() + cut.pieces.size(), Member::kWhole);
    sheets_.faces_at.resize(member.edge.size(), base::Cofaces{});
    for (const SheetCut::Split& split : cut.splits) {
      member.edge[split.edge] = Member::kInPart;
      for (std::uint32_t p = 0; p < split.count; ++p) sheets_.faces_at[piece(split, p)] = sheets_.faces_at[split.edge];
    }
  }
  std::uint32_t piece(const SheetCut::Split& split, std::uint32_t p) const {
    return static_cast<std::uint32_t>(k_.complex.edges.size()) + split.first + p;
  }

  // What of a face is not wanted is a cell. Its sides and pieces of sides that are not sides of what stays of the face:
  template <class Visit>
  void each_outer_side(std::uint32_t f, bool whole, const Visit& visit) const {
    const Member& member = sheets_.member;
    const auto sides = k_.complex.sides(f);
    const float* const level = levels_of(f);
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const std::uint32_t e = sides[i];
      const bool from = whole || !above(level[i]), to = whole || !above(level[i + 1 == sides.size() ? 0 : i + 1]);
      if (!from && !to) continue;
      if (member.edge[e] != Member::kInPart) {
        visit(e);
        continue;
      }
      const SheetCut::Split& split = member.cut.split_of(e);
      // In the order of the edge: from its first end to the cut, or from there to the second one.
      const bool first = forward(f, i) ? from : to, second = forward(f, i) ? to : from;
      bool outside = first;
      for (std::uint32_t p = 0; p < split.count; ++p) {
        if (outside) visit(piece(split, p));
        const std::uint32_t end = member.cut.pieces[split.first + p].ends[1];
        if (first != second && is_cut_of(f, end)) outside = second;
      }
    }
  }
  bool is_cut_of(std::uint32_t f, std::uint32_t point) const {
    const SheetCut::Chord& chord = sheets_.member.cut.chord_of(f);
    return point == chord.in || point == chord.out;
  }

  // Takes off what is not wanted, by pairs of such a cell and a side that is free, in any order: which cells can go
  // does not depend on it.
  void collapse() {
    Member& member = sheets_.member;
    enum : char { kStays, kPart, kAll };
    std::vector<char> unwanted(member.face.size(), kStays);
    std::vector<char> is_wanted(member.face.size(), 0);
    for (const std::uint32_t f : wanted_) is_wanted[f] = 1;
    std::vector<std::uint32_t> to_try;
    for (const std::uint32_t f : present_) {
      const Crossings found = crossings_of(f);
      unwanted[f] = !is_wanted[f] || !found.any_above ? kAll : found.any_below ? kPart : kStays;
      if (unwanted[f] != kStays) to_try.push_back(f);
    }
    while (!to_try.empty()) {
      const std::uint32_t f = to_try.back();
      to_try.pop_back();
      if (unwanted[f] == kStays) continue;
      const bool whole = unwanted[f] == kAll;
      std::uint32_t free = kNone;
      each_outer_side(f, whole, [&](std::uint32_t e) {
        if (free == kNone && !is_curve(e) && sheets_.faces_at[e].single()) free = e;
      });
      if (free == kNone) continue;
      unwanted[f] = kStays;
      member.edge[free] = Member::kNo;
      member.face[f] = whole ? Member::kNo : Member::kInPart;
      each_outer_side(f, whole, [&](std::uint32_t e) {
        base::Cofaces& at = sheets_.faces_at[e];
        at.remove(f);
        if (at.single() && !is_curve(e) && unwanted[at.only()] != kStays) to_try.push_back(at.only());
      });
    }
  }
  bool is_curve(std::uint32_t e) const { return k_.curve_edge[edge_in_k(k_, sheets_.member, e)]; }

  const SkeletonFamily& family_;
  const RefinedAxis& k_;
  double theta2_;
  double minor_curve_;
  std::vector<double> slope_;  // per polygon
  float cut_at_ = 0;
  base::Csr<std::uint32_t> at_;      // per edge: the faces above the cut
  std::vector<std::uint32_t> tree_;  // per face, or kNone
  std::vector<std::vector<std::uint32_t>> tree_faces_;
  std::vector<char> spreads_;  // per tree: it comes to no curve but minor ones, or carries on a sheet
  std::vector<std::uint32_t> wanted_, present_;
  Sheets sheets_;
};

}  // namespace

Sheets sheets_above(const SkeletonFamily& family, double theta2, double rims, double minor_curve) {
  return SheetCutter(family, theta2, rims, minor_curve).run(true);
}

Sheets whole_sheets_above(const SkeletonFamily& family, double theta2) {
  return SheetCutter(family, theta2, kNever, 0).run(false);
}

}  // namespace quench::skeleton
