// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "verification/checks.h"

namespace quench::verification {

double cap_height(double lambda, double radius) {
  // The chord is seen from the centre at the angle 2 asin(lambda / radius).
  return radius > 0 ? lambda * std::tan(0.5 * std::asin(std::min(1.0, lambda / radius))) : 0;
}

namespace {

constexpr double kHeightRounding = 1e-9;

/// What the file says and what is found here, up to errors of positions.
class CapHeights {
 public:
  CapHeights(const Result& result, const Sites& sites, const VertexSites& vertex_sites)
      : result_(result),
        sites_(sites),
        vertex_sites_(vertex_sites),
        cell_(numbers_or_empty(result.data.cell_data, kCapHeight)),
        point_(numbers_or_empty(result.data.point_data, kCapHeight)) {
    if (cell_.empty()) return;
    of_edge_ = result.largest_of_polygons(cell_);
    for (std::size_t l = 0; l < result.line_edges.size(); ++l)
      if (const std::uint32_t e = result.line_edges[l]; result.edge_faces_count[e] == 0)
        of_edge_[e] = cell_[result.vert_vertices.size() + l];
  }

  bool of_cells() const { return !cell_.empty(); }
  bool of_points() const { return of_cells() && !point_.empty(); }

  // By the sites that all corners have: those found here, where they are wanted, else those that the file names.
  std::string wrong_face(std::size_t f, bool find_sites) const {
    std::array<Vec3, 2> site;
    if (find_sites) {
      const Ids common = face_sites(result_, vertex_sites_, f);
      if (common.size() != 2) return {};  // another check says so
      for (std::size_t i = 0; i < 2; ++i) site[i] = scaled(sites_.lattice()[common[i]]);
    } else {
      for (std::size_t i = 0; i < 2; ++i) site[i] = scaled(result_.face_sites[f][i]);
    }
    double radius = std::numeric_limits<double>::infinity();
    for (const std::uint32_t v : result_.complex.corners(f))
      radius = std::min(radius, (result_.scaled[v] - site[0]).norm());
    const double lambda = 0.5 * (site[0] - site[1]).norm() * result_.unit;
    return wrong(cell_[result_.first_polygon() + f], lambda, radius * result_.unit,
                 [&] { return result_.describe_face(f); });
  }
  // The largest of the polygons, or by its own lambda.
  std::string wrong_line(std::size_t l) const {
    const std::uint32_t e = result_.line_edges[l];
    const auto describe = [&] { return result_.describe_edge(e); };
    const std::size_t row = result_.vert_vertices.size() + l;
    if (result_.edge_faces_count[e] > 0) return unequal(cell_[row], of_edge_[e], describe);
    const auto [a, b] = result_.complex.edges[e];
    if (result_.cell_lambda.empty() || result_.radius.empty()) return {};
    return wrong(cell_[row], result_.cell_lambda[row], std::min(result_.radius[a], result_.radius[b]), describe);
  }
  std::string wrong_vertex(std::uint32_t v) const {
    const auto describe = [&] { return result_.describe_vertex(v); };
    const double written = point_[result_.rows[v]];
    if (result_.vertex_edges[v].empty()) {
      if (result_.vertex_lambda.empty() || result_.radius.empty()) return {};
      return wrong(written, result_.vertex_lambda[v], result_.radius[v], describe);
    }
    double largest = 0;
    for (const std::uint32_t e : result_.vertex_edges[v]) largest = std::max(largest, of_edge_[e]);
    return unequal(written, largest, describe);
  }
  std::string wrong_vertex_cell(std::size_t i) const {
    const std::uint32_t v = result_.vert_vertices[i];
    return unequal(cell_[i], point_[result_.rows[v]],
                   [&] { return "the vertex cell of " + result_.describe_vertex(v); });
  }

