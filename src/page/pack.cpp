// SPDX-License-Identifier: Apache-2.0
#include "page/pack.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "page/layer.h"

namespace quench::page {
namespace {

using Floats = std::vector<float>;
using Words = std::vector<std::uint32_t>;

std::size_t rows_of(const PageArray& array) {
  return std::visit([](const auto& v) { return v.size(); }, array.values) / static_cast<std::size_t>(array.components);
}

PackedArray plain(const PageArray& array) {
  constexpr std::array kTypes{"f32", "u32", "u16", "u8"};
  PackedArray out{array.name, kTypes[array.values.index()], array.components, rows_of(array), {}, {}};
  std::visit([&](const auto& v) { out.bytes.assign(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(v[0])); },
             array.values);
  return out;
}

/// Words byte by byte, the lowest first: as many planes as are not zero.
int write_planes(const Words& words, std::string& bytes) {
  const std::uint32_t all = std::accumulate(words.begin(), words.end(), 0U, std::bit_or());
  const int planes = (std::bit_width(all) + 7) / 8;
  bytes.resize(static_cast<std::size_t>(planes) * words.size());
  for (int p = 0; p < planes; ++p)
    for (std::size_t i = 0; i < words.size(); ++i)
      bytes[static_cast<std::size_t>(p) * words.size() + i] = static_cast<char>(words[i] >> (8 * p));
  return planes;
}

/// A difference modulo 2^bits: small ones of either sign are small numbers.
std::uint32_t folded(std::uint32_t difference, int bits) {
  const std::uint32_t d = difference << (32 - bits), twice = (d >> (32 - bits)) << 1;
  return (d >> 31 ? ~twice : twice) << (32 - bits) >> (32 - bits);
}

/// Differences to the row before, folded.
Words differences(const Words& words, int components, int bits) {
  Words out(words.size());
  const auto step = static_cast<std::size_t>(components);
  for (std::size_t i = 0; i < words.size(); ++i) out[i] = folded(words[i] - (i < step ? 0 : words[i - step]), bits);
  return out;
}

PackedArray by_differences(std::string name, const char* type, int components, const Words& words) {
  PackedArray out{std::move(name), type, components, words.size() / static_cast<std::size_t>(components), {}, {}};
  out.code =
      fmt::format(R"("code": "delta", "planes": {})", write_planes(differences(words, components, 32), out.bytes));
  return out;
}

Words bits_of(const Floats& values) {
  Words words(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) words[i] = std::bit_cast<std::uint32_t>(values[i]);
  return words;
}

/// Numbers from 0 on, each near the largest so far: how far below the next one each is.
PackedArray by_freshness(std::string name, int components, const Words& words) {
  PackedArray out{std::move(name), "u32", components, words.size() / static_cast<std::size_t>(components), {}, {}};
  Words below(words.size());
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < words.size(); ++i) {
    below[i] = next - words[i];
    if (words[i] == next) ++next;
  }
  out.code = fmt::format(R"("code": "fresh", "planes": {})", write_planes(below, out.bytes));
  return out;
}

/// Values in steps of their range; the two largest codes are infinity and no number.
PackedArray in_steps(std::string name, int components, const Floats& values, int bits) {
  const auto n = static_cast<std::size_t>(components);
  const std::uint32_t infinite = (1U << bits) - 1, nothing = infinite - 1, most = nothing - 1;
  std::vector<double> low(n, std::numeric_limits<double>::infinity()), high(n, -low[0]), step(n, 0);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i])) {
      low[i % n] = std::min<double>(low[i % n], values[i]);
      high[i % n] = std::max<double>(high[i % n], values[i]);
    }
  for (std::size_t k = 0; k < n; ++k) {
    if (!(high[k] >= low[k])) low[k] = high[k] = 0;
    step[k] = (high[k] - low[k]) / most;
  }
  Words codes(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = values[i];
    codes[i] = std::isnan(x)      ? nothing
               : std::isinf(x)    ? infinite
               : step[i % n] == 0 ? 0
                                  : static_cast<std::uint32_t>(std::lround((x - low[i % n]) / step[i % n]));
  }
  PackedArray out{std::move(name), "f32", components, values.size() / n, {}, {}};
  const int planes = write_planes(differences(codes, components, bits), out.bytes);
  out.code = fmt::format(R"("code": "steps", "bits": {}, "planes": {}, "low": [{}], "step": [{}])", bits, planes,
                         fmt::join(low, ", "), fmt::join(step, ", "));
  return out;
}

