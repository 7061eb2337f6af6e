// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <string_view>
#include <type_traits>

#include "base/constants.h"
#include "base/union_find.h"
#include "verification/burn_network.h"
#include "verification/checks.h"

/// The burn sequence in a file (docs/user/files.md).
namespace quench::verification {

namespace {

constexpr std::int32_t kNeverInFiles = std::numeric_limits<std::int32_t>::min();

/// What the file says of the states.
struct States {
  double step = 0;
  std::vector<std::int32_t> steps;
  std::vector<std::uint32_t> parents, order;
};

/// A number of 64 bits for arrays, as files have it.
class Fingerprint {
 public:
  template <class T>
  void add(const std::vector<T>& values) {
    const std::string_view bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    add(std::uint64_t{bytes.size()});
    for (std::size_t at = 0; at < bytes.size(); at += 8) {
      std::uint64_t word = 0;
      bytes.copy(reinterpret_cast<char*>(&word), 8, at);
      add(word);
    }
  }
  void add(std::uint64_t word) {
    value_ = (value_ ^ word) * 0x9E3779B97F4A7C15u;
    value_ ^= value_ >> 32;
  }
  std::int64_t value() const { return std::bit_cast<std::int64_t>(value_); }

 private:
  std::uint64_t value_ = 1;
};

constexpr const char* kArrays[]{"sequence_steps", "sequence_parents", "sequence_order", "sequence_large",
                                "sequence_step"};

template <class T>
const std::vector<T>* stored(const Record& data, const char* name) {
  const DataArray* array = find_array(data.field_data, name);
  return array ? std::get_if<std::vector<T>>(&array->values) : nullptr;
}

/// Puts the large numbers in the places of the 255s, from the one numbered `taken` on; false where one is missing.
bool expand(const std::vector<std::uint8_t>& bytes, const std::vector<std::int32_t>& large, std::size_t& taken,
            std::vector<std::uint32_t>& numbers) {
  numbers.assign(bytes.begin(), bytes.end());
  for (std::uint32_t& number : numbers) {
    if (number != 255) continue;
    if (taken == large.size() || large[taken] < 255) return false;
    number = static_cast<std::uint32_t>(large[taken++]);
  }
  return true;
}

std::string wrong_form(const Record& data, const BurnNetwork& network, States& states) {
  const auto *steps = stored<std::int32_t>(data, "sequence_steps"),
             *large = stored<std::int32_t>(data, "sequence_large");
  const auto* parents = stored<std::uint8_t>(data, "sequence_parents");
  const auto* order = stored<std::uint8_t>(data, "sequence_order");
  const auto* step = stored<double>(data, "sequence_step");
  if (!steps || !large || !parents || !order || !step || step->size() != 1 || !(step->front() > 0))
    return "an array is not of its type";
  std::size_t shared = 0;
  for (std::size_t v = 0; v + 1 < network.sectors().size(); ++v)
    if (const std::size_t count = network.sectors()[v + 1] - network.sectors()[v]; count > 1) shared += count;
  if (steps->size() != network.states() || parents->size() != network.states() || order->size() != shared)
    return fmt::format(
        "the arrays are of {}, {} and {} states; the axis with this omega has {}, {} of them at vertices "
        "with several",
        steps->size(), parents->size(), order->size(), network.states(), shared);
  std::size_t taken = 0;
  if (!expand(*parents, *large, taken, states.parents) || !expand(*order, *large, taken, states.order) ||
      taken != large->size())
    return fmt::format("'sequence_large' has {} numbers, of which {} are in their places", large->size(), taken);
  states.step = step->front();
  states.steps = *steps;
  return {};
}

std::string wrong_fingerprints(const Result& result, const BurnNetwork& network, double omega, bool exact) {
  const auto* written = stored<std::int64_t>(result.data, "sequence_of");
  if (!written || written->size() != 2) return "'sequence_of' is not two fingerprints";
  Fingerprint axis, arrays;
  const CellComplex& complex = result.complex;
  axis.add(complex.edges);
  for (const auto* list : {&complex.face_offsets, &complex.face_vertices, &complex.face_edges}) axis.add(*list);
  axis.add(result.data.points);
  axis.add(result.ball_radius);
  axis.add(network.pieces());
  axis.add(network.sectors_of_corners());
  axis.add(std::bit_cast<std::uint64_t>(omega));
  axis.add(std::uint64_t{exact ? 0u : 1u});
  if (axis.value() != written->front()) return "its fingerprint in 'sequence_of' is that of another axis";
  for (const char* name : kArrays)
    std::visit(
        [&]<class T>(const std::vector<T>& values) {
          if constexpr (std::is_arithmetic_v<T>) arrays.add(values);
        },
        find_array(result.data.field_data, name)->values);
  return arrays.value() == written->back() ? "" : "its fingerprint in 'sequence_of' is that of other arrays";
}

/// Compares what the file says of the states with the polygons they are in.
class Comparison {
 public:
  Comparison(const Result& result, const BurnNetwork& network, const States& states, double omega, bool exact)
      : result_(result),
        complex_(result.complex),
        network_(network),
        states_(states),
        late_(4 * result.rounding * result.unit + kOffByLabels * omega + 2 * states.step),
        exact_(exact),
        pocket_(pocket_faces(result.complex)),
        time_(network.states(), 0),
        parent_(network.states(), kNone) {
    polygons_ = base::Csr<std::uint32_t>::group(network_.states(), [&](const auto& emit) {
      for_each_polygon([&](std::uint32_t f) {
        for (const Stop& stop : stops_) emit(stop.state, f);
        return std::string();
      });
    });
  }

