// SPDX-License-Identifier: Apache-2.0
#include "picture/view_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "picture/tree_scene.h"
#include "quench/error.h"

namespace quench::picture {
namespace {

constexpr double kSolid = 0.98;  // app.ts: a surface of this opacity hides what is inside

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/// Of an address: what is written as numbers is a byte again.
std::string decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool coded =
        text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 && hex_digit(text[i + 2]) >= 0;
    out += coded ? static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2])) : text[i];
    if (coded) i += 2;
  }
  return out;
}

/// The value of a key in a state; nothing where it is not there.
std::optional<std::string> value_of(std::string_view state, std::string_view key) {
  while (!state.empty()) {
    const std::size_t end = std::min(state.find('&'), state.size());
    const std::string_view part = state.substr(0, end);
    state.remove_prefix(std::min(end + 1, state.size()));
    if (part.size() > key.size() && part.starts_with(key) && part[key.size()] == '=')
      return decoded(part.substr(key.size() + 1));
  }
  return {};
}

/// A number, and what follows it.
double number_in(std::string_view& text, const char* key) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc())
    throw Error(ErrorCode::usage, fmt::format("'{}' of the state of a page is not a number: '{}'", key, text));
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

std::array<double, 9> camera_in(std::string_view text) {
  std::array<double, 9> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = number_in(text, "camera");
    const bool last = i + 1 == numbers.size();
    if (!std::isfinite(numbers[i]) || (last ? !text.empty() : !text.starts_with(',')))
      throw Error(ErrorCode::usage, "'camera' of the state of a page is not nine numbers with commas between them");
    text.remove_prefix(last ? 0 : 1);
  }
  return numbers;
}

std::string default_color(const Page& page, const std::string& layer) {
  if (layer == "tree") return "level";
  for (const char* name : {"erosion_thickness", "radius", "lambda"})
    if (page.find(layer + "/point/" + name)) return name;
  for (const PageArray& array : page.arrays)
    if (array.name.starts_with(layer + "/point/")) return array.name.substr(layer.size() + 7);
  return "none";
}

/// What the surface is coloured by, and how many vertices a medial mesh has.
void take_surface_and_vertices(ViewState& state, const Page& page) {
  const std::string surface = value_of(page.state, "surface").value_or("none");
  if (surface != "none" && !page.find("shape/point/" + surface))
    throw Error(ErrorCode::usage, fmt::format("there is no array '{}' to colour the surface by", surface));
  double opacity = surface == "none" ? 0 : 1;
  if (const auto text = value_of(page.state, "shapeOpacity")) {
    std::string_view rest = *text;
    opacity = number_in(rest, "shapeOpacity");
  }
  if (surface != "none" && state.shape && !page.plane && opacity > kSolid) state.surface = surface;
  if (const auto text = value_of(page.state, "vertices")) {
    std::string_view rest = *text;
    const double count = number_in(rest, "vertices");
    state.vertices = count >= 1 && count < 1e9 ? static_cast<std::size_t>(count) : state.vertices;
  }
}

/// Measure and threshold of the layer `core`.
void take_pruning(ViewState& state, const Page& page) {
  if (page.measures.empty()) return;
  const auto named = [&](const std::string& name) {
    return std::find_if(page.measures.begin(), page.measures.end(),
                        [&](const PageMeasure& m) { return m.name == name; });
  };
  auto measure = named(value_of(page.state, "measure").value_or(page.pruning ? page.pruning->measure : ""));
  if (measure == page.measures.end()) measure = page.measures.begin();
  state.measure = measure->name;
  state.threshold = page.pruning && page.pruning->measure == measure->name ? page.pruning->threshold : 0;
  if (const auto text = value_of(page.state, "threshold")) {
    std::string_view rest = *text;
    state.threshold = number_in(rest, "threshold");
    if (!rest.empty()) throw Error(ErrorCode::usage, "'threshold' of the state of a page is not a number");
  }
  state.threshold = std::max(std::isnan(state.threshold) ? 0 : state.threshold, measure->floor);
}

}  // namespace

ViewState view_state(const Page& page) {
  ViewState state;
  state.dark = value_of(page.state, "dark") == "1";
  if (const auto camera = value_of(page.state, "camera")) state.camera = camera_in(*camera);
  for (const char* layer : {"tree", "skeleton", "core", "simple", "still"})
    if (state.layer.empty() && page.find(std::string(layer) + "/points")) state.layer = layer;
  if (const auto layer = value_of(page.state, "layer")) {
    if (!page.find(*layer + "/points"))
      throw Error(ErrorCode::usage, fmt::format("there is no layer '{}' in this page", *layer));
    state.layer = *layer;
  }
  if (state.layer.empty()) return state;
  // Of a tree the tubes are about where the surface is.
  state.shape = value_of(page.state, "shape").value_or(state.layer == "tree" ? "0" : "1") == "1";
  // Without sheets the curves carry the colours.
  const std::vector<std::uint32_t>* corners = find_values<std::uint32_t>(page, "skeleton/polygon_corners");
  const bool no_sheets = page.plane || (page.theta2 && std::isinf(*page.theta2)) || !corners || corners->empty();
  const bool pure = state.layer == "skeleton" && no_sheets && page.find("skeleton/point/radius");
  state.color = value_of(page.state, "color").value_or(pure ? "radius" : default_color(page, state.layer));
  const bool parts = state.layer == "tree"
                         ? is_colour_of_tree(page, state.color)
                         : state.layer == "skeleton" &&
                               (state.color == "sheet" || state.color == "branch" || sheet_column(page, state.color));
  if (state.color != "none" && !parts && !page.find(state.layer + "/point/" + state.color))
    throw Error(ErrorCode::usage,
                fmt::format("there is no array '{}' to colour the layer '{}' by", state.color, state.layer));
  state.curves_by_measure = pure || page.plane || state.layer == "tree" || state.color.starts_with("curve_");
  take_pruning(state, page);
  take_surface_and_vertices(state, page);
  return state;
}

const PageColumn* sheet_column(const Page& page, const std::string& color) {
  const auto found = std::ranges::find_if(page.columns, [&](const PageColumn& c) {
    return c.table == "sheets" && c.words.empty() && "sheets/" + c.name == color;
  });
  return found == page.columns.end() ? nullptr : &*found;
}

template <class T>
const std::vector<T>* find_values(const Page& page, const std::string& name) {
  const PageArray* const array = page.find(name);
  if (!array) return nullptr;
  const auto* const values = std::get_if<std::vector<T>>(&array->values);
  if (!values) throw Error(ErrorCode::usage, fmt::format("the array '{}' of a page has an unexpected type", name));
  return values;
}
template const std::vector<float>* find_values(const Page&, const std::string&);
template const std::vector<std::uint32_t>* find_values(const Page&, const std::string&);

}  // namespace quench::picture
