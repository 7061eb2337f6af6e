// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <utility>

#include "quench/context.h"

namespace quench::python {

namespace py = pybind11;

/// Runs `work` on a thread of its own without the interpreter's lock, while the calling thread looks for signals
/// (Ctrl-C cancels, and KeyboardInterrupt is what comes out) and passes progress on: `listener(stage, fraction)` if not
/// None. Notes of the library become warnings. Exceptions of `work`, of the listener and of signal handlers come out
/// here.
void run_cancellable(const py::object& listener, int threads, const std::function<void(Context&)>& work);

template <class Work>
auto run(const py::object& listener, int threads, Work&& work) {
  std::optional<decltype(work(std::declval<Context&>()))> result;
  run_cancellable(listener, threads, [&](Context& context) { result.emplace(work(context)); });
  return std::move(*result);
}

void bind_errors(py::module_& m);

}  // namespace quench::python
