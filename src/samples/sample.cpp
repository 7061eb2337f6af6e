// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <utility>

#include "quench/error.h"
#include "quench/samples.h"
#include "samples/sample_shapes.h"

namespace quench {
namespace {

using namespace samples;

struct Entry {
  SampleInfo info;
  Sample (*make)(const SampleOptions&);
};

constexpr std::array<Entry, 13> kEntries{{
    {{"ellipsoid", "ellipsoid with semi-axes 1, 0.7, 0.4", ""}, ellipsoid},
    {{"torus", "torus, radii 1 and 0.35: one handle", ""}, torus},
    {{"box", "box with sides 2, 1.4, 1: the textbook medial axis", ""}, box},
    {{"rippled-box", "flat box with small ripples on its large faces", "noise: their height"}, rippled_box},
    {{"bumpy-sphere", "unit sphere with 60 low bumps", "noise: their height"}, bumpy_sphere},
    {{"fin-on-board", "board with a thin fin and a low bump (Yan 2018, Fig. 3.4)", ""}, fin_on_board},
    {{"four-blobs", "four blobs joined by bridges a few voxels thick (Yan 2018, Fig. 2.11)", ""}, four_blobs},
    {{"plate-with-holes", "thin plate with six round holes: six handles", ""}, plate_with_holes},
    {{"hollow-sphere", "ball with a spherical cavity", ""}, hollow_sphere},
    {{"bead-pack", "1728 overlapping beads, a porous body", "seed"}, bead_pack},
    {{"rough-plate", "thin plate with noise on its large faces", "noise: its height, seed"}, rough_plate},
    {{"bars", "three bars, up to 128 times as long as thick", ""}, bars},
    {{"root", "branching root with known branches", "seed, branches, thickness, touching, gaps"}, root},
}};

}  // namespace

double RootBranch::length() const {
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
  return sum;
}

const std::vector<SampleInfo>& built_in_samples() {
  static const std::vector<SampleInfo> list = [] {
    std::vector<SampleInfo> infos;
    for (const Entry& entry : kEntries) infos.push_back(entry.info);
    return infos;
  }();
  return list;
}

Sample make_sample(std::string_view name, const SampleOptions& options) {
  if (!(options.noise >= 0 && options.noise <= 0.1))
    throw Error(ErrorCode::usage, fmt::format("noise '{}' is not a fraction of the side from 0 to 0.1", options.noise),
                "noise");
  if (!(options.fineness > 0 && options.fineness <= 16))
    throw Error(ErrorCode::usage, fmt::format("fineness '{}' is not above 0 and at most 16", options.fineness),
                "fineness");
  if (options.branches < 1 || options.branches > 100000)
    throw Error(ErrorCode::usage, fmt::format("branches '{}' is not a number from 1 to 100000", options.branches),
                "branches");
  if (!(options.thickness >= 0.01 && options.thickness <= 1))
    throw Error(ErrorCode::usage, fmt::format("thickness '{}' is not from 0.01 to 1", options.thickness), "thickness");
  for (const auto& [field, count] : {std::pair{"touching", options.touching}, {"gaps", options.gaps}})
    if (count < 0 || count > options.branches)
      throw Error(ErrorCode::usage, fmt::format("{} '{}' is not a number from 0 to that of the branches", field, count),
                  field);
  for (const Entry& entry : kEntries)
    if (entry.info.name == name) return entry.make(options);
  std::string names;
  for (const Entry& entry : kEntries) names += (names.empty() ? "" : ", ") + std::string(entry.info.name);
  throw Error(ErrorCode::usage, fmt::format("there is no sample '{}'; there are {}", name, names));
}

}  // namespace quench
