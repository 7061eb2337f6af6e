// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <ostream>
#include <vector>

#include "io/volume/nrrd_lines.h"
#include "io/volume/zarr_writer.h"
#include "quench/error.h"
#include "quench/io.h"

namespace quench::io {
namespace {

// A gzip stream written block by block.
class GzipWriter {
 public:
  explicit GzipWriter(std::ostream& out) : out_(out), buffer_(1 << 18) {
    constexpr int kGzip = 15 + 16, kMemory = 8;
    if (deflateInit2(&z_, 6, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
      throw Error(ErrorCode::failed, "zlib cannot be started: out of memory");
  }
  GzipWriter(const GzipWriter&) = delete;
  GzipWriter& operator=(const GzipWriter&) = delete;
  ~GzipWriter() { deflateEnd(&z_); }

  void write(unsigned char* data, std::size_t size) {
    z_.next_in = data;
    z_.avail_in = static_cast<unsigned>(size);
    while (z_.avail_in > 0) step(Z_NO_FLUSH);
  }
  void finish() {
    while (step(Z_FINISH) != Z_STREAM_END) {
    }
  }

 private:
  int step(int flush) {
    z_.next_out = buffer_.data();
    z_.avail_out = static_cast<unsigned>(buffer_.size());
    const int result = deflate(&z_, flush);
    out_.write(reinterpret_cast<const char*>(buffer_.data()),
               static_cast<std::streamsize>(buffer_.size() - z_.avail_out));
    return result;
  }

  std::ostream& out_;
  std::vector<unsigned char> buffer_;
  z_stream z_{};
};

/// The first two or all three components.
std::string vector_text(const Vec3& v, int dimension) {
  std::string text;
  for (int a = 0; a < dimension; ++a) text += fmt::format("{}{}", a == 0 ? "(" : ",", 0.0 + v[a]);  // 0 for -0
  return text + ")";
}

/// A word as often as there are axes.
std::string for_each_axis(const std::string& word, int dimension) {
  std::string text;
  for (int a = 0; a < dimension; ++a) text += ' ' + word;
  return text;
}

/// The space of the format that a reader may have found.
std::string space_line(const std::string& space) {
  if (space == "LPS") return "space: left-posterior-superior\n";
  for (const char* other : {"scanner-xyz", "3D-right-handed", "3D-left-handed"})
    if (space == other) return fmt::format("space: {}\n", other);
  return "space dimension: 3\n";
}

/// In quotation marks, where nothing in it ends them or the line.
std::string quoted(const std::string& text) {
  const bool ends = std::any_of(text.begin(), text.end(), [](char c) { return c == '"' || c == '\n' || c == '\r'; });
  return text.empty() || ends ? std::string() : '"' + text + '"';
}

}  // namespace

std::string nrrd_lines(const Grid& grid, const Coordinates& coordinates, const std::string& type,
                       const std::string& comment) {
  const int n = grid.dimension;
  std::string text = fmt::format("NRRD0004\n# {}\ntype: {}\ndimension: {}\n", comment, type, n);
  text += grid.is_plane() ? "space dimension: 2\n" : space_line(coordinates.space);
  text += "sizes:";
  for (int a = 0; a < n; ++a) text += fmt::format(" {}", grid.dims[static_cast<std::size_t>(a)]);
  text += "\nspace directions:";
  for (int a = 0; a < n; ++a) text += ' ' + vector_text(grid.direction.col(a) * grid.spacing[a], n);
  if (const std::string unit = quoted(coordinates.units); !unit.empty())
    text += "\nspace units:" + for_each_axis(unit, n);
  text += "\nkinds:" + for_each_axis("domain", n) + "\nencoding: gzip\n";
  if (type != "uint8") text += "endian: little\n";
  text += "space origin: " + vector_text(grid.origin, n) + '\n';
  if (grid.is_plane()) text += fmt::format("y_axis:={}\n", coordinates.y_down ? "down" : "up");
  return text + '\n';
}

void write_volume(const std::filesystem::path& file, const VoxelShape& shape, const Coordinates& coordinates,
                  Context* context) {
  if (is_zarr_name(file)) return write_shape_zarr(file, shape, coordinates, context);
  const Grid& grid = shape.grid();
  write_atomically(file, [&](std::ostream& out) {
    out << nrrd_lines(grid, coordinates, "uint8", "voxel shape: 1 inside, 0 outside");
    GzipWriter gzip(out);
    std::vector<unsigned char> row(static_cast<std::size_t>(grid.dims[0]));
    for (std::int64_t z = 0; z < grid.dims[2]; ++z) {
      checkpoint(context, "write", static_cast<double>(z) / static_cast<double>(grid.dims[2]));
      for (std::int64_t y = 0; y < grid.dims[1]; ++y) {
        std::memset(row.data(), 0, row.size());
        for (const Run& run : shape.row(y, z))
          std::memset(row.data() + run.begin, 1, static_cast<std::size_t>(run.end - run.begin));
        gzip.write(row.data(), row.size());
      }
    }
    gzip.finish();
  });
  checkpoint(context, "write", 1);
}

}  // namespace quench::io
