// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <utility>

#include "burning/burn_pass.h"
#include "burning/polygon_view.h"
#include "quench/burn.h"

namespace quench::testing_burn {

/// How fire crosses a polygon. By nodes, along straight arcs from node to node only, times are an upper bound that
/// converges with the spacing (Yan 2018, Thm. 3.4.1), and on the same nodes they equal the definition, so that labels,
/// links and queue can be tested exactly.
enum class Propagation { nodes, segments, windows };

inline void propagate_by_nodes(const burning::BurnDomain& domain, burning::Labels& labels) {
  using namespace burning;
  const auto burn_block = [&](Labels::Worker& worker) {
    std::uint32_t state = 0;
    for (bool again = false; labels.next(worker, state, again);) {
      const double t = labels.time(state);
      for_each_place(domain, state, [&](const PolygonView& view, const Place& place) {
        const Point here = view.at(place.side, place.k);
        for_each_edge_arc(view, place, [&](std::uint32_t i, std::uint32_t k) {
          labels.lower(worker, view.state(i, k), t + view.side(i).spacing(), view.face, kUnknownSource);
        });
        for_each_far_side(view, place, [&](std::uint32_t i, std::uint32_t first, std::uint32_t last) {
          view.nodes(i, first, last, [&](std::uint32_t k, std::uint32_t target) {
            labels.lower(worker, target, t + distance(view.at(i, k), here), view.face, kUnknownSource);
          });
        });
      });
    }
  };
  labels.burn(burn_block, [](std::uint64_t) {});
}

/// burn() by either propagation; by nodes `options.omega` must be given.
inline Burning burn_by(Propagation by, const CellComplex& complex, std::span<const Vec3> points,
                       std::span<const double> radius, const BurnOptions& options,
                       const burning::BlockSchedule& schedule = {}) {
  using namespace burning;
  if (by != Propagation::nodes) {
    BurnOptions own = options;
    own.propagation = by == Propagation::windows ? quench::Propagation::windows : quench::Propagation::segments;
    return burn_scheduled(complex, points, radius, own, schedule, nullptr);
  }
  auto sectors = std::make_shared<BurnedSectors>();
  sectors->network = make_network(complex, points, options.omega);
  const BurnDomain domain{complex, points, radius, sectors->network, options.radius};
  Labels labels(domain, schedule, 0);
  propagate_by_nodes(domain, labels);
  return finish_burning(domain, labels.release(), std::move(sectors), options, nullptr);
}

}  // namespace quench::testing_burn
