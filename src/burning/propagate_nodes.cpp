// SPDX-License-Identifier: Apache-2.0
#include "burning/fire.h"
#include "burning/polygon_view.h"

namespace quench::burning {

void propagate_by_nodes(const Site& site, Labels& labels, Context* context) {
  std::uint32_t state = 0;
  bool again = false;
  const double states = site.network.state_count();
  for (std::uint64_t burned = 0; labels.next(state, again);) {
    if (burned++ % 4096 == 0) checkpoint(context, "burn", std::min(0.8, 0.6 * static_cast<double>(burned) / states));
    const double t = labels.time(state);
    for_each_place(site, state, [&](const PolygonView& view, const Place& place) {
      const Point here = view.at(place.side, place.k);
      for_each_edge_arc(view, place, [&](std::uint32_t i, std::uint32_t k) {
        labels.lower(view.state(i, k), t + view.side(i).spacing(), view.face, kUnknownSource);
      });
      for_each_far_side(view, place, [&](std::uint32_t i, std::uint32_t first, std::uint32_t last) {
        view.nodes(i, first, last, [&](std::uint32_t k, std::uint32_t target) {
          if (labels.time(target) > t)
            labels.lower(target, t + distance(view.at(i, k), here), view.face, kUnknownSource);
        });
      });
    });
  }
}

}  // namespace quench::burning
