// SPDX-License-Identifier: Apache-2.0
#include "burn/fire.h"
#include "burn/places.h"

namespace quench::burning {

void propagate_by_nodes(const Site& site, Labels& labels, Context* context) {
  PolygonViews views(site);
  std::uint32_t state = 0;
  bool again = false;
  const double states = site.network.state_count();
  for (std::uint64_t burned = 0; labels.next(state, again);) {
    if (burned++ % 4096 == 0) checkpoint(context, "burn", std::min(0.99, 0.8 * static_cast<double>(burned) / states));
    const double t = labels.time(state);
    for_each_place(site, state, views, [&](const PolygonView& view, const Place& place) {
      const Vec3 from = view.sides[place.side].at(place.k);
      for_each_arc(view, place, [&](const Side& side, std::uint32_t k) {
        labels.lower(side.state(k), t + (side.at(k) - from).norm(), view.face, kUnknownSource);
      });
    });
  }
}

}  // namespace quench::burning