/// The arrays of one layer, which refer to each other's rows.
class LayerPacker {
 public:
  LayerPacker(const Page& page, const std::string& layer) : page_(page), layer_(layer) {
    corners_ = words("polygon_corners");
    offsets_ = words("polygon_offsets");
    if (offsets_.empty()) offsets_ = {0};
    vertices_ = rows_of(*page.find(layer + "/points"));
    order_faces();
    number_vertices();
    has_edges_ = page.find(layer + "/edges") != nullptr;
    if (has_edges_) number_edges();
  }

  std::vector<PackedArray> arrays() {
    add_cells();
    add_levels();
    add_numbers();
    add_measures();
    for (const PageArray& array : page_.arrays)
      if (array.name.starts_with(layer_ + "/") && !known(array.name)) out_.push_back(plain(array));
    return std::move(out_);
  }

 private:
  std::string name(const std::string& array) {
    names_.push_back(layer_ + "/" + array);
    return names_.back();
  }
  bool known(const std::string& name) const { return std::find(names_.begin(), names_.end(), name) != names_.end(); }
  template <class T>
  const std::vector<T>* values(const std::string& array) {
    const PageArray* found = page_.find(name(array));
    return found ? &std::get<std::vector<T>>(found->values) : nullptr;
  }
  Words words(const std::string& array) {
    const Words* found = values<std::uint32_t>(array);
    return found ? *found : Words();
  }
  std::size_t faces() const { return offsets_.size() - 1; }

