// SPDX-License-Identifier: Apache-2.0
#include "burning/burn_sequence.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "base/parallel.h"
#include "burning/polygon_view.h"
#include "quench/axis.h"
#include "quench/error.h"

/// The burn sequence in files (docs/user/files.md): per state the time above the radius in steps, the parent as a place
/// among the nodes of the state's polygons, and the order of removal among the sectors of a vertex. The network of
/// nodes, which numbers the states, is rebuilt from the axis.
namespace quench::burning {
namespace {

constexpr std::int32_t kNeverInFiles = std::numeric_limits<std::int32_t>::min();
/// Counts the ways in which sequences were written: a file of another one does not fit its axis, and is burned again.
constexpr std::uint64_t kEncoding = 1;

/// Exact but for the sum, as a step is a power of two: the same number wherever it is computed.
double time_at(double radius, std::int32_t steps, double step) { return radius + steps * step; }

/// A power of two: at most a 4096th of omega, unless the longest time has too many of these. (With radii that are not
/// distances, fire can come to a node before its radius.)
double step_for(double omega, double longest) {
  const double fine = std::ldexp(1.0, std::ilogb(omega) - 12);
  const double fits = longest > 0 ? std::ldexp(1.0, std::ilogb(longest) - 28) : 0.0;
  return std::max({fine, fits, std::numeric_limits<double>::min()});
}

/// Calls visit(state, radius of its node) for every state, in order.
template <class Visit>
void for_each_state(const BurnDomain& domain, const Visit& visit) {
  const BurnNetwork& network = domain.network;
  std::uint32_t state = 0;
  for (std::uint32_t v = 0; v < domain.complex.vertex_count; ++v)
    while (state < network.vertex_base[v + 1]) visit(state++, domain.radius[v]);
  for (std::uint32_t e = 0; e < domain.complex.edges.size(); ++e) {
    const std::uint32_t sectors = network.sectors_of(e);
    for (std::uint32_t i = 1; sectors > 0 && i < network.pieces[e]; ++i) {
      const double radius = domain.radius_inside(e, i);
      for (std::uint32_t s = 0; s < sectors; ++s) visit(state++, radius);
    }
  }
}

/// Calls visit(first state, number of states) for every vertex of more than one sector.
template <class Visit>
void for_each_shared_vertex(const BurnNetwork& network, const Visit& visit) {
  for (std::size_t v = 0; v + 1 < network.vertex_base.size(); ++v)
    if (const std::uint32_t count = network.vertex_base[v + 1] - network.vertex_base[v]; count > 1)
      visit(network.vertex_base[v], count);
}

class Fingerprint {
 public:
  template <class T>
  void add(std::span<const T> values) {
    const std::size_t bytes = values.size_bytes();
    mix(bytes);
    const char* const data = reinterpret_cast<const char*>(values.data());
    for (std::size_t at = 0; at < bytes; at += sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::memcpy(&word, data + at, std::min(sizeof word, bytes - at));
      mix(word);
    }
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(std::span<const T>(values));
  }
  void mix(std::uint64_t word) {
    value_ = (value_ ^ word) * 0x9E3779B97F4A7C15ull;
    value_ ^= value_ >> 32;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = kEncoding;
};

// ---------------------------------------------------------------------------------------------------------- numbers

/// Numbers that are small but for a few: a byte each, 255 where the number is in a list of its own.
struct SmallNumbers {
  std::vector<std::uint8_t> bytes;
  std::vector<std::int32_t> large;
  static constexpr std::uint8_t kLarge = 255;

  /// False when the number is too large for any list.
  bool put(std::uint64_t number) {
    bytes.push_back(number < kLarge ? static_cast<std::uint8_t>(number) : kLarge);
    if (number >= kLarge) large.push_back(static_cast<std::int32_t>(number));
    return number <= std::numeric_limits<std::int32_t>::max();
  }
};

/// Takes the numbers out again.
class SmallNumbersReader {
 public:
  /// `large_taken`: how many of the large ones have been taken, by all readers of the list.
  SmallNumbersReader(const std::vector<std::uint8_t>& bytes, const std::vector<std::int32_t>& large,
                     std::size_t& large_taken)
      : bytes_(bytes), large_(large), large_taken_(large_taken) {}
  /// The next one of `bytes.size()`; nothing where the list of large ones is damaged.
  std::optional<std::uint32_t> next() {
    const std::uint8_t byte = bytes_[at_++];
    if (byte != SmallNumbers::kLarge) return byte;
    if (large_taken_ == large_.size() || large_[large_taken_] < 0) return {};
    return static_cast<std::uint32_t>(large_[large_taken_++]);
  }

