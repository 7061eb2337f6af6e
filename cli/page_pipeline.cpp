// SPDX-License-Identifier: Apache-2.0
#include "page_pipeline.h"

#include <fmt/format.h>

#include <algorithm>

#include "option_checks.h"
#include "page_program.h"

namespace quench::program {

void add_page_options(CLI::App& app, PageOptions& o) {
  add_number<std::size_t>(
      app, "--max-triangles", o.max_triangles,
      "The page: at most so many triangles, 1000 to 50000000; larger results are simplified for display, and the page "
      "says so",
      1000, 50'000'000)
      ->type_name("N")
      ->capture_default_str()
      ->group("Page");
}

bool has_page_program() { return !page_program().empty(); }

void require_page_program() {
  if (!has_page_program())
    throw Error(ErrorCode::failed,
                "this quench was built without its interactive page; build it again with Node.js and npm installed");
}

std::string title_of(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::path whole = std::filesystem::absolute(file, ignored).lexically_normal();
  std::filesystem::path stem = whole.stem();
  if (stem.extension() == ".nii") stem = stem.stem();
  if ((stem == "core" || stem == "skeleton") && whole.parent_path().has_filename())
    return whole.parent_path().filename().string();
  return stem.string();
}

void PageBuilder::take(std::size_t triangles) {
  used_ += triangles;
  left_ -= std::min(left_, triangles);
}

void PageBuilder::set_origin(const Vec3& low, const Vec3& high) {
  const double far = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  if (far > 16 * (high - low).maxCoeff()) page.origin = (0.5 * (low + high)).array().round();
}

void PageBuilder::add_shape(LoadedShape& loaded, const ShapeOptions& options) {
  page.side = loaded.longest_side;
  page.voxel = loaded.shape.grid().spacing.minCoeff();
  page.unit = loaded.coordinates.units;
  page.topology = loaded.topology;
  const ForegroundOptions& f = options.foreground;
  const bool cleaned = f.largest_component || f.min_component > 0 || f.fill_cavities;
  // What is looked at is what is around it: a fifth of the triangles.
  if (loaded.mesh && !cleaned)
    take(add_surface(page, *loaded.mesh, left_ / 5));
  else
    take(add_surface(page, loaded.shape, left_ / 5));
  loaded.mesh.reset();
  add_sites(page, loaded.shape);
  add_samples(page, loaded.shape);
}

void PageBuilder::add_core(const MedialAxis& axis, const std::vector<DataArray>& measures, bool skeleton_follows) {
  take(quench::add_core(page, axis, measures, skeleton_follows ? left_ / 3 : left_));
}

void PageBuilder::add_skeleton(const SkeletonFamily& family) { take(quench::add_skeleton(page, family, left_)); }

void PageBuilder::add_still(const Record& data) { take(quench::add_still(page, data, left_)); }

void PageBuilder::write(const std::filesystem::path& file, nlohmann::ordered_json& report,
                        const io::OutputGroup& outputs) const {
  write_page(file, page, page_program());
  auto& section = report["page"];
  section = {{"file", file.string()}, {"triangles", used_}, {"notes", page.notes}};
  section["bytes"] = outputs.size_of(file);
  const auto floor = [&](const char* name, const std::optional<double>& value) {
    if (value) section["floor"][name] = *value;
  };
  floor("lambda", page.lambda_floor);
  floor("theta2", page.theta2_floor);
  floor("theta1", page.theta1_floor);
}

}  // namespace quench::program
