// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/packed_numbers.h"
#include "pipeline/brick_files.h"
#include "quench/error.h"

namespace quench::pipeline {
namespace {

using base::NumberPacker;
using base::NumberReader;
using dual::bricks::Box;

std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

// Rows [y, y + rows) of slices [z, z + slices), those without voxels in one number.
struct Block {
  std::int64_t y, rows, z, slices;
};

Block block_of(const ShapeFiles& files, std::size_t layer, std::size_t piece) {
  const auto at = [](std::size_t i, std::int64_t side) { return static_cast<std::int64_t>(i) * side; };
  const std::int64_t y = at(piece, files.block[0]), z = at(layer, files.block[1]);
  return {y, std::min(files.block[0], files.grid.dims[1] - y), z, std::min(files.block[1], files.grid.dims[2] - z)};
}

std::size_t pieces_of(const ShapeFiles& files) {
  return static_cast<std::size_t>((files.grid.dims[1] + files.block[0] - 1) / files.block[0]);
}

std::string encoded_block(const VoxelShape& shape, const Block& block) {
  NumberPacker to;
  std::uint64_t empty = 0;
  for (std::int64_t z = block.z; z < block.z + block.slices; ++z)
    for (std::int64_t y = block.y; y < block.y + block.rows; ++y) {
      const auto runs = shape.row(y, z);
      if (runs.empty()) {
        ++empty;
        continue;
      }
      to.add(std::exchange(empty, 0));
      to.add(runs.size());
      std::int32_t last = 0;
      for (const Run& run : runs) {
        to.add(static_cast<std::uint64_t>(run.begin - last));
        to.add(static_cast<std::uint64_t>(run.end - run.begin));
        last = run.end;
      }
    }
  to.add(empty);
  return std::move(to.bytes);
}

// The rows of a block, cut to a range along x.
struct Rows {
  std::vector<std::size_t> begin{0};
  std::vector<Run> runs;