 private:
  const std::vector<std::uint8_t>& bytes_;
  const std::vector<std::int32_t>& large_;
  std::size_t& large_taken_;
  std::size_t at_ = 0;
};

// ---------------------------------------------------------------------------------------------------------- parents

// The parent of a state lies on the boundary of one of its polygons. Its number is 0 where there is none, else
// way * polygons + polygon: the polygon in the order of for_each_place(), the way along its boundary from the state's
// own node, 1 to the next one, 2 to the one before, 3 to the one after the next ...

std::uint32_t way_to(std::uint32_t from, std::uint32_t to, std::uint32_t nodes) {
  const std::uint32_t ahead = (to + nodes - from) % nodes;
  return 2 * ahead <= nodes ? 2 * ahead - 1 : 2 * (nodes - ahead);
}
/// The place a way leads to; `from` itself where it goes more than around.
std::uint32_t end_of_way(std::uint32_t from, std::uint32_t way, std::uint32_t nodes) {
  const std::uint32_t steps = (way + 1) / 2;
  if (steps >= nodes) return from;
  return (from + (way % 2 == 1 ? steps : nodes - steps)) % nodes;
}

std::uint32_t nodes_of(const PolygonView& view) {
  std::uint32_t nodes = 0;
  for (std::uint32_t i = 0; i < view.side_count(); ++i) nodes += view.side(i).pieces;
  return nodes;
}
/// The node at a place of the boundary.
std::uint32_t node_at(const PolygonView& view, std::uint32_t place) {
  std::uint32_t i = 0;
  for (; place >= view.side(i).pieces; ++i) place -= view.side(i).pieces;
  return view.node(i, place);
}

/// The place of a node on the boundary.
std::uint32_t place_of(const BurnDomain& domain, const PolygonView& view, std::uint32_t node) {
  std::uint32_t place = 0;
  for (std::uint32_t i = 0; i < view.side_count(); ++i) {
    const Polygons::Side& side = view.side(i);
    const std::uint32_t inside = node - domain.network.node_base[side.edge];  // wraps around where it is not
    if (view.node(i, 0) == node) break;
    if (node >= domain.complex.vertex_count && inside < side.pieces - 1u) return place + side.along_edge(inside + 1);
    place += side.pieces;
  }
  return place;
}

std::uint64_t parent_number(const BurnDomain& domain, const BurnedSectors& sectors, std::uint32_t state) {
  if (sectors.parent[state] == kNone) return 0;
  std::uint64_t way = 0, polygon = 0, polygons = 0;
  for_each_place(domain, state, [&](const PolygonView& view, const Place& place) {
    if (view.face == sectors.parent_face[state]) {
      const std::uint32_t to = place_of(domain, view, sectors.parent[state]);
      way = way_to(view.place(place.side, place.k), to, nodes_of(view));
      polygon = polygons;
    }
    ++polygons;
  });
  return way * polygons + polygon;
}

/// Sets the parent; false where the number is that of none.
bool take_parent(const BurnDomain& domain, std::uint32_t state, std::uint32_t number, BurnedSectors& sectors) {
  if (number == 0) return true;
  std::uint32_t polygons = 0;
  for_each_place(domain, state, [&](const PolygonView&, const Place&) { ++polygons; });
  const std::uint32_t way = number / polygons, polygon = number % polygons;
  bool good = false;
  std::uint32_t met = 0;
  for_each_place(domain, state, [&](const PolygonView& view, const Place& place) {
    if (met++ != polygon) return;
    const std::uint32_t from = view.place(place.side, place.k), to = end_of_way(from, way, nodes_of(view));
    good = to != from && !domain.network.pocket[view.face];
    sectors.parent[state] = node_at(view, to);
    sectors.parent_face[state] = view.face;
  });
  return good;
}

// ------------------------------------------------------------------------------------------------------------ arrays

// The arrays of a sequence in a file. Per state: the time above the radius in steps, or kNeverInFiles; the number of
// the parent. Per state of a vertex that has several: its place in the order in which they were removed. Large numbers
// of the parents, then of the order. The step. The fingerprints of the axis and of the arrays before.
constexpr const char *kSteps = "sequence_steps", *kParents = "sequence_parents", *kOrder = "sequence_order",
                     *kLargeNumbers = "sequence_large", *kStep = "sequence_step", *kFingerprints = "sequence_of";
constexpr const char* kContents[] = {kSteps, kParents, kOrder, kLargeNumbers, kStep};

template <class T>
const std::vector<T>* values_of(const Record& data, const char* name) {
  const DataArray* array = find_array(data.field_data, name);
  return array ? std::get_if<std::vector<T>>(&array->values) : nullptr;
}

bool take_times(const BurnDomain& domain, const std::vector<std::int32_t>& steps, BurnedSectors& sectors) {
  sectors.state_time.resize(steps.size());
  bool good = true;
  for_each_state(domain, [&](std::uint32_t state, double radius) {
    const bool never = steps[state] == kNeverInFiles;
    const double time = never ? kNever : time_at(radius, steps[state], sectors.step);
    good = good && (never || std::isfinite(time));
    sectors.state_time[state] = time;
  });
  return good;
}

bool take_parents(const BurnDomain& domain, SmallNumbersReader& numbers, BurnedSectors& sectors) {
  const std::uint32_t states = domain.network.state_count();
  sectors.parent.assign(states, kNone);
  sectors.parent_face.assign(states, kNone);
  for (std::uint32_t s = 0; s < states; ++s)
    if (const auto number = numbers.next(); !number || !take_parent(domain, s, *number, sectors)) return false;
  return true;
}

bool take_order(const BurnNetwork& network, SmallNumbersReader& numbers, BurnedSectors& sectors) {
  sectors.rank.assign(network.state_count(), kNone);
  bool good = true;
  for_each_shared_vertex(network, [&](std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t s = first; good && s < first + count; ++s) {
      const auto number = numbers.next();
      good = number.has_value();
      sectors.rank[s] = number.value_or(kNone);
    }
  });
  return good;
}

/// Whether the arrays are a sequence of the network.
bool take_sequence(const BurnDomain& domain, const Record& data, BurnedSectors& sectors) {
  const auto *steps = values_of<std::int32_t>(data, kSteps), *large = values_of<std::int32_t>(data, kLargeNumbers);
  const auto *parents = values_of<std::uint8_t>(data, kParents), *order = values_of<std::uint8_t>(data, kOrder);
  const auto* step = values_of<double>(data, kStep);
  if (!steps || !large || !parents || !order || !step || step->size() != 1) return false;
  std::size_t shared = 0;
  for_each_shared_vertex(domain.network, [&](std::uint32_t, std::uint32_t count) { shared += count; });
  const std::size_t states = domain.network.state_count();
  if (steps->size() != states || parents->size() != states || order->size() != shared) return false;
  sectors.step = step->front();
  std::size_t large_taken = 0;
  SmallNumbersReader parent_numbers(*parents, *large, large_taken), order_numbers(*order, *large, large_taken);
  return take_times(domain, *steps, sectors) && take_parents(domain, parent_numbers, sectors) &&
         take_order(domain.network, order_numbers, sectors) && large_taken == large->size();
}

}  // namespace

Burning burning_with(const BurnDomain& domain, std::shared_ptr<BurnedSectors> sectors, const BurnOptions& options) {
  Burning result;
  result.options = options;
  result.burn_time.assign(domain.radius.begin(), domain.radius.end());
  result.erosion_thickness.resize(domain.radius.size());
  for (std::uint32_t v = 0; v < domain.complex.vertex_count; ++v) {
    double& time = result.burn_time[v];
    for (std::uint32_t s = domain.network.vertex_base[v]; s < domain.network.vertex_base[v + 1]; ++s)
      time = std::max(time, sectors->state_time[s]);
    result.erosion_thickness[v] = time - domain.radius[v];
    if (std::isinf(time))
      ++result.unburned;
    else
      result.max_burn_time = std::max(result.max_burn_time, time);
  }
  result.node_count = domain.network.node_count();
  result.sectors = std::move(sectors);
  return result;
}

void round_times(const BurnDomain& domain, Times& times, BurnedSectors& sectors) {
  double longest = 0;
  for_each_state(domain, [&](std::uint32_t state, double radius) {
    if (times[state] < kNever) longest = std::max(longest, std::abs(times[state] - radius));
  });
  sectors.step = step_for(domain.network.omega, longest);
  for_each_state(domain, [&](std::uint32_t state, double radius) {
    if (double& time = times[state]; time < kNever)
      time = time_at(radius, static_cast<std::int32_t>(std::lround((time - radius) / sectors.step)), sectors.step);
  });
}

std::uint64_t fingerprint(const BurnDomain& domain) {
  Fingerprint result;
  const CellComplex& complex = domain.complex;
  result.add(complex.edges);
  result.add(complex.face_offsets);
  result.add(complex.face_vertices);
  result.add(complex.face_edges);
  result.add(domain.points);
  result.add(domain.radius);
  result.add(domain.network.pieces);
  result.add(domain.network.corner_state);
  result.mix(std::bit_cast<std::uint64_t>(domain.network.omega));
  result.mix(static_cast<std::uint64_t>(domain.rule));
  return result.value();
}

std::uint64_t fingerprint(const std::vector<DataArray>& arrays) {
  Fingerprint result;
  for (const char* name : kContents)
    if (const DataArray* array = find_array(arrays, name))
      std::visit(
          [&]<class T>(const std::vector<T>& values) {
            if constexpr (std::is_arithmetic_v<T>) result.add(values);
          },
          array->values);
  return result.value();
}

void drop_sequence(Record& data) {
  std::erase_if(data.field_data, [](const DataArray& array) {
    return array.name == kFingerprints || std::ranges::find(kContents, array.name) != std::end(kContents);
  });
}

}  // namespace quench::burning

