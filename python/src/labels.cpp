// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <numeric>
#include <thread>
#include <unordered_set>

#include "base/memory.h"
#include "quench/error.h"
#include "values.h"

namespace quench::python {
namespace {

struct Wish {
  std::string measure, threshold;  ///< of the pruning
  Thetas thetas;
};

/// Lets as many labels in as their memory allows, one always.
class Gate {
 public:
  explicit Gate(std::int64_t bytes) : free_(bytes) {}
  void enter(std::int64_t bytes) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return inside_ == 0 || bytes <= free_; });
    ++inside_;
    free_ -= bytes;
  }
  void leave(std::int64_t bytes) {
    const std::lock_guard lock(mutex_);
    --inside_;
    free_ += bytes;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::int64_t free_;
  int inside_ = 0;
};

// From the voxels of one label to its skeleton; everything between is dropped.
std::shared_ptr<SkeletonValue> skeleton_of(VoxelShape voxels, const Grid& image, const Coordinates& coordinates,
                                           std::int64_t label, const Wish& wish, Context& context) {
  pipeline::ShapeOptions options;
  options.foreground.label = label;
  auto shape = std::make_shared<Shape>(pipeline::shape_of(std::move(voxels), image, options, &context));
  shape->coordinates = coordinates;
  auto axis = compute_axis(shape, {.pruning = pruning_of(wish.measure, wish.threshold)}, context);
  const auto fire = compute_fire(*axis, {}, true, nullptr, context);
  auto result = compute_skeleton(axis, *fire, wish.thetas, context);
  axis->core.axis = MedialAxis();
  result->has_axis = false;
  return result;
}

/// Runs `work` on `count` threads, the calling one among them; on fewer where the system has no more of them. `work`
/// must not throw.
void work_together(std::size_t count, const std::function<void()>& work) {
  std::vector<std::thread> others;
  try {
    others.reserve(count);
    while (others.size() + 1 < count) others.emplace_back(work);
  } catch (const std::exception&) {  // those that were started suffice
  }
  work();
  for (std::thread& thread : others) thread.join();
}

using Results = std::vector<std::shared_ptr<SkeletonValue>>;

Results skeletons_of(std::vector<LabelRuns>& labels, const Grid& image, const Coordinates& coordinates,
                     const Wish& wish, Context& context) {
  Results results(labels.size());
  std::vector<std::exception_ptr> failures(labels.size());
  // Large ones first, so that none is left alone at the end. Every label is worked on by one thread and alone in its
  // result, so results do not depend on their number.
  std::vector<std::size_t> order(labels.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return labels[a].pieces.size() > labels[b].pieces.size(); });
  double total = 0, done = 0;
  for (const LabelRuns& l : labels) total += static_cast<double>(l.pieces.size());
  std::mutex telling;  // progress and notes come from one thread at a time
  Gate gate(base::available_memory() / 10 * 9);
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  const auto work = [&] {
    tbb::task_arena alone(1);  // also for what takes no context
    for (std::size_t i; (i = next++) < order.size() && !failed && !context.cancelled();) {
      LabelRuns& label = labels[order[i]];
      const auto weight = static_cast<double>(label.pieces.size());
      std::int64_t bytes = 0;
      bool entered = false;
      try {
        Context own;
        own.threads = 1;
        own.progress = [&](std::string_view, double) {
          if (context.cancelled() || failed) own.cancel();
        };
        own.note = [&](const std::string& sentence) {
          const std::lock_guard lock(telling);
          note(&context, fmt::format("label {}: {}", label.label, sentence));
        };
        VoxelShape voxels = label.shape(image);
        label.pieces = {};
        bytes = pipeline::predicted_run_bytes(voxels);
        gate.enter(bytes);
        entered = true;
        results[order[i]] =
            alone.execute([&] { return skeleton_of(std::move(voxels), image, coordinates, label.label, wish, own); });
      } catch (const Error& error) {
        failures[order[i]] = std::make_exception_ptr(
            Error(error.code(), fmt::format("label {}: {}", label.label, error.what()), error.field()));
        failed = true;
      } catch (...) {
        failures[order[i]] = std::current_exception();
        failed = true;
      }
      if (entered) gate.leave(bytes);
      const std::lock_guard lock(telling);
      done += weight;
      if (context.progress) context.progress("skeletonize", done / total);
    }
  };
  const std::size_t wanted = context.threads > 0 ? static_cast<std::size_t>(context.threads)
                                                 : std::max(1u, std::thread::hardware_concurrency());
  work_together(std::min(wanted, labels.size()), work);
  if (context.cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
  for (const std::exception_ptr& failure : failures) {
    if (!failure) continue;
    try {
      std::rethrow_exception(failure);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::cancelled) throw;  // others were only told to stop
    }
  }
  return results;
}

py::list skeletonize(const ImageView& image, const Coordinates& coordinates,
                     const std::optional<std::vector<std::int64_t>>& chosen, const Wish& wish,
                     const py::object& listener, int threads) {
  std::vector<LabelRuns> labels;
  Results results;
  run_cancellable(listener, threads, [&](Context& context) {
    if (chosen) {
      const std::unordered_set<std::int64_t> set(chosen->begin(), chosen->end());
      labels = label_runs(
          image, [&](std::int64_t label) { return set.contains(label); }, &context);
      for (const std::int64_t label : *chosen)
        if (std::none_of(labels.begin(), labels.end(), [&](const LabelRuns& l) { return l.label == label; }))
          throw Error(ErrorCode::input, fmt::format("no {} of the image has the label {}",
                                                    image.grid.is_plane() ? "pixel" : "voxel", label));
    } else {
      labels = label_runs(image, nullptr, &context);
    }
    results = skeletons_of(labels, image.grid, coordinates, wish, context);
  });
  py::list list;
  for (std::size_t i = 0; i < labels.size(); ++i) list.append(py::make_tuple(labels[i].label, results[i]));
  return list;
}

}  // namespace

void bind_labels(py::module_& m) {
  using Triple = std::array<double, 3>;
  using Labels = std::optional<std::vector<std::int64_t>>;
  m.def("skeletonize_array", [](const py::buffer& array, const Place* place, const std::optional<Triple>& spacing,
                                const Labels& labels, const std::string& measure, const std::string& threshold,
                                const std::string& theta2, const std::string& theta1, const py::object& listener,
                                int threads) {
    const py::buffer_info held = array.request();
    Grid grid = place ? placed(held, *place) : grid_of(held, {1, 1, 1});
    if (spacing) grid.spacing = {(*spacing)[0], (*spacing)[1], (*spacing)[2]};
    if (grid.is_plane()) grid.make_plane();
    return skeletonize(image_of(held, grid), place ? place->coordinates : coordinates_of(grid), labels,
                       {measure, threshold, {theta2, theta1, true}}, listener, threads);
  });
}

}  // namespace quench::python
