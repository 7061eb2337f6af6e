// SPDX-License-Identifier: Apache-2.0
#include "pipeline/brick_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "quench/error.h"
#include "quench/io.h"

namespace quench::pipeline {
namespace {

[[noreturn]] void fail_at(const char* what, const std::filesystem::path& file) {
  throw Error(ErrorCode::failed, fmt::format("cannot {} '{}': {}", what, file.string(), std::strerror(errno)));
}

}  // namespace

void refuse_work_file(const std::filesystem::path& file, const std::string& what) {
  throw Error(ErrorCode::input, fmt::format("'{}' cannot be used: {}", file.string(), what));
}

WorkFile::WorkFile(std::filesystem::path file, std::atomic<std::int64_t>& read)
    : file_(std::move(file)), in_(file_, std::ios::binary), read_(read) {
  if (!in_) fail_at("open", file_);
  std::error_code error;
  size_ = std::filesystem::file_size(file_, error);
  if (error) throw Error(ErrorCode::failed, fmt::format("cannot read '{}': {}", file_.string(), error.message()));
}

std::string WorkFile::bytes(std::uint64_t count) {
  require(count <= size_ - at_);
  std::string bytes(count, '\0');
  if (!in_.read(bytes.data(), static_cast<std::streamsize>(count))) fail_at("read", file_);
  at_ += count;
  read_ += static_cast<std::int64_t>(count);
  return bytes;
}

void WorkFile::go_to(std::uint64_t at) {
  require(at <= size_);
  in_.seekg(static_cast<std::streamoff>(at));
  at_ = at;
}

void WorkFile::require(bool good) const {
  if (!good) refuse_work_file(file_, "it is damaged");
}

void PartFiles::make_folders() const {
  for (std::size_t round = 0; round < plan_.rounds.size(); ++round) std::filesystem::create_directory(folder(round));
}

std::filesystem::path PartFiles::folder(std::size_t round) const {
  return folder_ / fmt::format("round-{}", round + 1);
}

std::filesystem::path PartFiles::file(std::size_t round, std::size_t brick) const {
  return folder(round) / fmt::format("{:06}.part", brick);
}

bool PartFiles::has(std::size_t round, std::size_t brick) const {
  std::error_code ignored;
  return std::filesystem::exists(file(round, brick), ignored);
}

std::int64_t PartFiles::size(std::size_t round, std::size_t brick) const {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file(round, brick), error);
  return error ? 0 : static_cast<std::int64_t>(size);
}

std::string PartFiles::part(std::size_t round, std::size_t brick) { return WorkFile(file(round, brick), read).rest(); }

std::string PartFiles::head(std::size_t round, std::size_t brick) {
  WorkFile in(file(round, brick), read);
  const std::string header = in.bytes(dual::bricks::kPartHeader);
  return header + in.bytes(dual::bricks::loose_bytes(header, plan_.label(round, brick)) - header.size());
}

void PartFiles::put(std::size_t round, std::size_t brick, const std::string& bytes) {
  io::write_atomically(file(round, brick),
                       [&](std::ostream& out) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
  written += static_cast<std::int64_t>(bytes.size());
}

FolderBrickStore::FolderBrickStore(std::filesystem::path work, Context* context)
    : file(read_plan(work)), parts(work, file.plan), work_(std::move(work)), context_(context) {}

VoxelShape FolderBrickStore::voxels(const dual::bricks::Box& box) {
  return shape_files(work_, file.plan).voxels(box, file.shape_sums, parts.read);
}

const Surface* FolderBrickStore::surface() {
  if (file.surface && !surface_) surface_ = read_surface_of(work_, file, parts.read, context_);
  return surface_ ? &*surface_ : nullptr;
}

LoadedShape FolderBrickStore::shape() {
  LoadedShape shape;
  shape.shape = voxels({{0, 0, 0}, file.plan.grid.dims});
  shape.topology = file.topology;
  shape.longest_side = file.longest_side;
  shape.image = file.plan.grid;
  shape.coordinates = file.coordinates;
  shape.parameters = file.parameters;
  shape.from_mesh = file.from_mesh;
  if (surface()) shape.surface = *surface();
  return shape;
}

TemporaryBrickStore::TemporaryBrickStore(const BrickPlan& plan, const LoadedShape& shape, std::filesystem::path folder)
    : plan_(plan), shape_(shape), folder_(std::move(folder)), rounds_(plan.rounds.size()) {
  for (std::size_t round = 0; round < rounds_.size(); ++round)
    rounds_[round].places.resize(plan.rounds[round].bricks.size());
}

TemporaryBrickStore::~TemporaryBrickStore() {
  for (std::size_t round = 0; round < rounds_.size(); ++round) drop(round);
}

void TemporaryBrickStore::drop(std::size_t round) { rounds_[round].file.close(); }

void TemporaryBrickStore::put(std::size_t round, std::size_t brick, const std::string& bytes) {
  Round& to = rounds_[round];
  if (!to.file.is_open()) {
    to.file = base::PlacedFile::nameless(folder_);
    if (!to.file.is_open()) fail_at("make a temporary file in", folder_);
  }
  if ((errno = to.file.write(to.size, std::as_bytes(std::span(bytes)))) != 0)
    fail_at("write a temporary file in", folder_);
  to.places[brick] = {to.size, bytes.size()};
  to.size += bytes.size();
}

std::string TemporaryBrickStore::bytes(std::size_t round, std::size_t brick, std::uint64_t most) {
  const Round& from = rounds_[round];
  const Place& place = from.places[brick];
  std::string bytes(std::min(place.size, most), '\0');
  if (from.file.read(place.begin, std::as_writable_bytes(std::span(bytes))) != bytes.size())
    fail_at("read a temporary file in", folder_);
  return bytes;
}

std::string TemporaryBrickStore::part(std::size_t round, std::size_t brick) { return bytes(round, brick, UINT64_MAX); }

std::string TemporaryBrickStore::head(std::size_t round, std::size_t brick) {
  const std::string header = bytes(round, brick, dual::bricks::kPartHeader);
  return bytes(round, brick, dual::bricks::loose_bytes(header, plan_.label(round, brick)));
}

}  // namespace quench::pipeline