  /// A sentence about what is wrong; empty when nothing is.
  std::string wrong() {
    std::string text = for_each_polygon([&](std::uint32_t f) { return wrong_times(f); });
    if (text.empty()) text = wrong_burn_times();
    if (text.empty()) text = for_each_polygon([&](std::uint32_t f) { return wrong_arcs(f); });
    if (text.empty()) text = wrong_ancestry();
    if (text.empty()) text = wrong_cycles_of_vertices();
    if (text.empty()) text = wrong_cycles_inside_edges();
    return text.empty() ? wrong_order() : text;
  }
  std::size_t arcs() const { return arcs_; }

 private:
  using Stop = BurnNetwork::Stop;

  /// Calls visit(face), with `stops_` those of the polygon, until it returns a sentence.
  template <class Visit>
  std::string for_each_polygon(const Visit& visit) {
    for (std::uint32_t f = 0; f < complex_.face_count(); ++f) {
      network_.stops_of(f, stops_);
      if (std::string text = visit(f); !text.empty()) return text;
    }
    return {};
  }
  std::string name_of(std::uint32_t state, std::uint32_t face) const {
    return fmt::format("state {} at {}", state, result_.describe_face(face));
  }

  // Infinite on closed pockets, and nowhere else; not before the radius.
  std::string wrong_times(std::uint32_t f) {
    for (const Stop& stop : stops_) {
      const std::int32_t steps = states_.steps[stop.state];
      if ((steps == kNeverInFiles) != (pocket_[f] != 0))
        return fmt::format("{} {}, and is {} a closed pocket", name_of(stop.state, f),
                           pocket_[f] ? "burns" : "does not burn", pocket_[f] ? "in" : "not in");
      if (exact_ && !pocket_[f] && steps < 0) return fmt::format("{} burns before its radius", name_of(stop.state, f));
      time_[stop.state] = pocket_[f] ? std::numeric_limits<double>::infinity() : stop.radius + steps * states_.step;
    }
    return {};
  }

  // The latest time of a vertex is its burn time.
  std::string wrong_burn_times() const {
    const std::vector<double> written = numbers_or_empty(result_.data.point_data, "burn_time");
    for (std::uint32_t v = 0; v < complex_.vertex_count && !written.empty(); ++v) {
      double latest = result_.ball_radius[v];
      for (std::uint32_t s = network_.sectors()[v]; s < network_.sectors()[v + 1]; ++s)
        latest = std::max(latest, time_[s]);
      if (std::isfinite(latest) && !(std::abs(written[result_.rows[v]] - latest) <= kSingle * latest))
        return fmt::format("{} has burn_time {:.9g}; the last of its sectors burns at {:.9g}",
                           result_.describe_vertex(v), written[result_.rows[v]], latest);
    }
    return {};
  }

