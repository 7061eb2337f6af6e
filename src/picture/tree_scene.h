// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "picture/scene.h"

namespace quench::picture {

/// Whether the layer `tree` can be coloured so (viewer/src/measures.ts).
bool is_colour_of_tree(const Page& page, const std::string& color);

/// The branches of the layer `tree` as tubes with their colours. Throws Error(usage) where its arrays do not fit.
void add_tree_cells(const Page& page, const ViewState& state, Scene& scene);

/// A column of the tables of a tree by the name of its colour, "axes/length"; nullptr: there is none.
const PageColumn* column_of(const Page& page, const std::string& color);

/// The number of axes, and a value of the table `sample`, NaN where there is none.
std::size_t axes_of(const Page& page);
double sample_value(const Page& page, const std::string& name);

}  // namespace quench::picture