 private:
  Vec3 scaled(const LatticePoint& p) const {
    return {static_cast<double>(p[0] * result_.scale[0]), static_cast<double>(p[1] * result_.scale[1]),
            static_cast<double>(p[2] * result_.scale[2])};
  }
  template <class Describe>
  std::string wrong(double written, double lambda, double radius, const Describe& describe) const {
    const double off = radius * (1e-12 + result_.slack) + 4 * result_.rounding * result_.unit;
    const double rounding = kHeightRounding + 2 * result_.slack;
    // Where both points are opposite, a little less of the radius is much more of the height, up to lambda.
    const double least = cap_height(lambda, radius + off) * (1 - rounding),
                 most = cap_height(lambda, radius - std::min(off, radius)) * (1 + rounding);
    if (written >= least && written <= std::max(most, radius <= off ? lambda * (1 + rounding) : 0)) return {};
    return fmt::format("{} has cap height {:.9g}, lambda {:.9g} and radius {:.9g} give {:.9g}", describe(), written,
                       lambda, radius, cap_height(lambda, radius));
  }
  template <class Describe>
  std::string unequal(double written, double largest, const Describe& describe) const {
    if (std::abs(written - largest) <= kHeightRounding * largest) return {};
    if (result_.by == kCapHeight && written > largest) return {};  // a cell that is gone may have had more
    return fmt::format("{} has cap height {:.9g}, the largest of the cells around is {:.9g}", describe(), written,
                       largest);
  }

  const Result& result_;
  const Sites& sites_;
  const VertexSites& vertex_sites_;
  std::vector<double> cell_, point_;  // as in the file
  std::vector<double> of_edge_;       // of its polygons, else its own
};

}  // namespace

Check check_cap_heights(const Result& result, const Sites& sites, VertexSites& vertex_sites, std::size_t samples,
                        Context* context) {
  const std::string name = "cap heights";
  if (result.stage != "core")
    return not_checked(
        name, fmt::format("they are those of {} cores, which the file does not claim", pixel_or_voxel(result)));
  CapHeights heights(result, sites, vertex_sites);
  if (!heights.of_cells()) return not_checked(name, "no cell array 'cap_height'");
  const std::size_t faces = result.complex.face_count();
  const std::vector<std::uint32_t> sampled = sample(faces, samples);
  std::vector<std::uint32_t> corners;
  for (const std::uint32_t f : sampled)
    corners.insert(corners.end(), result.complex.corners(f).begin(), result.complex.corners(f).end());
  vertex_sites.prepare(corners, context);
  const auto first_wrong = [&](std::size_t count, const auto& wrong) -> std::string {
    const std::size_t bad =
        first_failure(count, context, "verify: cap heights", [&](std::size_t i) { return wrong(i).empty(); });
    return bad < count ? wrong(bad) : std::string{};
  };
  std::string wrong = first_wrong(sampled.size(), [&](std::size_t i) { return heights.wrong_face(sampled[i], true); });
  if (wrong.empty() && !result.face_sites.empty())
    wrong = first_wrong(faces, [&](std::size_t f) { return heights.wrong_face(f, false); });
  if (wrong.empty())
    wrong = first_wrong(result.line_edges.size(), [&](std::size_t l) { return heights.wrong_line(l); });
  if (wrong.empty() && heights.of_points())
    wrong = first_wrong(result.rows.size(),
                        [&](std::size_t v) { return heights.wrong_vertex(static_cast<std::uint32_t>(v)); });
  if (wrong.empty() && heights.of_points())
    wrong = first_wrong(result.vert_vertices.size(), [&](std::size_t i) { return heights.wrong_vertex_cell(i); });
  if (!wrong.empty()) return failed(name, std::move(wrong));
  Check check{name, true, {}, {}};
  cover(check, "cell cap_height");
  if (heights.of_points()) cover(check, "point cap_height");
  check.detail =
      result.plane ? fmt::format("{} lines as their lambda and the smaller radius of their ends give them",
                                 result.line_edges.size())
                   : fmt::format("{} of {} polygons as the sites found here give them, {} as the sites of the file do",
                                 sampled.size(), faces, result.face_sites.empty() ? "none" : "all");
  return check;
}

}  // namespace quench::verification