  // A parent is a node of the same polygon, the arcs from parents do not cross, and fire needs the length of an arc at
  // most, either way.
  std::string wrong_arcs(std::uint32_t f) {
    const auto nodes = static_cast<std::uint32_t>(stops_.size());
    chords_.clear();
    for (std::uint32_t p = 0; p < nodes; ++p) {
      const std::uint32_t state = stops_[p].state, number = states_.parents[state];
      const auto choices = static_cast<std::uint32_t>(polygons_[state].size());
      if (number == 0 || polygons_[state][number % choices] != f) continue;
      const std::uint32_t way = number / choices, away = (way + 1) / 2;
      if (pocket_[f] || way == 0 || away >= nodes)
        return fmt::format("the parent of {} is no node of it", name_of(state, f));
      const std::uint32_t q = (p + (way % 2 == 1 ? away : nodes - away)) % nodes;
      parent_[state] = stops_[q].state;
      ++arcs_;
      chords_.push_back({std::min(p, q), std::max(p, q)});
      const double length = (stops_[p].point - stops_[q].point).norm();
      const double apart = std::abs(time_[state] - time_[stops_[q].state]);
      if (exact_ && !(apart <= length * (1 + kOffAlongEdges) + late_))
        return fmt::format("{} and its parent burn {:.9g} after each other, and are {:.9g} apart", name_of(state, f),
                           apart, length);
    }
    return chords_cross() ? fmt::format("prime arcs cross in {}", result_.describe_face(f)) : std::string();
  }
  bool chords_cross() {
    std::sort(chords_.begin(), chords_.end(),
              [](const auto& a, const auto& b) { return a[0] != b[0] ? a[0] < b[0] : a[1] > b[1]; });
    std::vector<std::uint32_t> open;  // ends of those that are around a place, the innermost last
    for (const auto& [from, to] : chords_) {
      while (!open.empty() && open.back() <= from) open.pop_back();
      if (!open.empty() && open.back() < to) return true;
      open.push_back(to);
    }
    return false;
  }

  // A parent burns before its children, so no state is its own ancestor.
  std::string wrong_ancestry() const {
    constexpr std::uint32_t kGood = kNone;
    std::vector<std::uint32_t> seen_from(parent_.size(), 0);  // 1 + the state from which it was reached first
    for (std::uint32_t s = 0; s < parent_.size(); ++s) {
      std::uint32_t at = s;
      for (; at != kNone && seen_from[at] == 0; at = parent_[at]) seen_from[at] = s + 1;
      if (at != kNone && seen_from[at] == s + 1) return fmt::format("state {} is its own ancestor", at);
      for (at = s; at != kNone && seen_from[at] == s + 1; at = parent_[at]) seen_from[at] = kGood;
    }
    return {};
  }

  // A node has as many parents as its link has independent cycles, with closed pockets contracted. In the link of a
  // vertex sectors join the edges that have not two polygons.
  std::string wrong_cycles_of_vertices() const {
    const std::uint32_t contracted = static_cast<std::uint32_t>(complex_.edges.size());
    std::vector<char> pocket_edge(complex_.edges.size(), 0), pocket_state(network_.sectors().back(), 0);
    for (std::uint32_t f = 0; f < complex_.face_count(); ++f)
      for (const std::uint32_t e : complex_.sides(f)) pocket_edge[e] |= pocket_[f];
    std::vector<std::array<std::uint32_t, 2>> ends(network_.sectors().back(), {kNone, kNone});
    for (std::uint32_t f = 0; f < complex_.face_count(); ++f)
      for (std::uint32_t c = complex_.face_offsets[f]; c < complex_.face_offsets[f + 1]; ++c) {
        const std::uint32_t before = c == complex_.face_offsets[f] ? complex_.face_offsets[f + 1] - 1 : c - 1;
        const std::uint32_t state = network_.sector_of(c);
        pocket_state[state] = pocket_[f];
        for (const std::uint32_t e : {complex_.face_edges[c], complex_.face_edges[before]})
          if (result_.edge_faces_count[e] != 2)
            (ends[state][0] == kNone ? ends[state][0] : ends[state][1]) = pocket_edge[e] ? contracted : e;
      }
    std::vector<std::uint32_t> met;
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v) {
      const std::uint32_t first = network_.sectors()[v], last = network_.sectors()[v + 1];
      met.clear();
      for (std::uint32_t s = first; s < last; ++s)
        if (!pocket_state[s] && ends[s][0] != kNone) met.insert(met.end(), ends[s].begin(), ends[s].end());
      std::sort(met.begin(), met.end());
      met.erase(std::unique(met.begin(), met.end()), met.end());
      const auto place = [&](std::uint32_t e) {
        return static_cast<std::uint32_t>(std::lower_bound(met.begin(), met.end(), e) - met.begin());
      };
      base::UnionFind joined(met.size());
      std::size_t cycles = 0, parents = 0;
      for (std::uint32_t s = first; s < last; ++s) {
        parents += parent_[s] != kNone;
        if (!pocket_state[s]) cycles += ends[s][0] == kNone || !joined.unite(place(ends[s][0]), place(ends[s][1]));
      }
      if (parents != cycles)
        return fmt::format("{} has {} prime arcs, and its link has {} independent cycles", result_.describe_vertex(v),
                           parents, cycles);
    }
    return {};
  }
  // Inside an edge the sectors join its two directions: all but one close a cycle, and all where a pocket is there.
  std::string wrong_cycles_inside_edges() const {
    std::vector<std::size_t> burning(complex_.edges.size(), 0);
    for (std::uint32_t f = 0; f < complex_.face_count(); ++f)
      for (const std::uint32_t e : complex_.sides(f)) burning[e] += !pocket_[f];
    for (std::uint32_t e = 0; e < complex_.edges.size(); ++e) {
      const bool at_pocket = burning[e] < result_.edge_faces_count[e];
      const std::size_t cycles = at_pocket || burning[e] == 0 ? burning[e] : burning[e] - 1;
      const auto [first, nodes, each] = network_.inside(e);
      for (std::uint32_t k = 0; k < nodes; ++k) {
        std::size_t parents = 0;
        for (std::uint32_t s = first + k * each; s < first + (k + 1) * each; ++s) parents += parent_[s] != kNone;
        if (parents != cycles)
          return fmt::format("node {} of {} has {} prime arcs, and its link has {} independent cycles", k + 1,
                             result_.describe_edge(e), parents, cycles);
      }
    }
    return {};
  }

