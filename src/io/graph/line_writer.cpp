// SPDX-License-Identifier: Apache-2.0
#include "io/common/formats.h"
#include "io/common/output_file.h"
#include "io/common/text_out.h"
#include "io/graph/line_format.h"

namespace quench::io {
namespace {

/// Well-known text.
class WktLines : public LineFormat {
 public:
  explicit WktLines(std::ostream& out) : text_(out) {}

  void append(const PlaneLines& lines) override {
    for (const auto& branch : lines.graph.branches) {
      const char* before = "LINESTRING (";
      for (const Vec3& p : branch.points) text_.print("{}{} {}", std::exchange(before, ", "), p[0], p[1]);
      text_.print(")\n");
    }
    for (const Polygons& part : parts_of(lines.wide)) {
      const char* next = "POLYGON (";
      for (const auto& ring : part.rings) {
        text_.print("{}(", std::exchange(next, ", "));
        for (const Vec2& p : ring) text_.print("{} {}, ", p[0], p[1]);
        text_.print("{} {})", ring[0][0], ring[0][1]);
      }
      text_.print(")\n");
    }
    for (const auto& node : lines.graph.nodes)
      if (node.kind == CurveGraph::NodeKind::isolated) text_.print("POINT ({} {})\n", node.point[0], node.point[1]);
  }
  void finish() override { text_.flush(); }

 private:
  TextOut text_;
};

std::unique_ptr<LineFormat> format_for(const std::filesystem::path& file, std::ostream& out,
                                       const LineOptions& options) {
  const std::string extension = lower_extension(file);
  if (extension == ".wkt") return wkt_lines(out);
  if (extension == ".svg") return svg_lines(out, options);
  return geojson_lines(out, extension == ".geojson" || extension == ".json");
}

/// Asked before the temporary file is made.
const std::filesystem::path& writable(const std::filesystem::path& file) {
  if (kind_of(file) != Kind::polygons)
    throw Error(ErrorCode::usage,
                fmt::format("cannot write lines of the plane to '{}'; name it .geojson, .geojsonl, .wkt or .svg",
                            file.string()));
  return file;
}

}  // namespace

std::unique_ptr<LineFormat> wkt_lines(std::ostream& out) { return std::make_unique<WktLines>(out); }

struct LineWriter::Impl {
  Impl(const std::filesystem::path& file, const LineOptions& options)
      : out(writable(file)), format(format_for(file, out.stream(), options)) {}
  OutputFile out;
  std::unique_ptr<LineFormat> format;
};

LineWriter::LineWriter(const std::filesystem::path& file, const LineOptions& options)
    : impl_(std::make_unique<Impl>(file, options)) {}
LineWriter::LineWriter(LineWriter&&) noexcept = default;
LineWriter& LineWriter::operator=(LineWriter&&) noexcept = default;
LineWriter::~LineWriter() = default;

void LineWriter::append(const PlaneLines& lines) { impl_->format->append(lines); }

void LineWriter::finish() {
  impl_->format->finish();
  impl_->out.commit();
}

void write_lines(const std::filesystem::path& file, const PlaneLines& lines, const LineOptions& options) {
  LineWriter writer(file, options);
  writer.append(lines);
  writer.finish();
}

}  // namespace quench::io
