// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <ostream>

#include "quench/graph.h"

namespace quench::io {

/// A format of lines; LineWriter chooses among them by extension. Nothing is written before the first call.
class LineFormat {
 public:
  LineFormat() = default;
  LineFormat(const LineFormat&) = delete;
  LineFormat& operator=(const LineFormat&) = delete;
  virtual ~LineFormat() = default;
  virtual void append(const PlaneLines& lines) = 0;
  virtual void finish() = 0;
};

/// `collection`: one object with all features; else an object per line.
std::unique_ptr<LineFormat> geojson_lines(std::ostream& out, bool collection);
std::unique_ptr<LineFormat> wkt_lines(std::ostream& out);
std::unique_ptr<LineFormat> svg_lines(std::ostream& out, const LineOptions& options);

}  // namespace quench::io
