// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/platform/system_files.h"
#include "pipeline/bricks.h"

/// The files of a folder WORK: plan.json, shape/, surface.mesh, round-1/ ...
namespace quench::pipeline {

/// A file of WORK that is read piece by piece. Throws Error(failed) where it cannot be opened or read, and Error(input)
/// where it is shorter than it must be, naming it.
class WorkFile {
 public:
  /// `read` counts bytes.
  WorkFile(std::filesystem::path file, std::atomic<std::int64_t>& read);
  std::string bytes(std::uint64_t count);
  std::string rest() { return bytes(size_ - at_); }
  void go_to(std::uint64_t at);
  /// Throws Error(input) that the file is damaged unless `good`.
  void require(bool good) const;

 private:
  std::filesystem::path file_;
  std::ifstream in_;
  std::atomic<std::int64_t>& read_;
  std::uint64_t size_ = 0, at_ = 0;
};
/// Error(input): '...' cannot be used: ... `what`: a sentence on "it".
[[noreturn]] void refuse_work_file(const std::filesystem::path& file, const std::string& what);

/// plan.json as text; the same for the same plan of the same shape.
struct PlanFile {
  BrickPlan plan;
  // Of the LoadedShape, beside its voxels and its surface.
  double longest_side = 0;
  Topology topology;
  Coordinates coordinates;
  std::string parameters;
  bool from_mesh = false;
  std::vector<std::uint32_t> shape_sums;  ///< a checksum per file of shape/
  std::optional<SurfaceKind> surface;     ///< what surface.mesh is
  std::uint32_t surface_sum = 0;
  std::string report;  ///< JSON text of the caller
};
std::string text_of(const PlanFile& file);
/// Reads it and sets the fingerprint. Throws Error(input), naming the file.
PlanFile read_plan(const std::filesystem::path& work);

/// The voxels of a shape in files, one per layer of `block[1]` slices; each has pieces of `block[0]` rows per slice, so
/// that a box is read without what is far from it along y and z.
struct ShapeFiles {
  std::filesystem::path folder;
  Grid grid;
  std::array<std::int64_t, 2> block{};  ///< rows along y, slices

  std::size_t count() const;
  std::filesystem::path file(std::size_t layer) const;
  /// Bytes of a file, and its checksum.
  std::string encoded(const VoxelShape& shape, std::size_t layer, std::uint32_t& sum) const;
  /// The voxels of a box, on a grid of their own. `sums`: of all files. `read` counts bytes. Throws Error(input) for
  /// damaged files, naming them.
  VoxelShape voxels(const dual::bricks::Box& box, const std::vector<std::uint32_t>& sums,
                    std::atomic<std::int64_t>& read) const;
};
ShapeFiles shape_files(const std::filesystem::path& work, const BrickPlan& plan);

std::string encoded_mesh(const TriangleMesh& mesh, std::uint32_t& sum);
Surface read_surface_of(const std::filesystem::path& work, const PlanFile& file, std::atomic<std::int64_t>& read,
                        Context* context);

/// The parts of a plan as files. Any number of processes.
class PartFiles {
 public:
  PartFiles(std::filesystem::path folder, const BrickPlan& plan) : folder_(std::move(folder)), plan_(plan) {}

  void make_folders() const;
  std::filesystem::path folder(std::size_t round) const;
  std::filesystem::path file(std::size_t round, std::size_t brick) const;
  bool has(std::size_t round, std::size_t brick) const;
  std::int64_t size(std::size_t round, std::size_t brick) const;
  std::string part(std::size_t round, std::size_t brick);
  std::string head(std::size_t round, std::size_t brick);
  void put(std::size_t round, std::size_t brick, const std::string& bytes);
  std::atomic<std::int64_t> read{0}, written{0};  ///< bytes so far

 private:
  std::filesystem::path folder_;
  const BrickPlan& plan_;
};

/// Reads and writes a folder WORK.
class FolderBrickStore : public BrickStore {
 public:
  explicit FolderBrickStore(std::filesystem::path work, Context* context = nullptr);
  PlanFile file;
  PartFiles parts;
  VoxelShape voxels(const dual::bricks::Box& box) override;
  const Surface* surface() override;
  bool has(std::size_t round, std::size_t brick) override { return parts.has(round, brick); }
  std::int64_t size(std::size_t round, std::size_t brick) override { return parts.size(round, brick); }
  std::string part(std::size_t round, std::size_t brick) override { return parts.part(round, brick); }
  std::string head(std::size_t round, std::size_t brick) override { return parts.head(round, brick); }
  void put(std::size_t round, std::size_t brick, const std::string& bytes) override { parts.put(round, brick, bytes); }
  std::string name(std::size_t round, std::size_t brick) override { return parts.file(round, brick).string(); }
  /// All of it.
  LoadedShape shape();

 private:
  std::filesystem::path work_;
  Context* context_;
  std::optional<Surface> surface_;
};

/// The shape is in memory; the parts of a round are in a file without a name, which is gone with the process.
class TemporaryBrickStore : public BrickStore {
 public:
  TemporaryBrickStore(const BrickPlan& plan, const LoadedShape& shape, std::filesystem::path folder);
  ~TemporaryBrickStore() override;
  VoxelShape voxels(const dual::bricks::Box& box) override { return cut(shape_.shape, box); }
  const Surface* surface() override { return shape_.surface ? &*shape_.surface : nullptr; }
  bool has(std::size_t round, std::size_t brick) override { return size(round, brick) > 0; }
  std::int64_t size(std::size_t round, std::size_t brick) override {
    return static_cast<std::int64_t>(rounds_[round].places[brick].size);
  }
  std::string part(std::size_t round, std::size_t brick) override;
  std::string head(std::size_t round, std::size_t brick) override;
  void put(std::size_t round, std::size_t brick, const std::string& bytes) override;
  /// Frees the disk of a round that is not needed any more.
  void drop(std::size_t round);

 private:
  struct Place {
    std::uint64_t begin = 0, size = 0;
  };
  struct Round {
    base::PlacedFile file;
    std::uint64_t size = 0;
    std::vector<Place> places;
  };
  std::string bytes(std::size_t round, std::size_t brick, std::uint64_t most);

  const BrickPlan& plan_;
  const LoadedShape& shape_;
  std::filesystem::path folder_;
  std::vector<Round> rounds_;
};

/// core_of() in bricks, whose parts are in files without names in `folder`.
CoreResult core_in_bricks(const LoadedShape& shape, const AxisOptions& options, const std::filesystem::path& folder,
                          Context* context);

}  // namespace quench::pipeline
