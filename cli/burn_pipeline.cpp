// SPDX-License-Identifier: Apache-2.0
#include "burn_pipeline.h"

#include <fmt/format.h>

#include "axis_input.h"
#include "base/text.h"
#include "option_checks.h"
#include "quench/geometry.h"

namespace quench::program {

void add_burn_options(CLI::App& app, BurnPipelineOptions& o) {
  const auto group = "Burning";
  app.add_option("--omega", o.omega,
                 "Distance of nodes along edges: a fraction of the longest side (0.005), 0.5vox, 2abs, or 'auto': half "
                 "the mean edge (0.35 for triangles), for an erosion thickness right to about 0.3%")
      ->type_name("LENGTH")
      ->capture_default_str()
      ->group(group);
  app.add_option("--radius", o.radius,
                 "The radius between vertices: 'exact' where neighbours share a nearest boundary point, 'linear', or "
                 "'auto': exact for voxel cores of Quench, linear for others")
      ->type_name("RULE")
      ->check(one_of({"auto", "exact", "linear"}))
      ->capture_default_str()
      ->group(group);
}

void check_burn_options(const BurnPipelineOptions& options) {
  if (options.omega == "auto") return;
  const Length omega = parse_length(options.omega, "--omega");
  if (!(omega.value > 0) || std::isinf(omega.value))
    throw Error(
        ErrorCode::usage,
        fmt::format("--omega '{}' is not a distance between nodes; give a length above 0, or 'auto'", options.omega));
}

void take_burn_parameters(BurnPipelineOptions& options, const Record& burned) {
  if (const auto omega = field_number(burned, "omega"); options.omega == "auto" && omega)
    options.omega = fmt::format("{}abs", *omega);
  if (const auto name = field_text(burned, "propagation")) options.propagation = *name;
  if (const auto rule = field_text(burned, "radius_rule"); options.radius == "auto" && rule) options.radius = *rule;
}

Burning compute_burning(const MedialAxis& axis, bool voxel_core, const BurnPipelineOptions& options, bool parents,
                        const std::function<double(const std::string&, const std::string&)>& resolve,
                        nlohmann::ordered_json& report, Session& session) {
  BurnOptions burn_options;
  const bool linear = options.radius == "linear" || (options.radius == "auto" && !voxel_core);
  burn_options.radius = linear ? RadiusRule::linear : RadiusRule::exact;
  burn_options.parents = parents;
  burn_options.omega = options.omega == "auto" ? 0 : resolve(options.omega, "--omega");
  session.check_memory(predicted_burn_bytes(axis.complex, axis.points, burn_options),
                       fmt::format("burning with --omega {}", options.omega),
                       {"a larger --omega", "a larger --lambda"});
  Burning burning = burn(axis.complex, axis.points, axis.radius, burn_options, &session.context);
  session.detail(fmt::format("burned on {} nodes, {:.4g} apart; longest burn time {:.6g}", burning.node_count,
                             burning.options.omega, burning.max_burn_time));
  if (burning.unburned > 0)
    session.say(
        fmt::format("note: {} of {} {} on closed pockets, where no fire comes: the burn time there is infinite (array "
                    "'unburned')",
                    burning.unburned, base::counted(axis.complex.vertex_count, "vertex", "vertices"),
                    burning.unburned == 1 ? "lies" : "lie"));
  report["burn"] = {{"omega", burning.options.omega}, {"nodes", burning.node_count},
                    {"unburned", burning.unburned},   {"max_burn_time", burning.max_burn_time},
                    {"propagation", "segments"},      {"radius_rule", linear ? "linear" : "exact"}};
  return burning;
}

}  // namespace quench::program
