// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "quench/page.h"

namespace quench::page {

/// An array as it is in a file (viewer/FORMAT.md, "Codes").
struct PackedArray {
  std::string name, type;
  int components = 1;
  std::size_t rows = 0;
  std::string code;  ///< further members of its entry in the JSON of the page; empty: the bytes are the values
  std::string bytes;
};

/// The arrays of a page in few bytes. What the viewer can find itself is left out: edges and sides of polygons, levels
/// that are the largest around, differences of measures. Vertices, faces and edges are numbered anew, so that
/// neighbours have near numbers. Levels and thicknesses stay exact; places and measures are rounded to 16 bits of their
/// range, places of the layer `skeleton` to 24. O(n log n).
std::vector<PackedArray> packed(const Page& page);

}  // namespace quench::page
