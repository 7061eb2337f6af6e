// SPDX-License-Identifier: Apache-2.0
#include "io/volume/child_slices.h"

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "base/memory.h"
#include "base/platform/child_process.h"
#include "quench/error.h"
#include "shape/sample_type.h"

namespace quench::io {
namespace {

/// What a child says of its stream, as bytes: the same order for both ends.
struct StreamHead {
  SliceStream stream;
  std::vector<std::string> notes;
};

void transfer_head(StreamHead& head, const auto& bytes, const auto& text) {
  Grid& grid = head.stream.grid;
  bytes(&grid.dims, sizeof grid.dims);
  for (Vec3* v : {&grid.spacing, &grid.origin}) bytes(v->data(), 3 * sizeof(double));
  bytes(grid.direction.data(), 9 * sizeof(double));
  bytes(&grid.dimension, sizeof grid.dimension);
  bytes(&head.stream.type, sizeof head.stream.type);
  Coordinates& coordinates = head.stream.coordinates;
  bytes(&coordinates.y_down, sizeof coordinates.y_down);
  for (std::string* s : {&coordinates.units, &coordinates.space, &head.stream.spacing_source, &head.stream.picture})
    text(*s);
  std::size_t notes = head.notes.size();
  bytes(&notes, sizeof notes);
  head.notes.resize(notes);
  for (std::string& note : head.notes) text(note);
}

std::string packed_head(StreamHead head) {
  std::string all;
  const auto bytes = [&](const void* from, std::size_t size) { all.append(static_cast<const char*>(from), size); };
  transfer_head(head, bytes, [&](const std::string& text) {
    const std::size_t size = text.size();
    bytes(&size, sizeof size);
    bytes(text.data(), size);
  });
  return all;
}

StreamHead unpacked_head(std::string_view all) {
  StreamHead head;
  const auto bytes = [&](void* to, std::size_t size) {
    if (size > all.size()) throw Error(ErrorCode::failed, "the header of a volume was lost between two processes");
    std::memcpy(to, all.data(), size);
    all.remove_prefix(size);
  };
  transfer_head(head, bytes, [&](std::string& text) {
    std::size_t size = 0;
    bytes(&size, sizeof size);
    text = all.substr(0, size);
    all.remove_prefix(text.size());
  });
  return head;
}

/// What the child does.
void send_slices(base::ToParent& to, const std::function<SliceStream(Context*)>& open, std::int64_t memory) {
  StreamHead head;
  Context context;
  context.memory_limit = memory;
  context.note = [&head](const std::string& sentence) { head.notes.push_back(sentence); };
  context.progress = [&to](std::string_view, double) { to.say_alive(); };
  SliceStream stream = open(&context);
  const auto next = std::move(stream.next);
  const Grid grid = stream.grid;
  base::allow_memory(static_cast<std::uint64_t>(grid.dims[0] * grid.dims[1]) * shape::size_of(stream.type));
  std::vector<char> slice(static_cast<std::size_t>(grid.dims[0] * grid.dims[1]) * shape::size_of(stream.type));
  head.stream = std::move(stream);
  to.send(packed_head(std::move(head)));
  for (std::int64_t z = 0; z < grid.dims[2]; ++z) {
    next(std::as_writable_bytes(std::span(slice)));
    to.send({slice.data(), slice.size()});
  }
}

}  // namespace

std::int64_t memory_of(const Context* context) {
  return context && context->memory_limit > 0 ? context->memory_limit : base::available_memory();
}

SliceStream slices_of_child(const std::filesystem::path& file, const std::function<SliceStream(Context*)>& open,
                            Context* context) {
  base::SandboxLimits limits;
  limits.seconds = 20;                   // a layer of compressed chunks is a message
  limits.bytes = std::int64_t{1} << 28;  // until the header is read: a damaged size would be believed by the library
  const std::int64_t allowed = context ? context->memory_limit : 0;
  const auto child = std::make_shared<base::ChildReader>(
      file, [&](base::ToParent& to) { send_slices(to, open, allowed); }, limits, context);
  StreamHead head = unpacked_head(child->next());
  for (const std::string& sentence : head.notes) note(context, sentence);
  head.stream.next = [child](std::span<std::byte> out) { child->next(out); };
  return std::move(head.stream);
}

}  // namespace quench::io