  // The places of the sectors of a vertex are 0, 1, 2 ..., those of its pockets the last one.
  std::string wrong_order() const {
    std::size_t at = 0;
    std::vector<std::uint32_t> places;
    for (std::uint32_t v = 0; v < complex_.vertex_count; ++v) {
      const std::uint32_t first = network_.sectors()[v], last = network_.sectors()[v + 1];
      if (last - first < 2) continue;
      places.clear();
      for (std::uint32_t s = first; s < last; ++s, ++at)
        if (std::isfinite(time_[s])) places.push_back(states_.order[at]);
      std::sort(places.begin(), places.end());
      for (std::uint32_t i = 0; i < places.size(); ++i)
        if (places[i] != i)
          return fmt::format("the order of the sectors of {} has no place {}", result_.describe_vertex(v), i);
    }
    return {};
  }

  const Result& result_;
  const CellComplex& complex_;
  const BurnNetwork& network_;
  const States& states_;
  double late_;  // most that fire may be late along an arc
  bool exact_;
  std::vector<char> pocket_;
  std::vector<double> time_;
  std::vector<std::uint32_t> parent_;  // state of the parent in the polygon of the arc
  base::Csr<std::uint32_t> polygons_;  // per state: its polygons, ascending
  std::size_t arcs_ = 0;
  std::vector<Stop> stops_;
  std::vector<std::array<std::uint32_t, 2>> chords_;  // places of their ends in the polygon
};

}  // namespace

Check check_burn_sequence(const Result& result) {
  const std::string name = "burn sequence";
  const auto is_there = [&](const char* array) { return find_array(result.data.field_data, array) != nullptr; };
  const std::vector<double> omega = numbers_or_empty(result.data.field_data, "omega");
  const std::string rule = text_or_empty(result.data.field_data, "radius_rule");
  if (!std::all_of(std::begin(kArrays), std::end(kArrays), is_there) || !is_there("sequence_of") || omega.size() != 1 ||
      !(omega[0] > 0) || rule.empty() || result.ball_radius.empty())
    return not_checked(name, "an array of it is missing, or the radii, omega or radius_rule it is of");
  if (result.rows.size() != result.data.points.size()) return not_checked(name, "a point belongs to no cell");
  const bool exact = rule == "exact";
  const BurnNetwork network(result, omega[0], exact);
  States states;
  std::string wrong = wrong_form(result.data, network, states);
  if (!wrong.empty()) return failed(name, std::move(wrong));
  // Radii of other programs need not be distances, and between points those that are fitted to a surface are not.
  Comparison comparison(result, network, states, omega[0], exact && !result.fitted && result.stage == "core");
  wrong = comparison.wrong();
  if (wrong.empty()) wrong = wrong_fingerprints(result, network, omega[0], exact);
  if (!wrong.empty()) return failed(name, std::move(wrong));
  Check check{name, true, {}, {}};
  check.detail = fmt::format(
      "{} states burn when their vertices do, not before their radius; {} prime arcs, as many as "
      "links have cycles, do not cross; the fingerprints are right",
      network.states(), comparison.arcs());
  for (const char* array : kArrays) cover(check, fmt::format("field {}", array));
  cover(check, "field sequence_of");
  return check;
}

bool has_burn_sequence(const Record& data) {
  const auto is_there = [&](const char* array) { return find_array(data.field_data, array) != nullptr; };
  return is_there("sequence_of") || std::any_of(std::begin(kArrays), std::end(kArrays), is_there);
}

}  // namespace quench::verification
