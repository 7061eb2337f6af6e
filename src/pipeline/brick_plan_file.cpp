// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "pipeline/brick_files.h"
#include "quench/bricks.h"
#include "quench/error.h"

namespace quench::pipeline {
namespace {

using PlanJson = nlohmann::ordered_json;

constexpr int kPlanFormat = 1;

PlanJson json_of(const Vec3& v) { return {v[0], v[1], v[2]}; }

Vec3 vector_in(const PlanJson& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

PlanJson json_of(const Grid& grid) {
  PlanJson direction;
  for (int column = 0; column < 3; ++column) direction.push_back(json_of(Vec3(grid.direction.col(column))));
  return {{"dims", grid.dims},
          {"spacing", json_of(grid.spacing)},
          {"origin", json_of(grid.origin)},
          {"direction", direction}};
}

Grid grid_in(const PlanJson& json) {
  Grid grid;
  grid.dims = json.at("dims").get<std::array<std::int64_t, 3>>();
  grid.spacing = vector_in(json.at("spacing"));
  grid.origin = vector_in(json.at("origin"));
  for (int column = 0; column < 3; ++column)
    grid.direction.col(column) = vector_in(json.at("direction").at(static_cast<std::size_t>(column)));
  return grid;
}

PlanJson json_of(const std::vector<BrickRound>& rounds) {
  PlanJson list = PlanJson::array();
  for (const BrickRound& round : rounds) {
    PlanJson bricks = PlanJson::array();
    for (const Brick& b : round.bricks) bricks.push_back({b.index[0], b.index[1], b.index[2], b.sites});
    list.push_back({{"side", round.side}, {"bricks", std::move(bricks)}});
  }
  return list;
}

std::vector<BrickRound> rounds_in(const PlanJson& json) {
  std::vector<BrickRound> rounds;
  for (const PlanJson& of : json) {
    BrickRound& round = rounds.emplace_back();
    round.side = of.at("side").get<std::array<std::int64_t, 3>>();
    if (*std::ranges::min_element(round.side) < 1) throw Error(ErrorCode::input, "a box without a side");
    for (const PlanJson& b : of.at("bricks")) {
      const auto numbers = b.get<std::array<std::int64_t, 4>>();
      round.bricks.push_back({{numbers[0], numbers[1], numbers[2]}, numbers[3]});
    }
  }
  return rounds;
}

PlanFile plan_in(const PlanJson& json) {
  PlanFile file;
  BrickPlan& plan = file.plan;
  plan.grid = grid_in(json.at("grid"));
  plan.spacing = integer_spacing(plan.grid);
  Pruning& pruning = plan.options.pruning;
  pruning.measure = json.at("measure") == kLambda ? kLambda : kDetail;
  pruning.threshold = parse_length_or_auto(json.at("threshold_given").get<std::string>(), pruning.measure);
  plan.options.rule = lambda_rule_of(json.at("lambda_rule").get<std::string>()).value();
  plan.low = json.at("low").get<std::array<std::int64_t, 3>>();
  plan.high = json.at("high").get<std::array<std::int64_t, 3>>();
  plan.rounds = rounds_in(json.at("rounds"));
  file.longest_side = json.at("longest_side");
  const Scale scale{file.longest_side, plan.grid.spacing.minCoeff(), auto_detail(plan.grid), false};
  plan.threshold = pruning.threshold ? scale.resolve(*pruning.threshold, pruning.measure) : scale.detail;
  file.topology = {json.at("euler"), json.at("betti").get<std::array<std::int64_t, 3>>()};
  file.coordinates.units = json.at("units");
  file.coordinates.space = json.at("space");
  file.parameters = json.at("parameters");
  file.from_mesh = json.at("from_mesh");
  file.shape_sums = json.at("shape_sums").get<std::vector<std::uint32_t>>();
  if (const PlanJson& surface = json.at("surface"); !surface.is_null()) {
    file.surface = surface_kind_of(surface.at("kind").get<std::string>()).value();
    file.surface_sum = surface.at("sum");
  }
  file.report = json.at("report").dump();
  return file;
}

void require_format(const PlanJson& json, const std::filesystem::path& path) {
  if (!json.is_object() || json.value("format", 0) != kPlanFormat || json.value("version", "") != QUENCH_VERSION)
    throw Error(
        ErrorCode::input,
        fmt::format("'{}' was written by another version of Quench ({}; this is {}); plan again in another "
                    "folder",
                    path.string(), json.is_object() ? json.value("version", "unknown") : "unknown", QUENCH_VERSION));
}

// FNV-1a, 64 bits.
std::uint64_t fingerprint_of(std::string_view text) {
  std::uint64_t hash = 0xCBF29CE484222325ull;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3ull;
  return hash;
}

}  // namespace

std::string text_of(const PlanFile& file) {
  const BrickPlan& plan = file.plan;
  PlanJson json = {{"format", kPlanFormat},
                   {"version", QUENCH_VERSION},
                   {"grid", json_of(plan.grid)},
                   {"measure", plan.options.pruning.measure},
                   {"threshold_given", text_of(plan.options.pruning.threshold)},
                   {"lambda_rule", name_of(plan.options.rule)},
                   {"longest_side", file.longest_side},
                   {"euler", file.topology.euler},
                   {"betti", file.topology.betti},
                   {"units", file.coordinates.units},
                   {"space", file.coordinates.space},
                   {"parameters", file.parameters},
                   {"from_mesh", file.from_mesh},
                   {"low", plan.low},
                   {"high", plan.high},
                   {"rounds", json_of(plan.rounds)},
                   {"shape_sums", file.shape_sums},
                   {"surface", nullptr},
                   {"report", PlanJson::parse(file.report.empty() ? "null" : file.report)}};
  if (file.surface) json["surface"] = {{"kind", name_of(*file.surface)}, {"sum", file.surface_sum}};
  return json.dump(-1, ' ', false, PlanJson::error_handler_t::replace) + "\n";
}

PlanFile read_plan(const std::filesystem::path& work) {
  const std::filesystem::path path = work / "plan.json";
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    throw Error(ErrorCode::input, fmt::format("'{}' holds no plan of bricks", work.string()));
  std::atomic<std::int64_t> read{0};
  const std::string text = WorkFile(path, read).rest();
  const PlanJson json = PlanJson::parse(text, nullptr, false);
  if (json.is_discarded()) refuse_work_file(path, "it is damaged");
  require_format(json, path);
  try {
    PlanFile file = plan_in(json);
    if (file.plan.rounds.empty() || file.shape_sums.size() != shape_files(work, file.plan).count())
      refuse_work_file(path, "it is damaged");
    file.plan.fingerprint = fingerprint_of(text);
    return file;
  } catch (const std::exception&) {  // what is missing, of another type, or out of its range
    refuse_work_file(path, "it is damaged");
  }
}

}  // namespace quench::pipeline
