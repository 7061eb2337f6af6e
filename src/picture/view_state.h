// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "quench/page.h"

namespace quench::picture {

/// What the page shows first, as viewer/src/state.ts finds it. Throws Error(usage) where the page does not have it.
struct ViewState {
  std::string layer;     ///< empty: the page has none
  std::string color;     ///< array of the vertices; "none": one colour; of a skeleton "sheet", "branch": by its parts;
                         ///< of a tree is_colour_of_tree()
  std::string measure;   ///< by which the layer `core` is pruned
  double threshold = 0;  ///< of that measure
  std::optional<std::array<double, 9>> camera;  ///< position, target, up; world units
  bool dark = false;
  bool shape = true;               ///< the surface of the shape is drawn
  bool curves_by_measure = false;  ///< else they have a colour of their own
};
ViewState view_state(const Page& page);

/// The whole array, or nothing. Throws Error(usage) when it has another type.
template <class T>
const std::vector<T>* find_values(const Page& page, const std::string& name);

}  // namespace quench::picture