  // By their first corner where they come by levels: as they lie beside each other.
  void order_faces() {
    face_.resize(faces());
    std::iota(face_.begin(), face_.end(), 0U);
    if (page_.find(layer_ + "/face_level"))
      std::stable_sort(face_.begin(), face_.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return corners_[offsets_[a]] < corners_[offsets_[b]]; });
  }

  template <class T>
  std::vector<T> by_corner(const std::vector<T>& of) const {
    std::vector<T> ordered;
    ordered.reserve(of.size());
    for (const std::uint32_t f : face_)
      ordered.insert(ordered.end(), of.begin() + offsets_[f], of.begin() + offsets_[f + 1]);
    return ordered;
  }
  template <class T>
  static std::vector<T> taken(const std::vector<T>& values, const Words& rows, std::size_t components = 1) {
    std::vector<T> out(rows.size() * components);
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t k = 0; k < components; ++k) out[i * components + k] = values[rows[i] * components + k];
    return out;
  }
  static Words inverse(const Words& rows, std::size_t size) {
    Words number(size, kNone);
    for (std::uint32_t i = 0; i < rows.size(); ++i) number[rows[i]] = i;
    return number;
  }

  // As they come around the faces.
  void number_vertices() {
    std::vector<char> seen(vertices_, 0);
    vertex_.reserve(vertices_);
    const auto add = [&](std::uint32_t v) {
      if (seen[v]) return;
      seen[v] = 1;
      vertex_.push_back(v);
    };
    corners_ = by_corner(corners_);
    for (const std::uint32_t v : corners_) add(v);
    for (std::uint32_t v = 0; v < vertices_; ++v) add(v);
    vertex_number_ = inverse(vertex_, vertices_);
    for (std::uint32_t& v : corners_) v = vertex_number_[v];
  }

  // Those that are the first between their two vertices, as they come around the faces; then all others.
  void number_edges() {
    ends_ = words("edges");
    for (std::uint32_t& v : ends_) v = vertex_number_[v];
    sides_ = by_corner(words("polygon_edges"));
    edge_number_.assign(ends_.size() / 2, kNone);
    std::size_t size = 16;
    while (size < 2 * sides_.size()) size *= 2;
    Words table(size, kNone);
    for (const std::uint32_t e : sides_) {
      if (edge_number_[e] != kNone) continue;
      const std::uint32_t a = ends_[2 * e], b = ends_[2 * e + 1];
      std::size_t at = (std::uint64_t{a} << 32 | b) * 0x9E3779B97F4A7C15U >> 20 & (size - 1);
      while (table[at] != kNone && !(same(table[at], e))) at = (at + 1) & (size - 1);
      if (table[at] != kNone) continue;
      table[at] = e;
      edge_number_[e] = static_cast<std::uint32_t>(edge_.size());
      edge_.push_back(e);
    }
    const std::size_t first = edge_.size();
    for (std::uint32_t e = 0; e < edge_number_.size(); ++e)
      if (edge_number_[e] == kNone) edge_.push_back(e);
    std::sort(edge_.begin() + static_cast<std::ptrdiff_t>(first), edge_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::array{least(a), ends_[2 * a] + ends_[2 * a + 1], a} <
             std::array{least(b), ends_[2 * b] + ends_[2 * b + 1], b};
    });
    edge_number_ = inverse(edge_, edge_number_.size());
    lone_ = first;
  }
  bool same(std::uint32_t a, std::uint32_t b) const {
    return std::minmax(ends_[2 * a], ends_[2 * a + 1]) == std::minmax(ends_[2 * b], ends_[2 * b + 1]);
  }
  std::uint32_t least(std::uint32_t e) const { return std::min(ends_[2 * e], ends_[2 * e + 1]); }

  void add_cells() {
    out_.push_back(in_steps(name("points"), 3, taken(*values<float>("points"), vertex_, 3), fine() ? 24 : 16));
    Words offsets{0};
    for (const std::uint32_t f : face_) offsets.push_back(offsets.back() + offsets_[f + 1] - offsets_[f]);
    out_.push_back(by_differences(name("polygon_offsets"), "u32", 1, offsets));
    out_.push_back(by_freshness(name("polygon_corners"), 1, corners_));
    if (!has_edges_) return;
    Words lone, others;
    for (std::size_t i = lone_; i < edge_.size(); ++i) {
      const auto [a, b] = std::minmax(ends_[2 * edge_[i]], ends_[2 * edge_[i] + 1]);
      lone.insert(lone.end(), {a, b});
    }
    for (std::uint32_t i = 0; i < sides_.size(); ++i)
      if (edge_number_[sides_[i]] >= lone_)
        others.insert(others.end(), {i, edge_number_[sides_[i]] - static_cast<std::uint32_t>(lone_)});
    out_.push_back(by_differences(name("lone_edges"), "u32", 2, lone));
    out_.push_back(by_differences(name("other_sides"), "u32", 2, others));
  }

  // Of an edge the largest of its faces, of a vertex the largest of its edges, infinite where there are none and on
  // curves; what is not so.
  void add_levels_of(const std::string& suffix) {
    const Floats* face = values<float>("face_level" + suffix);
    const Floats *edge = values<float>("edge_level" + suffix), *vertex = values<float>("vertex_level" + suffix);
    if (!face || !edge || !vertex) return;
    const Floats by_face = taken(*face, face_);
    out_.push_back(by_differences(name("face_level" + suffix), "f32", 1, bits_of(by_face)));
    constexpr float kNo = -std::numeric_limits<float>::infinity(), kAlways = -kNo;
    Floats largest(edge_.size(), kNo);
    std::size_t i = 0;
    for (std::size_t f = 0; f < face_.size(); ++f)
      for (const std::size_t end = i + offsets_[face_[f] + 1] - offsets_[face_[f]]; i < end; ++i) {
        float& level = largest[edge_number_[sides_[i]]];
        level = std::max(level, by_face[f]);
      }
    if (suffix.empty())
      for (const std::uint32_t e : words("curve_edges")) largest[edge_number_[e]] = kAlways;
    for (float& level : largest)
      if (level == kNo) level = kAlways;
    add_exceptions("edge_level", suffix, taken(*edge, edge_), largest);
    Floats at(vertex_.size(), kNo);
    for (std::uint32_t e = 0; e < edge_.size(); ++e)
      for (const std::uint32_t v : {ends_[2 * edge_[e]], ends_[2 * edge_[e] + 1]}) at[v] = std::max(at[v], largest[e]);
    for (float& level : at)
      if (level == kNo) level = kAlways;
    add_exceptions("vertex_level", suffix, taken(*vertex, vertex_), at);
  }
  /// Leaves in `found` what the levels are.
  void add_exceptions(const std::string& array, const std::string& suffix, const Floats& levels, Floats& found) {
    Words rows;
    Floats values;
    for (std::uint32_t i = 0; i < levels.size(); ++i)
      if (levels[i] != found[i]) {
        rows.push_back(i);
        values.push_back(found[i] = levels[i]);
      }
    out_.push_back(by_differences(name(array + "_rows" + suffix), "u32", 1, rows));
    out_.push_back(by_differences(name(array + "_values" + suffix), "f32", 1, bits_of(values)));
  }
  void add_levels() {
    if (!has_edges_) return;
    add_levels_of("");
    for (std::size_t m = 1; layer_ == "core" && m < page_.measures.size(); ++m)
      add_levels_of("/" + page_.measures[m].name);
    const Floats *corner = values<float>("corner_level"), *face = values<float>("face_level");
    if (!corner || !face) return;
    const Words levels = bits_of(by_corner(*corner));
    Words again(levels.size()), last(vertices_, kNone);
    std::size_t i = 0;
    for (const std::uint32_t f : face_)
      for (std::uint32_t k = offsets_[f]; k < offsets_[f + 1]; ++k, ++i) {
        const std::uint32_t most = std::bit_cast<std::uint32_t>((*face)[f]);
        again[i] = folded(levels[i] - std::min(most, last[corners_[i]]), 32);
        last[corners_[i]] = levels[i];
      }
    PackedArray out{name("corner_level"), "f32", 1, levels.size(), {}, {}};
    out.code = fmt::format(R"("code": "again", "planes": {})", write_planes(again, out.bytes));
    out_.push_back(std::move(out));
  }

  // Arrays of vertices, edges and faces by their numbers.
  void add_numbers() {
    if (const Words* curves = values<std::uint32_t>("curve_edges")) {
      const Floats& thickness = *values<float>("curve_thickness");
      Words order(curves->size());
      std::iota(order.begin(), order.end(), 0U);
      std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return edge_number_[(*curves)[a]] < edge_number_[(*curves)[b]];
      });
      Words edges;
      for (const std::uint32_t i : order) edges.push_back(edge_number_[(*curves)[i]]);
      out_.push_back(by_differences(name("curve_edges"), "u32", 1, edges));
      out_.push_back(by_differences(name("curve_thickness"), "f32", 1, bits_of(taken(thickness, order))));
    }
    for (const char* array : {"medial_points", "branch_points", "node_points", "isolated"})
      if (const Words* rows = values<std::uint32_t>(array)) {
        Words numbers;
        for (const std::uint32_t v : *rows) numbers.push_back(vertex_number_[v]);
        out_.push_back(by_differences(name(array), "u32", 1, numbers));
      }
    for (const char* array : {"polygon_sheet", "branch_offsets"})
      if (const Words* rows = values<std::uint32_t>(array))
        out_.push_back(by_differences(name(array), "u32", 1, *rows));
  }

  void add_measures() {
    const std::string prefix = layer_ + "/point/";
    for (const PageArray& array : page_.arrays) {
      if (!array.name.starts_with(prefix)) continue;
      names_.push_back(array.name);
      const std::string measure = array.name.substr(prefix.size());
      if (const auto of = difference(measure)) {
        PackedArray out{array.name, "f32", 1, vertices_, {}, {}};
        out.code = fmt::format(R"("code": "difference", "of": ["{0}/point/{1}", "{0}/point/{2}"], "planes": 0)", layer_,
                               of->first, of->second);
        out_.push_back(std::move(out));
      } else {
        const int bits = measure == "radius" && fine() ? 24 : layer_ == "skeleton" || layer_ == "still" ? 16 : 14;
        out_.push_back(in_steps(array.name, 1, taken(std::get<Floats>(array.values), vertex_), bits));
      }
    }
  }

  /// Of what was asked for, and where balls touch lattice points, places and radii are as fine as floats.
  bool fine() const { return layer_ == "skeleton" || page_.find("shape/sites"); }

  /// The two measures of which this one is the difference, up to rounding.
  std::optional<std::pair<std::string, std::string>> difference(const std::string& measure) {
    std::pair<std::string, std::string> of;
    if (measure == "erosion_thickness") of = {"burn_time", "radius"};
    if (measure == "curve_erosion_thickness") of = {"curve_burn_time", "burn_time"};
    const auto find = [&](const std::string& m) -> const Floats* {
      const PageArray* array = page_.find(layer_ + "/point/" + m);
      return array && !m.empty() ? std::get_if<Floats>(&array->values) : nullptr;
    };
    const Floats *a = find(of.first), *b = find(of.second), *is = find(measure);
    if (!a || !b || !is) return {};
    for (std::size_t i = 0; i < is->size(); ++i) {
      const float x = (*a)[i], y = (*b)[i], found = std::isfinite(x) ? std::max(0.0F, x - y) : x;
      if (std::isnan(found)
              ? !std::isnan((*is)[i])
              : found != (*is)[i] && !(std::abs(found - (*is)[i]) <= 1e-4F * std::max(std::abs(x), std::abs(y))))
        return {};
    }
    return of;
  }

  const Page& page_;
  const std::string layer_;
  std::vector<std::string> names_;  ///< of the arrays that are done
  std::vector<PackedArray> out_;
  std::size_t vertices_ = 0, lone_ = 0;
  bool has_edges_ = false;
  Words corners_, offsets_, ends_, sides_;
  Words face_, vertex_, edge_;  ///< per new number the old one
  Words vertex_number_, edge_number_;
};