  std::span<const Run> operator[](std::size_t row) const {
    return {runs.data() + begin[row], runs.data() + begin[row + 1]};
  }
};

Rows decoded_block(std::string_view bytes, const Block& block, std::int64_t width, std::int64_t low,
                   std::int64_t high) {
  NumberReader from(bytes);
  Rows rows;
  const auto count = static_cast<std::size_t>(block.rows * block.slices);
  const auto left = [&] { return count + 1 - rows.begin.size(); };
  for (;;) {
    rows.begin.resize(rows.begin.size() + from.next_up_to(left()), rows.runs.size());
    if (from.at_end()) break;
    if (left() == 0) NumberReader::damaged();
    std::int64_t at = 0;
    for (std::size_t n = from.next_count(); n > 0; --n) {
      at += static_cast<std::int64_t>(from.next_up_to(static_cast<std::uint64_t>(width - at)));
      const std::int64_t begin = std::max(at, low);
      at += static_cast<std::int64_t>(from.next_up_to(static_cast<std::uint64_t>(width - at)));
      const std::int64_t end = std::min(at, high);
      if (begin < end)
        rows.runs.push_back({static_cast<std::int32_t>(begin - low), static_cast<std::int32_t>(end - low)});
    }
    rows.begin.push_back(rows.runs.size());
  }
  if (left() != 0) NumberReader::damaged();
  return rows;
}

// What a file begins with: per piece its size and checksum.
constexpr std::size_t kPieceEntry = 12;

void append_entry(std::string& table, std::string_view piece) {
  const std::uint64_t size = piece.size();
  const std::uint32_t sum = checksum(piece);
  table.append(reinterpret_cast<const char*>(&size), sizeof size);
  table.append(reinterpret_cast<const char*>(&sum), sizeof sum);
}

std::pair<std::uint64_t, std::uint32_t> entry_at(std::string_view table, std::size_t piece) {
  std::pair<std::uint64_t, std::uint32_t> entry;
  std::memcpy(&entry.first, table.data() + piece * kPieceEntry, sizeof entry.first);
  std::memcpy(&entry.second, table.data() + piece * kPieceEntry + sizeof entry.first, sizeof entry.second);
  return entry;
}

}  // namespace

std::size_t ShapeFiles::count() const { return static_cast<std::size_t>((grid.dims[2] + block[1] - 1) / block[1]); }

std::filesystem::path ShapeFiles::file(std::size_t layer) const { return folder / fmt::format("{:06}.runs", layer); }

std::string ShapeFiles::encoded(const VoxelShape& shape, std::size_t layer, std::uint32_t& sum) const {
  std::string table, pieces;
  for (std::size_t p = 0; p < pieces_of(*this); ++p) {
    const std::string piece = encoded_block(shape, block_of(*this, layer, p));
    append_entry(table, piece);
    pieces += piece;
  }
  sum = checksum(table);
  return table + pieces;
}

VoxelShape ShapeFiles::voxels(const Box& box, const std::vector<std::uint32_t>& sums,
                              std::atomic<std::int64_t>& read) const {
  Grid own = grid;
  for (std::size_t a = 0; a < 3; ++a) own.dims[a] = box.high[a] - box.low[a];
  own.origin = grid.world(
      Vec3(static_cast<double>(box.low[0]), static_cast<double>(box.low[1]), static_cast<double>(box.low[2])) +
      grid.first_centre());
  VoxelShape shape(own);
  const auto first = static_cast<std::size_t>(box.low[1] / block[0]);
  const auto last = static_cast<std::size_t>((box.high[1] - 1) / block[0]);
  for (auto layer = static_cast<std::size_t>(box.low[2] / block[1]);
       static_cast<std::int64_t>(layer) * block[1] < box.high[2]; ++layer) {
    WorkFile in(file(layer), read);
    const std::string table = in.bytes(pieces_of(*this) * kPieceEntry);
    in.require(checksum(table) == sums.at(layer));
    std::uint64_t at = table.size();
    for (std::size_t p = 0; p < first; ++p) at += entry_at(table, p).first;
    in.go_to(at);
    std::vector<Rows> rows;
    for (std::size_t p = first; p <= last; ++p) {
      const auto [size, sum] = entry_at(table, p);
      const std::string piece = in.bytes(size);
      in.require(checksum(piece) == sum);
      rows.push_back(decoded_block(piece, block_of(*this, layer, p), grid.dims[0], box.low[0], box.high[0]));
    }
    const Block whole = block_of(*this, layer, first);
    for (std::int64_t z = std::max(whole.z, box.low[2]); z < std::min(whole.z + whole.slices, box.high[2]); ++z)
      for (std::int64_t y = box.low[1]; y < box.high[1]; ++y) {
        const auto piece = static_cast<std::size_t>(y / block[0]);
        const Block of = block_of(*this, layer, piece);
        shape.append_row(rows[piece - first][static_cast<std::size_t>((z - of.z) * of.rows + y - of.y)]);
      }
  }
  return shape;
}

ShapeFiles shape_files(const std::filesystem::path& work, const BrickPlan& plan) {
  return {work / "shape", plan.grid, {plan.rounds[0].side[1], plan.rounds[0].side[2]}};
}

std::string encoded_mesh(const TriangleMesh& mesh, std::uint32_t& sum) {
  NumberPacker to;
  to.add(mesh.points.size());
  for (const Vec3& p : mesh.points)
    for (int a = 0; a < 3; ++a) to.add_double(p[a]);
  to.add(mesh.triangles.size());
  std::int64_t last = 0;
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) {
      to.add_signed(corner - last);
      last = corner;
    }
  sum = checksum(to.bytes);
  return std::move(to.bytes);
}

Surface read_surface_of(const std::filesystem::path& work, const PlanFile& file, std::atomic<std::int64_t>& read,
                        Context* context) {
  WorkFile in(work / "surface.mesh", read);
  const std::string bytes = in.rest();
  in.require(checksum(bytes) == file.surface_sum);
  NumberReader from(bytes);
  TriangleMesh mesh;
  mesh.points.resize(from.next_count());
  for (Vec3& p : mesh.points)
    for (int a = 0; a < 3; ++a) p[a] = from.next_double();
  mesh.triangles.resize(from.next_count());
  std::int64_t last = 0;
  for (auto& triangle : mesh.triangles)
    for (std::uint32_t& corner : triangle) {
      last += from.next_signed();
      in.require(last >= 0 && last < static_cast<std::int64_t>(mesh.points.size()));
      corner = static_cast<std::uint32_t>(last);
    }
  return Surface(std::move(mesh), *file.surface, context);
}

}  // namespace quench::pipeline
