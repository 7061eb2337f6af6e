// SPDX-License-Identifier: Apache-2.0
#include "run.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "quench/error.h"

namespace quench::python {
namespace {

/// What the working thread tells and the calling one takes.
struct Mailbox {
  std::mutex mutex;
  std::condition_variable bell;
  std::vector<std::pair<std::string, double>> progress;  // the last fraction of each stage in a row
  std::vector<std::string> notes;
  bool done = false;
};

constexpr auto kPatience = std::chrono::milliseconds(50);

void deliver(const py::object& listener, const std::vector<std::pair<std::string, double>>& progress) {
  if (listener.is_none()) return;
  for (const auto& [stage, fraction] : progress) listener(stage, fraction);
}

}  // namespace

void run_cancellable(const py::object& listener, int threads, const std::function<void(Context&)>& work) {
  if (threads < 0)
    throw Error(ErrorCode::usage, fmt::format("threads '{}' is negative; give 0 for all processors", threads),
                "threads");
  Mailbox box;
  Context context;
  context.threads = std::min(threads, 256);
  context.progress = [&](std::string_view stage, double fraction) {
    const std::lock_guard lock(box.mutex);
    if (box.progress.empty() || box.progress.back().first != stage)
      box.progress.emplace_back(stage, fraction);
    else
      box.progress.back().second = fraction;
  };
  context.note = [&](const std::string& sentence) {
    const std::lock_guard lock(box.mutex);
    box.notes.push_back(sentence);
  };
  std::exception_ptr failure;
  std::thread worker([&] {
    try {
      // For what takes no context: pruning, files, pages. TBB complains on stderr of more threads than it may have.
      const auto most = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
      const int threads_of_tbb = std::min(context.threads, static_cast<int>(most));
      tbb::task_arena arena(threads_of_tbb > 0 ? threads_of_tbb : tbb::task_arena::automatic);
      arena.execute([&] { work(context); });
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(box.mutex);
    box.done = true;
    box.bell.notify_one();
  });
  std::optional<py::error_already_set> interrupted;
  bool done = false;
  while (!done) {
    std::vector<std::pair<std::string, double>> progress;
    {
      const py::gil_scoped_release release;
      std::unique_lock lock(box.mutex);
      box.bell.wait_for(lock, kPatience, [&] { return box.done; });
      progress.swap(box.progress);
      done = box.done;
    }
    if (interrupted) continue;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      deliver(listener, progress);
    } catch (py::error_already_set& error) {
      interrupted.emplace(error);
      context.cancel();
    }
  }
  worker.join();
  if (interrupted) throw *interrupted;
  if (!box.notes.empty()) {
    const py::object warn = py::module_::import("quench._common").attr("warn");
    for (const std::string& sentence : box.notes) warn(sentence);
  }
  if (failure) std::rethrow_exception(failure);
}

namespace {

/// The keyword argument for a parameter of the library; empty where there is none.
std::string argument_of(const std::string& field) {
  if (field == "memory_limit" || field == "max_triangles") return {};
  return field == "lambda" ? "lambda_" : field;
}

/// The sentence with the keyword: "lambda_='2mm' is not a length".
std::string with_argument(const Error& error) {
  const std::string sentence = error.what(), &field = error.field();
  if (field.empty() || !sentence.starts_with(field + " '")) return sentence;
  return argument_of(field) + "=" + sentence.substr(field.size() + 1);
}

}  // namespace

void bind_errors(py::module_& m) {
  static py::handle type, usage;  // as long as the interpreter: translators are never taken back
  type = PyErr_NewExceptionWithDoc(
      "quench.Error",
      "What Quench raises: one sentence that names the value or file, the reason and the way out.\n\n"
      "Attributes\n----------\ncode : int\n"
      "    1 failed (files, memory), 2 usage (an invalid argument: a UsageError), 3 an input that cannot be used,\n"
      "    4 a promised invariant does not hold (a bug in Quench), 130 cancelled.\n"
      "argument : str or None\n"
      "    The keyword argument that is wrong or would help, where there is one.\n",
      PyExc_RuntimeError, nullptr);
  if (!type) throw py::error_already_set();
  const py::tuple bases = py::make_tuple(type, py::reinterpret_borrow<py::object>(PyExc_ValueError));
  usage = PyErr_NewExceptionWithDoc("quench.UsageError", "An invalid argument: an Error of code 2, and a ValueError.\n",
                                    bases.ptr(), nullptr);
  if (!usage) throw py::error_already_set();
  m.attr("Error") = type;
  m.attr("UsageError") = usage;
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      const py::handle raised = error.code() == ErrorCode::usage ? usage : type;
      py::object value = raised(with_argument(error));
      value.attr("code") = static_cast<int>(error.code());
      const std::string argument = argument_of(error.field());
      value.attr("argument") = argument.empty() ? py::object(py::none()) : py::str(argument);
      PyErr_SetObject(raised.ptr(), value.ptr());
    }
  });
}

}  // namespace quench::python