namespace quench {

using namespace burning;

std::vector<DataArray> burn_sequence(const MedialAxis& axis, const Burning& burning) {
  if (!burning.sectors || !burning.options.parents || !burning.options.rounded)
    throw Error(ErrorCode::usage, "files keep the sequence of a burning with BurnOptions::parents and rounded");
  const BurnedSectors& sectors = *burning.sectors;
  const BurnDomain domain{axis.complex, axis.points, axis.radius, sectors.network, burning.options.radius};
  std::vector<std::int32_t> steps(sectors.state_time.size(), kNeverInFiles);
  for_each_state(domain, [&](std::uint32_t state, double radius) {
    if (const double time = sectors.state_time[state]; time < kNever)
      steps[state] = static_cast<std::int32_t>(std::lround((time - radius) / sectors.step));
  });
  SmallNumbers parents, order;
  bool fits = true;
  for (std::uint32_t s = 0; s < sectors.parent.size(); ++s) fits &= parents.put(parent_number(domain, sectors, s));
  std::vector<std::uint32_t> by_rank;
  for_each_shared_vertex(sectors.network, [&](std::uint32_t first, std::uint32_t count) {
    by_rank.assign(sectors.rank.begin() + first, sectors.rank.begin() + first + count);
    std::sort(by_rank.begin(), by_rank.end());
    for (std::uint32_t s = first; s < first + count; ++s)
      fits &= order.put(static_cast<std::uint64_t>(std::lower_bound(by_rank.begin(), by_rank.end(), sectors.rank[s]) -
                                                   by_rank.begin()));
  });
  if (!fits) return {};
  parents.large.insert(parents.large.end(), order.large.begin(), order.large.end());
  std::vector<DataArray> result;
  result.push_back({kSteps, 1, std::move(steps)});
  result.push_back({kParents, 1, std::move(parents.bytes)});
  result.push_back({kOrder, 1, std::move(order.bytes)});
  result.push_back({kLargeNumbers, 1, std::move(parents.large)});
  result.push_back({kStep, 1, std::vector<double>{sectors.step}});
  const std::uint64_t of_arrays = fingerprint(result);
  result.push_back({kFingerprints, 1,
                    std::vector<std::int64_t>{std::bit_cast<std::int64_t>(fingerprint(domain)),
                                              std::bit_cast<std::int64_t>(of_arrays)}});
  return result;
}

std::optional<Burning> kept_burning(const Record& data, const MedialAxis& axis, const BurnOptions& options,
                                    Context* context) {
  const DataArray* array = find_array(data.field_data, kFingerprints);
  if (!array) return {};
  return base::in_arena(context, [&]() -> std::optional<Burning> {
    checkpoint(context, "burn", 0);
    auto sectors = std::make_shared<BurnedSectors>();
    sectors->network = make_network(axis.complex, axis.points, options.omega);
    const BurnDomain domain{axis.complex, axis.points, axis.radius, sectors->network, options.radius};
    const auto* numbers = std::get_if<std::vector<std::int64_t>>(&array->values);
    const auto is = [&](std::size_t i, std::uint64_t number) {
      return numbers && numbers->size() == 2 && std::bit_cast<std::uint64_t>((*numbers)[i]) == number;
    };
    if (!is(0, fingerprint(domain))) {
      note(context,
           "the burn sequence in the file does not fit its medial axis, which was changed after it was burned; it is "
           "burned again");
      return {};
    }
    if (!is(1, fingerprint(data.field_data)) || !take_sequence(domain, data, *sectors)) {
      note(context, "the burn sequence in the file is damaged; the medial axis is burned again");
      return {};
    }
    checkpoint(context, "burn", 1);
    BurnOptions used = options;
    used.parents = used.rounded = true;
    return burning_with(domain, std::move(sectors), used);
  });
}

}  // namespace quench
