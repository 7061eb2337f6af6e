// SPDX-License-Identifier: Apache-2.0
#include "quench/pipeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "quench/axis.h"
#include "quench/error.h"
#include "quench/samples.h"

namespace quench::pipeline {
namespace pipeline_test {

using Unit = Length::Unit;

template <class Use>
void expect_refused(const Use& use, ErrorCode code, const std::string& field, const std::string& part) {
  try {
    use();
    ADD_FAILURE() << "not refused: " << part;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_EQ(error.field(), field) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

LoadedShape torus(const ShapeOptions& options = {.resolution = 32}) {
  return shape_of(make_sample("torus", {}).mesh, options);
}

/// NaN is equal to NaN here.
bool same_bits(const PageArray& a, const PageArray& b) {
  if (a.values.index() != b.values.index()) return false;
  return std::visit(
      [&](const auto& values) {
        const auto& others = std::get<std::decay_t<decltype(values)>>(b.values);
        return std::ranges::equal(std::as_bytes(std::span(values)), std::as_bytes(std::span(others)));
      },
      a.values);
}

// ------------------------------------------------------------------------------------------------------------ lengths

TEST(Lengths, EveryUnitIsResolved) {
  const Scale scale{100, 0.5};
  const auto resolved = [&](const char* text) { return scale.resolve(parse_length(text, "lambda"), "lambda"); };
  EXPECT_DOUBLE_EQ(resolved("0.02"), 2);
  EXPECT_DOUBLE_EQ(resolved("2.5%"), 2.5);
  EXPECT_DOUBLE_EQ(resolved("12vox"), 6);
  EXPECT_DOUBLE_EQ(resolved("3.5abs"), 3.5);
  EXPECT_EQ(resolved("inf"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(resolved("0"), 0);
}

TEST(Lengths, WhatIsNotALengthIsRefusedByItsField) {
  for (const char* bad : {"", "x", "nan", "3 vox", "3voxels", "1e999", "%", "-inf", "+1"})
    expect_refused([&] { parse_length(bad, "theta2"); }, ErrorCode::usage, "theta2",
                   "theta2 '" + std::string(bad) + "' is not a length");
  expect_refused([] { parse_length("-1", "lambda"); }, ErrorCode::usage, "lambda", "lambda '-1' is negative");
  expect_refused([] { parse_omega("0"); }, ErrorCode::usage, "omega", "omega '0' is not a distance");
  expect_refused([] { parse_omega("inf"); }, ErrorCode::usage, "omega", "omega 'inf' is not a distance");
  expect_refused([] { parse_resample("inf"); }, ErrorCode::usage, "resample", "resample 'inf' is not a distance");
  expect_refused(
      [] {
        Scale{100, 0}.resolve(parse_length("2vox", "theta1"), "theta1");
      },
      ErrorCode::usage, "theta1", "theta1 '2vox' needs a voxel size");
}

TEST(Lengths, TextsAreKeptAndReadBack) {
  for (const char* text : {"0.020", "2%", "2.5vox", "3e-1abs", "inf"})
    EXPECT_EQ(text_of(parse_length(text, "lambda")), text);
  for (const Length& length :
       {Length{0.125}, Length{2.5, Unit::voxels}, Length{1e-7, Unit::absolute}, Length{0, Unit::infinite}}) {
    const Length back = parse_length(text_of(length), "lambda");
    EXPECT_EQ(back.unit, length.unit);
    EXPECT_EQ(back.value == length.value, length.unit != Unit::infinite);
  }
  EXPECT_EQ(text_of(parse_length_or_auto("auto", "lambda")), "auto");
  EXPECT_FALSE(parse_omega("auto"));
  EXPECT_EQ(text_of(world_length(0.25)), "0.25abs");
  EXPECT_EQ(text_of(world_length(std::numeric_limits<double>::infinity())), "inf");
}

TEST(Lengths, SpacingsAreOneTwoOrThreePositiveNumbers) {
  EXPECT_EQ(spacing_in("2"), Vec3(2, 2, 2));
  EXPECT_EQ(spacing_in("0.5,0.5,2e1"), Vec3(0.5, 0.5, 20));
  EXPECT_EQ(spacing_in("1,2"), Vec3(1, 2, 0));
  for (const char* bad :
       {"", "0", "-1", "1,", "0,2", "1,0", "1,2,0", "1,2,3,4", "1,2,3,", "1, 2,3", "1,2,x", "inf", "1;2;3"})
    EXPECT_FALSE(spacing_in(bad)) << bad;
}

TEST(Names, AreReadBack) {
  for (const LambdaRule rule : {LambdaRule::coface, LambdaRule::ball}) EXPECT_EQ(lambda_rule_of(name_of(rule)), rule);
  for (const RadiusRule rule : {RadiusRule::exact, RadiusRule::linear}) EXPECT_EQ(radius_rule_of(name_of(rule)), rule);
  EXPECT_FALSE(lambda_rule_of("exact") || radius_rule_of("auto") || radius_rule_of(""));
}

// ------------------------------------------------------------------------------------------------------------- memory

TEST(MemoryPlan, WorksInBricksOnlyWhereThatHelpsAndIsNeeded) {
  const LoadedShape box = shape_of(make_sample("box", {}).mesh, {.resolution = 64});
  Context plenty, little;
  plenty.memory_limit = std::int64_t{1} << 40;
  little.memory_limit = 1 << 20;
  const CorePlan at_once = plan_core(box.shape, &plenty), in_bricks = plan_core(box.shape, &little);
  EXPECT_FALSE(at_once.in_bricks);
  EXPECT_EQ(at_once.bytes(), predicted_core_bytes(box.shape));
  EXPECT_EQ(at_once.sites, count_boundary_vertices(box.shape));
  EXPECT_GT(at_once.held, 0);
  EXPECT_EQ(in_bricks.in_bricks, in_bricks.bricks < in_bricks.at_once);
  EXPECT_EQ(in_bricks.bytes(), std::min(in_bricks.bricks, in_bricks.at_once));
}

TEST(MemoryPlan, WhatDoesNotFitIsRefusedWithFiguresAndRemedies) {
  Context context;
  context.memory_limit = 1 << 20;
  expect_refused([&] { core_of(torus(), {}, &context); }, ErrorCode::failed, "memory_limit",
                 "1.0 MB are allowed; use a lower resolution");
  expect_refused(
      [&] {
        require_memory(std::int64_t{3} << 30, "it", {"less", "another"}, &context);
      },
      ErrorCode::failed, "memory_limit", "it needs about 3.0 GB of memory, and 1.0 MB are allowed; use less, another");
  require_memory(1 << 20, "as much as is allowed", {}, &context);
}

// -------------------------------------------------------------------------------------------------------------- shape

TEST(ShapeOfInput, ParametersGiveTheSameShapeAgain) {
  ShapeOptions options;
  options.resolution = 24;
  options.fill = FillRule::evenodd;
  options.subdivide = 2;
  options.foreground.largest_component = true;
  const LoadedShape shape = torus(options);
  EXPECT_EQ(
      shape.parameters,
      R"({"resolution":24,"fill":"evenodd","topology":"mesh","surface":"mesh","largest_component":true,"subdivide":2})");
  const CoreResult core = core_of(shape, {.pruning = {kLambda, parse_length("2vox", "lambda")}});
  const Record file = core_file(core);
  EXPECT_EQ(core.parameters,
            shape.parameters.substr(0, shape.parameters.size() - 1) + R"(,"lambda":"2vox","lambda_rule":"coface"})");
  ShapeOptions again;
  EXPECT_EQ(take_recorded(again, file, "core.vtp"), std::vector<std::string>{"resolution"});
  const LoadedShape repeated = torus(again);
  EXPECT_TRUE(std::ranges::equal(repeated.shape.runs(), shape.shape.runs()));
  EXPECT_EQ(repeated.parameters, shape.parameters);
}

TEST(ShapeOfInput, ResultsThatDoNotNameATopologyAreGaussDigitizations) {
  ShapeOptions options;
  options.resolution = 24;
  options.topology = TopologyRule::voxels;
  const LoadedShape shape = torus(options);
  EXPECT_EQ(shape.parameters, R"({"resolution":24,"fill":"nonzero","surface":"mesh"})");
  ShapeOptions again;
  take_recorded(again, core_file(core_of(shape)), "core.vtp");
  EXPECT_EQ(again.topology, TopologyRule::voxels);
  again.topology = TopologyRule::mesh;  // given
  take_recorded(again, core_file(core_of(shape)), "core.vtp");
  EXPECT_EQ(again.topology, TopologyRule::mesh);
}

TEST(ShapeOfInput, WhatIsGivenIsNotTakenFromAResult) {
  Record file;
  file.field_data.push_back(
      {"parameters", 1, std::vector<std::string>{R"({"resolution":99,"threshold":20.0,"spacing":"1,1,2"})"}});
  ShapeOptions options;
  options.resolution = 24;
  options.foreground.label = 3;
  EXPECT_EQ(take_recorded(options, file, "core.vtp"), std::vector<std::string>{"spacing"});
  EXPECT_EQ(options.resolution, 24);
  EXPECT_FALSE(options.foreground.threshold);
  EXPECT_EQ(options.spacing, Vec3(1, 1, 2));
  EXPECT_EQ(options.spacing_text, "1,1,2");
}

TEST(ShapeOfInput, ImagesAreRecordedAsTheyAreCut) {
  Volume volume;
  volume.grid.dims = {6, 5, 4};
  std::vector<double> samples(120, 0);
  for (std::size_t i = 40; i < 80; ++i) samples[i] = static_cast<double>(i);
  volume.samples = samples;
  ShapeOptions options;
  options.foreground.threshold = 50.0;
  options.spacing = Vec3(1, 1, 2.5);
  const LoadedShape shape = shape_of(view_of(volume), {"mm", ""}, options);
  EXPECT_EQ(shape.parameters, R"({"threshold":50.0,"spacing":"1,1,2.5","surface":"grey"})");
  EXPECT_EQ(shape.coordinates.units, "mm");
  EXPECT_EQ(shape.shape.voxel_count(), 30);
  EXPECT_EQ(shape.topology_changed(), false);
  options.subdivide = 65;
  expect_refused([&] { shape_of(view_of(volume), {}, options); }, ErrorCode::usage, "subdivide", "subdivide '65'");
}

TEST(Lengths, Theta1MayBeInRadii) {
  EXPECT_FALSE(parse_theta1("auto"));
  EXPECT_EQ(parse_theta1("0.5r")->value, 0.5);
  EXPECT_EQ(parse_theta1("0.5r")->unit, Length::Unit::radii);
  EXPECT_EQ(text_of(parse_theta1("0.5r")), "0.5r");
  EXPECT_EQ(parse_theta1("2%")->unit, Length::Unit::fraction);
  for (const char* text : {"r", "-1r", "nanr", "infr", "1 r", "0.5rr"}) EXPECT_THROW(parse_theta1(text), Error) << text;
  const Scale scale{100, 1, 0.8};
  EXPECT_EQ(theta1_radii_of({}), 0.5);
  EXPECT_EQ(theta1_of({}, scale), 4.5 * 0.8);
  SkeletonOptions options;
  options.theta1 = parse_theta1("2r");
  EXPECT_EQ(theta1_radii_of(options), 2);
  EXPECT_EQ(theta1_of(options, scale), 4.5 * 0.8);
  options.theta1 = parse_theta1("2%");
  EXPECT_EQ(theta1_radii_of(options), 0);
  EXPECT_EQ(theta1_of(options, scale), 2);
}

// ---------------------------------------------------------------------------------------------------------------- run

TEST(Run, IsTheStagesCalledByHand) {
  RunOptions options;
  options.axis.pruning = {kDetail, parse_length("1.5vox", "detail")};
  options.skeleton.theta2 = parse_length("4%", "theta2");
  options.skeleton.theta1 = parse_length("2vox", "theta1");
  options.graph.smooth = 3;
  PageBuilder page(5000), by_hand(5000);
  options.page = &page;
  std::vector<std::string> stages;
  options.on_core = [&](const CoreResult&) { stages.emplace_back("core"); };
  options.on_burned = [&](const BurnFigures&) { stages.emplace_back("burned"); };
  LoadedShape shape = shape_of(make_sample("fin-on-board", {}).mesh, {.resolution = 48});
  const RunResult result = run(shape, options);
  EXPECT_EQ(stages, (std::vector<std::string>{"core", "burned"}));

  const double voxel = shape.scale().voxel, side = shape.longest_side;
  MedialAxis whole = voxel_core(shape.shape);
  add_detail(whole, *shape.surface);
  prune_levels(whole, kDetail);
  const double least = auto_detail(shape.shape.grid());
  MedialAxis first = pruned(whole, least, kDetail);
  fit_to_surface(first, contact_sites(whole, least, kDetail), *shape.surface);
  const MedialAxis core = pruned(first, 1.5 * voxel, kDetail);
  EXPECT_EQ(result.core.axis.points, core.points);
  EXPECT_TRUE(result.core.axis.measure(kDetail).level == core.measure(kDetail).level);
  EXPECT_EQ(medial_axis(shape.shape, *shape.surface, 1.5 * voxel).points, core.points);
  const Burning burning = burn(core, {.radius = RadiusRule::linear, .rounded = true});
  EXPECT_EQ(result.axis.burned.max_burn_time, burning.max_burn_time);
  EXPECT_EQ(find_array(result.axis.file.point_data, "burn_time")->numbers(), burning.burn_time);
  const SkeletonFamily family = skeletons(core, burning);
  Skeleton member = extract(
      family, 0.04 * side, 2 * voxel,
      {.regrow_tips_above = 0.2 * voxel, .regrow_rims_above = 0.5 * voxel, .minor_curve = 4 * shape.scale().detail});
  const std::vector<Vec3> before = member.points;
  smooth_sheets(member, {2 * std::sqrt(3) * voxel, 3, shape.scale().detail});
  for (std::size_t v = 0; v < before.size(); ++v)
    if (member.points[v] != before[v])
      if (const Surface::Foot foot = shape.surface->nearest(member.points[v]); foot.inside)
        member.radius[v] = foot.distance;
  const CurveGraph graph = measured_graph(member, {.smooth = 3, .surface = &*shape.surface});
  const Skeleton skeleton = with_branches(member, graph);
  EXPECT_EQ(result.axis.skeleton.skeleton.points, skeleton.points);
  EXPECT_EQ(result.axis.skeleton.skeleton.complex.edges, skeleton.complex.edges);
  EXPECT_EQ(result.axis.skeleton.skeleton.edge_branch, skeleton.edge_branch);
  EXPECT_EQ(result.axis.skeleton.topology, shape.topology);
  EXPECT_EQ(result.axis.skeleton.reconstructed, reconstructed_share(shape.shape, skeleton));
  ASSERT_EQ(result.axis.graph.branches.size(), graph.branches.size());
  for (std::size_t b = 0; b < graph.branches.size(); ++b)
    EXPECT_EQ(result.axis.graph.branches[b].length, graph.branches[b].length);

  by_hand.add_shape(shape);
  by_hand.page.pruning = {std::string(kDetail), 1.5 * voxel};
  by_hand.page.theta2 = 0.04 * side;
  by_hand.page.theta1 = 2 * voxel;
  by_hand.add_core(core, result.axis.file.point_data, true);
  const FamilyFloor floor = floor_of(options.skeleton, shape.scale(), burning.options.omega);
  EXPECT_FLOAT_EQ(static_cast<float>(floor.theta2), static_cast<float>(0.2 * voxel));
  EXPECT_FLOAT_EQ(static_cast<float>(floor.theta1), static_cast<float>(0.2 * voxel));
  EXPECT_LE(floor.theta1, 0.2 * voxel);
  by_hand.add_skeleton(skeleton, graph);
  by_hand.add_family(with_floor(family, floor.theta2, floor.theta1));
  EXPECT_EQ(page.triangles(), by_hand.triangles());
  ASSERT_EQ(page.page.arrays.size(), by_hand.page.arrays.size());
  for (std::size_t a = 0; a < by_hand.page.arrays.size(); ++a) {
    EXPECT_EQ(page.page.arrays[a].name, by_hand.page.arrays[a].name);
    EXPECT_TRUE(same_bits(page.page.arrays[a], by_hand.page.arrays[a])) << page.page.arrays[a].name;
  }
}

TEST(Run, ThinPruningsAreNoted) {
  LoadedShape shape = shape_of(make_sample("box", {}).mesh, {.resolution = 24});
  std::vector<std::string> notes;
  Context context;
  context.note = [&](const std::string& sentence) { notes.push_back(sentence); };
  const RunResult result = run(shape, {.axis = {.pruning = {kLambda, Length{0, Unit::infinite}}}}, &context);
  ASSERT_LT(result.core.reconstructed, 0.9);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("of the shape; use a smaller lambda"), std::string::npos) << notes[0];
}

TEST(PrunedFurther, IsTheCoreComputedWithThatLambda) {
  const LoadedShape shape = torus();
  const Length lambda = parse_length("3vox", "lambda");
  const CoreResult pruned = pruned_further(shape, core_of(shape, {.pruning = {kLambda, Length{0}}}), lambda);
  const CoreResult wanted = core_of(shape, {.pruning = {kLambda, lambda}});
  EXPECT_EQ(pruned.axis.points, wanted.axis.points);
  EXPECT_EQ(pruned.axis.complex.edges, wanted.axis.complex.edges);
  EXPECT_EQ(pruned.reconstructed, wanted.reconstructed);
  EXPECT_EQ(pruned.kept.faces, wanted.kept.faces);
  EXPECT_EQ(pruned.parameters, wanted.parameters);
  expect_refused([&] { pruned_further(shape, pruned, Length{0}); }, ErrorCode::usage, "lambda",
                 "which the medial axis was pruned with");
}

TEST(AxisOfFile, LengthsOfARecordedBurningAreTaken) {
  LoadedShape shape = torus();
  shape.coordinates = {"mm", "LPS"};
  const CoreResult core = core_of(shape);
  Record file = core_file(core);
  const Burning burning = burning_of(core.axis, false, {}, true, shape.scale());
  add_burning(file, burning);
  const LoadedAxis axis = axis_of(Record(file), "core.vtp");
  EXPECT_FALSE(axis.voxel_core);  // but fitted
  EXPECT_TRUE(axis.scale.fitted);
  EXPECT_EQ(axis.axis.voxel_points, core.axis.voxel_points);
  EXPECT_EQ(axis.axis.voxel_radius, core.axis.voxel_radius);
  EXPECT_EQ(axis.scale.longest_side, shape.longest_side);
  EXPECT_DOUBLE_EQ(axis.scale.voxel, shape.scale().voxel);
  EXPECT_EQ(axis.coordinates.space, "LPS");
  BurningOptions options;
  options.radius = RadiusRule::linear;
  take_recorded(options, axis.data);
  EXPECT_EQ(options.propagation, Propagation::segments);
  EXPECT_EQ(options.radius, RadiusRule::linear);
  EXPECT_EQ(axis.scale.resolve(*options.omega, "omega"), burning.options.omega);
}

}  // namespace pipeline_test
}  // namespace quench::pipeline
