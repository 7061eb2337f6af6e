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
                         ///< of a tree is_colour_of_tree(); of sheets `sheets/NAME`
  std::string measure;   ///< by which the layer `core` is pruned
  double threshold = 0;  ///< of that measure
  std::optional<std::array<double, 9>> camera;  ///< position, target, up; world units
  bool dark = false;
  bool shape = true;               ///< the surface of the shape is drawn
  std::string surface;             ///< measure of the surface that hides what is inside; empty: it is glass
  std::size_t vertices = 200;      ///< of the layer `simple`
  bool curves_by_measure = false;  ///< else they have a colour of their own
};
ViewState view_state(const Page& page);

/// The column of the table of sheets that a colour is by, or null.
const PageColumn* sheet_column(const Page& page, const std::string& color);

/// The whole array, or nothing. Throws Error(usage) when it has another type.
template <class T>
const std::vector<T>* find_values(const Page& page, const std::string& name);

}  // namespace quench::picture
