// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "quench/io.h"
#include "quench/page.h"
#include "session.h"
#include "shape_input.h"

namespace quench::program {

struct PageOptions {
  std::size_t max_triangles = kPageTriangles;
};

void add_page_options(CLI::App& app, PageOptions& options);

/// Whether this program has the interactive page built in.
bool has_page_program();
/// Throws Error(failed) unless it has.
void require_page_program();

/// A page while it grows: layers share the triangles, in the order in which they are added.
class PageBuilder {
 public:
  PageBuilder(const PageOptions& options, const Session& session) : left_(options.max_triangles) {
    page.program = "quench " QUENCH_VERSION;
    page.command = session.options.command;
  }
  Page page;

  /// Side, voxel, unit and topology; surface, boundary vertices and samples. The mesh of the shape is used up.
  void add_shape(LoadedShape& loaded, const ShapeOptions& options);
  /// `skeleton_follows`: leaves most of the triangles to it.
  void add_core(const MedialAxis& axis, const std::vector<DataArray>& measures, bool skeleton_follows);
  void add_skeleton(const SkeletonFamily& family);
  void add_still(const Record& data);
  /// For shapes far from zero: before anything is added.
  void set_origin(const Vec3& low, const Vec3& high);

  std::size_t triangles() const { return used_; }
  /// Writes the page, as one of `outputs`, and adds the section `page` to the report.
  void write(const std::filesystem::path& file, nlohmann::ordered_json& report, const io::OutputGroup& outputs) const;

 private:
  void take(std::size_t triangles);
  std::size_t left_, used_ = 0;
};

/// "armadillo" of armadillo.off or armadillo/core.vtp.
std::string title_of(const std::filesystem::path& file);

}  // namespace quench::program
