// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "burning/burn_sequence.h"
#include "quench/burn.h"
#include "quench/error.h"
#include "record/infinite.h"

namespace quench {
namespace {

void put(std::vector<DataArray>& arrays, DataArray array) {
  const auto same =
      std::find_if(arrays.begin(), arrays.end(), [&](const DataArray& a) { return a.name == array.name; });
  if (same != arrays.end())
    *same = std::move(array);
  else
    arrays.push_back(std::move(array));
}

}  // namespace

void add_burning(Record& data, const Burning& burning, std::vector<DataArray> sequence) {
  if (burning.burn_time.size() != data.points.size())
    throw Error(ErrorCode::invariant, "the burned medial axis has other vertices than its file");
  put(data.point_data, {"burn_time", 1, record::finite(burning.burn_time)});
  put(data.point_data, {"erosion_thickness", 1, record::finite(burning.erosion_thickness)});
  put(data.point_data, {"unburned", 1, record::flags_of_infinite(burning.burn_time)});
  const auto text = [](const char* word) { return std::vector<std::string>{word}; };
  const BurnOptions& o = burning.options;
  if (!o.plane) {  // there, there are no nodes
    put(data.field_data, {"omega", 1, std::vector<double>{o.omega}});
    put(data.field_data, {"propagation", 1, text(o.propagation == Propagation::windows ? "windows" : "segments")});
    put(data.field_data, {"radius_rule", 1, text(o.radius == RadiusRule::exact ? "exact" : "linear")});
    put(data.field_data, {"burn_nodes", 1, std::vector<std::int64_t>{burning.node_count}});
  }
  put(data.field_data, {"max_burn_time", 1, std::vector<double>{burning.max_burn_time}});
  burning::drop_sequence(data);
  for (DataArray& array : sequence) data.field_data.push_back(std::move(array));
}

}  // namespace quench
