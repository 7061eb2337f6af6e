// SPDX-License-Identifier: Apache-2.0
// quench._core: what the Python package quench stands on. Not for direct use; python/quench has the documentation.
#include "arrays.h"
#include "run.h"
#include "values.h"

PYBIND11_MODULE(_core, m) {
  using namespace quench::python;
  bind_errors(m);
  bind_arrays(m);
  bind_shapes(m);
  bind_axes(m);
  bind_skeletons(m);
  bind_parts(m);
  bind_trees(m);
  bind_solids(m);
  bind_labels(m);
  bind_thickness(m);
  bind_pages(m);
  bind_pickles(m);
  m.attr("__version__") = QUENCH_VERSION;
}
