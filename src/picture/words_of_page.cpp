// SPDX-License-Identifier: Apache-2.0
// The words of the interactive page (viewer/src/format.ts, measures.ts, ui/caption.ts).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "picture/caption.h"
#include "picture/mesh_scene.h"
#include "picture/tree_scene.h"
#include "quench/measures.h"

namespace quench::picture {
namespace {

std::string with_unit(const std::string& text, const std::string& unit) {
  return unit.empty() ? text : unit == "°" ? text + unit : text + " " + unit;
}

/// "detail = 0.36 mm".
std::string pruning_words(const Page& page, const std::string& measure, double threshold) {
  return fmt::format("{} = {}", label_of(measure), with_unit(short_text(threshold), unit_of(page, measure)));
}

/// "θ₂ = 0.03 mm · θ₁ = 0.02 mm · detail = 0.36 mm".
std::string skeleton_words(const Page& page) {
  const auto theta = [&](const char* name, const std::optional<double>& length) {
    if (!length) return std::string();
    return fmt::format("{} = {} · ", name, std::isinf(*length) ? "∞" : with_unit(short_text(*length), page.unit));
  };
  std::string text = theta("θ₂", page.theta2) + theta("θ₁", page.theta1);
  if (page.theta1_radii > 0 && page.theta1)
    text.insert(text.rfind(" · "), fmt::format(" and {} radii", short_text(page.theta1_radii)));
  if (page.pruning) return text + pruning_words(page, page.pruning->measure, page.pruning->threshold);
  return text.substr(0, text.rfind(" · "));
}

/// A unit as people write it: "°", "mm³" of "mm^3".
std::string unit_words(const std::string& unit) {
  if (unit == "degrees") return "°";
  static const std::map<char, const char*> kRaised{{'-', "⁻"}, {'1', "¹"}, {'2', "²"}, {'3', "³"}};
  std::string text;
  bool raised = false;
  for (const char c : unit) {
    const auto found = kRaised.find(c);
    if (raised && found != kRaised.end())
      text += found->second;
    else if (c != '^')
      text += c;
    raised |= c == '^';
  }
  return text;
}

/// "61 axes · length 1234 mm · depth 120 mm".
std::string tree_words(const Page& page) {
  const std::size_t axes = axes_of(page);
  std::string text = axes == 1 ? "1 axis" : fmt::format("{} axes", axes);
  for (const auto& [name, label] : {std::pair("total_length", "length"), {"depth", "depth"}})
    if (const double x = sample_value(page, name); std::isfinite(x))
      text += fmt::format(" · {} {}", label, with_unit(short_text(x, 4), page.unit));
  return text;
}

}  // namespace

std::string label_of(const std::string& measure) {
  if (measure == "lambda") return "λ";
  if (measure == "mgf") return "MGF";
  if (measure == "core_erosion_thickness") return "erosion thickness of the core";
  if (measure == "strahler") return "Strahler number";
  // A column of a table of a tree.
  if (measure.starts_with("axes/")) return label_of(measure.substr(5)) + " of the axis";
  if (measure.starts_with("sheets/")) return label_of(measure.substr(7)) + " of the sheet";
  if (measure.starts_with("branches/")) return label_of(measure.substr(9)) + " of the branch";
  std::string label = measure;
  std::replace(label.begin(), label.end(), '_', ' ');
  return label;
}

std::string unit_of(const Page& page, const std::string& measure) {
  if (measure == "angle_to_down") return "°";
  if (measure == "order" || measure == "strahler") return "";
  const PageColumn* const of_sheets = sheet_column(page, measure);
  if (const PageColumn* const column = of_sheets ? of_sheets : column_of(page, measure))
    return unit_words(column->unit);
  if (const MeasureKind* kind = find_measure_kind(measure); kind && kind->unit != MeasureUnit::length)
    return kind->unit == MeasureUnit::degrees ? "°" : "";
  return page.unit;
}

std::string short_text(double x, int digits) {
  if (std::isnan(x)) return "–";
  if (std::isinf(x)) return x > 0 ? "∞" : "−∞";
  if (x == 0) return "0";
  const double size = std::abs(x);
  std::string text;
  if (size >= 1e6 || size < 1e-5) {
    text = fmt::format("{:.{}e}", size, digits - 1);
  } else {
    const int before = static_cast<int>(std::floor(std::log10(size))) + 1;
    text = fmt::format("{:.{}f}", size, std::max(0, digits - before));
    if (text.find('.') != std::string::npos) text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
  }
  return (x < 0 ? "−" : "") + text;
}

std::vector<std::string> names_of(const std::vector<double>& places) {
  const double step = places.size() > 1 ? places[1] - places[0] : 0;
  const auto exact = [&](double x, int digits) {
    if (x == 0) return true;
    const double unit = std::pow(10, std::floor(std::log10(std::abs(x))) + 1 - digits);
    return std::abs(std::round(x / unit) * unit - x) < 0.02 * step;
  };
  int digits = 4;
  while (step > 0 && digits < 8 &&
         !std::all_of(places.begin(), places.end(), [&](double x) { return exact(x, digits); }))
    ++digits;
  std::vector<std::string> names;
  for (const double x : places) names.push_back(short_text(x, digits));
  return names;
}

std::vector<double> ticks(double low, double high, int most) {
  if (!(high > low)) return {low};
  const double raw = (high - low) / most, power = std::pow(10, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.5, 2.0, 1.0})
    if (factor * power >= raw * 0.999) step = factor * power;
  std::vector<double> list;
  for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) list.push_back(i * step + 0.0);
  return list;
}

double round_length(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= most) return factor * power;
  return power;
}

}  // namespace quench::picture

namespace quench {

std::vector<std::string> caption_of(const Page& page) {
  using namespace picture;
  std::string file = page.title;
  for (const auto& [what, name] : page.files)
    if (what == "shape") file = std::filesystem::path(name).filename().string();
  const ViewState state = view_state(page);
  std::vector<std::string> lines;
  lines.push_back(file);
  if (!state.surface.empty()) return lines;
  if (state.layer == "simple") lines.push_back(fmt::format("medial mesh of {} vertices", mesh_vertices(page, state)));
  if (state.layer == "skeleton") lines.push_back(skeleton_words(page));
  if (state.layer == "tree") lines.push_back(tree_words(page));
  if (state.layer == "core" && !state.measure.empty())
    lines.push_back(pruning_words(page, state.measure, state.threshold));
  std::erase(lines, "");
  return lines;
}

}  // namespace quench