/// Of arrays outside of layers of cells: the bits of those that are rounded; else 0.
int bits_of_steps(const std::string& name) {
  if (name == "shape/points" || name == "shape/samples") return 16;
  if (name.starts_with("shape/point/")) return 12;
  if (name == "simple/points" || name == "simple/point/radius") return 16;
  if (name == "simple/step_points" || name == "simple/step_radius") return 16;
  if (name == "tree/points" || name == "tree/point/radius" || name == "tree/edit_points") return 24;
  return name.starts_with("tree/point/") ? 14 : 0;
}

}  // namespace

std::vector<PackedArray> packed(const Page& page) {
  const std::array<std::string, 4> layers{"skeleton", "family", "core", "still"};
  std::array<std::vector<PackedArray>, 4> of_layers;
  tbb::parallel_for(std::size_t{0}, layers.size(), [&](std::size_t l) {
    if (page.find(layers[l] + "/points")) of_layers[l] = LayerPacker(page, layers[l]).arrays();
  });
  std::vector<PackedArray> out;
  for (auto& arrays : of_layers) std::move(arrays.begin(), arrays.end(), std::back_inserter(out));
  for (const PageArray& array : page.arrays) {
    const bool of_layer = std::ranges::any_of(
        layers, [&](const std::string& l) { return array.name.starts_with(l + "/") && page.find(l + "/points"); });
    if (of_layer) continue;
    if (const int bits = bits_of_steps(array.name); bits > 0)
      out.push_back(in_steps(array.name, array.components, std::get<Floats>(array.values), bits));
    else if (const auto* words = std::get_if<Words>(&array.values); words && array.name == "shape/triangles")
      out.push_back(by_freshness(array.name, array.components, *words));
    else if (words)
      out.push_back(by_differences(array.name, "u32", array.components, *words));
    else if (const auto* halves = std::get_if<std::vector<std::uint16_t>>(&array.values))
      out.push_back(by_differences(array.name, "u16", array.components, Words(halves->begin(), halves->end())));
    else
      out.push_back(plain(array));
  }
  return out;
}

}  // namespace quench::page
