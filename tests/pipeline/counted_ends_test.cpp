// SPDX-License-Identifier: Apache-2.0
// Ends of curves that a person counts, of real meshes with default options. QUENCH_TEST_FULL=1: at 512 as well.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "data.h"
#include "full_run.h"
#include "quench/io.h"
#include "quench/pipeline.h"

namespace quench::pipeline {
namespace counted_ends_test {

// Counted by eye; places to a hundredth of the longest side, which is 1 in these files.
struct Counted {
  const char* file;
  std::vector<Vec3> tips;
  std::size_t others;  // at most, at 256
  std::size_t others_at_512;
};

const std::vector<Counted>& counted() {
  static const std::vector<Counted> shapes{
      {"armadillo.off",  // eight fingers, six toes, ears, tail, snout
       {{0.068, 0.805, 0.007},
        {0.039, 0.749, 0.022},
        {0.089, 0.907, 0.085},
        {0.083, 0.854, 0.027},
        {0.748, 0.937, 0.12},
        {0.777, 0.895, 0.103},
        {0.806, 0.86, 0.102},
        {0.75, 0.948, 0.171},
        {0.055, 0.01, 0.403},
        {0.083, 0.01, 0.349},
        {0.138, 0.009, 0.327},
        {0.602, 0.016, 0.354},
        {0.657, 0.007, 0.366},
        {0.682, 0.012, 0.423},
        {0.31, 0.981, 0.205},
        {0.523, 0.969, 0.223},
        {0.387, 0.288, 0.755},
        {0.425, 0.758, 0.067}},
       4,
       4},
      {"octopus.off",  // eight arms; others: folds at head and arms
       {{0.635, 0.347, 0.012},
        {0.161, 0.381, 0.125},
        {0.022, 0.526, 0.536},
        {0.248, 0.118, 0.59},
        {0.769, 0.007, 0.673},
        {0.543, 0.44, 0.866},
        {0.254, 0.249, 0.939},
        {0.369, 0.486, 0.962}},
       8,
       8},
      {"neptune.off",  // trident, fingers of one hand, head; others: barbs, fins, folds
       {{0.111, 0.978, 0.005},
        {0.007, 0.954, 0.02},
        {0.061, 0.995, 0.013},
        {0.538, 0.487, 0.416},
        {0.597, 0.509, 0.419},
        {0.571, 0.513, 0.443},
        {0.601, 0.508, 0.398},
        {0.587, 0.504, 0.429},
        {0.3, 0.8, 0.23}},
       26,
       14},
      {"vessel.off",
       {{0.117, 0.571, 0.62},  {0.198, 0.164, 0.811}, {0.044, 0.358, 0.004}, {0.067, 0.329, 0.008},
        {0.175, 0.288, 0.104}, {0.192, 0.612, 0.34},  {0.722, 0.344, 0.39},  {0.002, 0.35, 0.393},
        {0.117, 0.129, 0.436}, {0.339, 0.765, 0.475}, {0.466, 0.691, 0.589}, {0.286, 0.455, 0.828},
        {0.118, 0.557, 0.716}, {0.948, 0.385, 0.87},  {0.482, 0.273, 0.919}, {0.364, 0.013, 0.662},
        {0.396, 0.037, 0.775}, {0.72, 0.011, 0.755},  {0.733, 0.114, 0.895}, {0.91, 0.181, 0.879},
        {0.986, 0.061, 0.873}},
       2,
       2},
      {"elk.off",  // four wheels; its antlers are a sheet
       {{0.456, 0.153, 0.2}, {0.784, 0.173, 0.472}, {0.157, 0.197, 0.558}, {0.493, 0.223, 0.824}},
       1,
       1},
      {"fertility.off", {}, 0, 0},     // loops
      {"bunny_closed.off", {}, 0, 0},  // its ears are sheets
      {"fandisk.off", {}, 0, 0},
      {"kitten.obj", {}, 2, 2}};  // its ears are sheets
  return shapes;
}

void expect_counted(const Counted& shape, std::int64_t resolution) {
  const std::filesystem::path file = data_file("meshes") / shape.file;
  SCOPED_TRACE(std::string(shape.file) + " at " + std::to_string(resolution));
  LoadedShape loaded = load_shape(file, {.resolution = resolution});
  const RunResult result = run(loaded);
  const CurveGraph& graph = result.axis.graph;
  std::vector<Vec3> ends;
  for (const auto& node : graph.nodes)
    if (node.kind == CurveGraph::NodeKind::end) ends.push_back(node.point);
  // A tip that is wide enough for a sheet, as an ear, is the end of that.
  const Skeleton& skeleton = result.axis.skeleton.skeleton;
  const auto is_on_sheet = [&](const Vec3& tip) {
    return std::any_of(skeleton.complex.face_vertices.begin(), skeleton.complex.face_vertices.end(),
                       [&](std::uint32_t v) { return (skeleton.points[v] - tip).norm() < 0.04; });
  };
  std::vector<char> known(ends.size(), 0);
  std::size_t curves = 0;
  for (const Vec3& tip : shape.tips) {
    std::size_t nearest = ends.size();
    for (std::size_t e = 0; e < ends.size(); ++e)
      if (!known[e] && (nearest == ends.size() || (ends[e] - tip).norm() < (ends[nearest] - tip).norm())) nearest = e;
    if ((nearest == ends.size() || (ends[nearest] - tip).norm() >= 0.04) && is_on_sheet(tip)) continue;
    ASSERT_LT(nearest, ends.size()) << "no end is left for the tip at " << tip.transpose();
    EXPECT_LT((ends[nearest] - tip).norm(), 0.04) << "of the tip at " << tip.transpose();
    known[nearest] = 1;
    ++curves;
  }
  EXPECT_LE(ends.size() - curves, resolution < 512 ? shape.others : shape.others_at_512);
}

class CountedEnds : public testing::TestWithParam<std::size_t> {};

TEST_P(CountedEnds, AreFound) {
  REQUIRE_DATA("meshes");
  const Counted& shape = counted()[GetParam()];
  expect_counted(shape, 256);
  if (full_run()) expect_counted(shape, 512);
}

INSTANTIATE_TEST_SUITE_P(Data, CountedEnds, testing::Range(std::size_t{0}, counted().size()), [](const auto& of) {
  return std::filesystem::path(counted()[of.param].file).stem().string();
});

}  // namespace counted_ends_test
}  // namespace quench::pipeline
