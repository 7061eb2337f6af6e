// SPDX-License-Identifier: Apache-2.0
// deprecated: the names before 0.2, for one release.
#pragma once

#include <utility>

#include "quench/io.h"
#include "quench/record.h"

namespace quench {

using PolyData = Record;

template <class Value>
[[deprecated("to_record")]] Record to_poly_data(Value&& value) {
  return to_record(std::forward<Value>(value));
}

namespace io {

[[deprecated("read_record")]] inline Record read_poly_data(const std::filesystem::path& file,
                                                           Context* context = nullptr) {
  return read_record(file, context);
}
[[deprecated("write_record")]] inline void write_poly_data(const std::filesystem::path& file, const Record& data,
                                                           const WriteOptions& options = {}) {
  write_record(file, data, options);
}

}  // namespace io
}  // namespace quench
