// SPDX-License-Identifier: Apache-2.0
// Every boundary vertex lies within max(2 t, the diagonal of a voxel or pixel) of the balls of the pruning for detail
// t.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "verification/ball_search.h"
#include "verification/checks.h"

namespace quench::verification {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kReachRounding = 2e-9;

// Per vertex the largest detail_level of the cells around; infinite without that array.
std::vector<double> detail_levels(const Result& result) {
  const std::vector<double> level = numbers_or_empty(result.data.cell_data, "detail_level");
  if (level.empty()) return std::vector<double>(result.rows.size(), kInfinite);
  std::vector<double> of_vertex(result.rows.size(), 0);
  std::size_t row = 0;
  const auto raise = [&](std::uint32_t v) { of_vertex[v] = std::max(of_vertex[v], level[row]); };
  for (const std::uint32_t v : result.vert_vertices) raise(v), ++row;
  for (const std::uint32_t e : result.line_edges) {
    for (const std::uint32_t v : result.complex.edges[e]) raise(v);
    ++row;
  }
  for (std::size_t f = 0; f < result.complex.face_count(); ++f, ++row)
    for (const std::uint32_t v : result.complex.corners(f)) raise(v);
  return of_vertex;
}

BallSearch balls_of(const Result& result) {
  const std::vector<double> level = detail_levels(result);
  std::vector<LevelBall> balls;
  for (std::uint32_t v = 0; v < result.rows.size(); ++v)
    if (const double r = result.radius[v]; r >= 0 && r < kInfinite)  // else another check says so
      balls.push_back({result.voxel_point(v), r, level[v]});
  return BallSearch(std::move(balls));
}

Vec3 position(const Result& result, const Sites& sites, std::size_t s) {
  const LatticePoint& q = sites.lattice()[s];
  return result.shape.grid().world({static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2])});
}

struct Farthest {
  double away = 0;
  std::size_t site = 0;
};

/// The boundary vertex that is farthest outside the balls of some level or more, the first of several; only those
/// farther than `from` count, others are 0.
Farthest farthest_of(const Result& result, const Sites& sites, const BallSearch& balls, double level, double from,
                     Context* context) {
  constexpr std::size_t kChunk = 4096;
  const std::size_t count = sites.lattice().size(), chunks = (count + kChunk - 1) / kChunk;
  std::vector<Farthest> found(chunks);
  for_indices(chunks, context, "verify: coverage", [&](std::size_t chunk) {
    Farthest farthest{from, 0};
    bool any = false;
    std::uint32_t last = 0;  // what covered the vertex before mostly covers this one
    for (std::size_t s = chunk * kChunk; s < std::min(count, (chunk + 1) * kChunk); ++s) {
      const Vec3 p = position(result, sites, s);
      double away = kInfinite;
      if (balls.size() > 0 && balls.level(last) >= level) away = balls.outside(last, p);
      if (away <= farthest.away) continue;
      balls.find(p, level, farthest.away, away, last);
      if (away > farthest.away) farthest = {away, s}, any = true;
    }
    if (any) found[chunk] = farthest;
  });
  Farthest farthest;
  for (const Farthest& f : found)
    if (f.away > farthest.away) farthest = f;
  return farthest;
}

// Of a file with the cells below the threshold, too: it has the threshold that was chosen only.
bool says_it_is_whole(const Result& result) {
  const std::vector<double> pruned_at = numbers_or_empty(result.data.field_data, kDetail),
                            chosen = numbers_or_empty(result.data.field_data, "detail_chosen");
  return !pruned_at.empty() && pruned_at[0] == 0 && !chosen.empty() && chosen[0] > 0;
}

std::string describe_site(const Result& result, const Sites& sites, std::size_t s) {
  const Vec3 p = position(result, sites, s);
  return result.plane ? fmt::format("the boundary vertex at ({:.9g}, {:.9g})", p[0], p[1])
                      : fmt::format("the boundary vertex at ({:.9g}, {:.9g}, {:.9g})", p[0], p[1], p[2]);
}

// Levels give the prunings for larger details: what was chosen, where nothing was pruned yet, and some more.
std::vector<double> larger_details(const Result& result) {
  if (!find_array(result.data.cell_data, "detail_level")) return {};
  std::vector<double> details = numbers_or_empty(result.data.field_data, "detail_chosen");
  for (const double factor : {1.0, 2.0, 4.0, 8.0}) {
    const double detail = factor * result.auto_detail;
    if (details.empty() || std::abs(details[0] - detail) > kReachRounding * detail) details.push_back(detail);
  }
  std::erase_if(details, [&](double d) { return !(d > result.detail && d < kInfiniteLevelInFiles); });
  return details;
}

}  // namespace

Check check_coverage(const Result& result, const Sites& sites, Context* context) {
  const std::string name = "coverage";
  if (result.radius.empty()) return not_checked(name, "no array 'radius'");
  const BallSearch balls = balls_of(result);
  const double automatic = result.auto_detail, unsure = 8 * result.rounding * result.unit;
  const auto promised = [&](double detail) { return 2 * std::max(detail, automatic); };
  const auto too_far = [&](const Farthest& farthest, double detail) {
    return fmt::format("{} is {:.9g} from the balls of detail {:.9g}, which is to cover it within {:.9g}",
                       describe_site(result, sites, farthest.site), farthest.away, detail, promised(detail));
  };

  const Farthest all = farthest_of(result, sites, balls, 0, 1e-9 * automatic, context);
  if (!(all.away <= promised(result.detail) * (1 + kReachRounding) + unsure))
    return failed(name, too_far(all, result.detail));
  Check check{name, true, {}, {}};
  if (const std::vector<double> claimed = numbers_or_empty(result.data.field_data, "coverage"); !claimed.empty()) {
    if (says_it_is_whole(result))
      return failed(name, "there is a field array 'coverage', but the file says that nothing was pruned");
    if (!(std::abs(claimed[0] - all.away) <= 1e-6 * std::max(all.away, automatic) + unsure))
      return failed(name, fmt::format("the field array 'coverage' is {:.9g}, {} is {:.9g} from the balls", claimed[0],
                                      describe_site(result, sites, all.site), all.away));
    cover(check, "field coverage");
  }
  std::vector<double> checked;
  for (const double detail : larger_details(result)) {
    const double limit = promised(detail) * (1 + kReachRounding) + unsure;
    const Farthest farthest = farthest_of(result, sites, balls, detail * (1 - 1e-12), limit, context);
    if (farthest.away > limit) return failed(name, too_far(farthest, detail));
    checked.push_back(detail);
  }
  check.detail = fmt::format("all {} boundary vertices within {:.9g} of the balls, {:.9g} is promised",
                             sites.lattice().size(), all.away, promised(result.detail));
  if (!checked.empty())
    check.detail += fmt::format("; within what is promised at details {:.6g}", fmt::join(checked, ", "));
  return check;
}

}  // namespace quench::verification
