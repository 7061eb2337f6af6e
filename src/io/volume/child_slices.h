// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "quench/context.h"
#include "quench/shape.h"

namespace quench::io {

/// The stream that `open` returns, read in a child process: for libraries that a damaged file can make crash or read
/// endlessly. `open` gets the limits of `context`, and its notes are passed on. It has 256 MB and what it allows itself
/// (allow_memory()) for what it knows to need, beyond a slice. The child reads ahead by what the pipe
/// between the two holds. Throws what `open` throws, and as ChildReader does; so do the slices. `file`: what is named
/// in errors, and whose size bounds the processor time.
SliceStream slices_of_child(const std::filesystem::path& file, const std::function<SliceStream(Context*)>& open,
                            Context* context);

/// The bytes that may be held: those the context allows or, where it says nothing, those that are free.
std::int64_t memory_of(const Context* context);

}  // namespace quench::io
