// SPDX-License-Identifier: Apache-2.0
// The words of the interactive page (viewer/src/format.ts, measures.ts, ui/info.ts).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "picture/caption.h"

namespace quench::picture {
namespace {

std::string with_unit(const std::string& text, const std::string& unit) {
  return unit.empty() ? text : unit == "°" ? text + unit : text + " " + unit;
}

std::string length_words(const Page& page, double length) { return with_unit(short_text(length), page.unit); }

/// "detail = 0.36 mm (0.87 voxels)".
std::string pruning_words(const Page& page, const std::string& measure, double threshold) {
  std::string text =
      fmt::format("{} = {}", label_of(measure), with_unit(short_text(threshold), unit_of(page, measure)));
  if (page.voxel > 0 && unit_of(page, measure) != "°" && std::isfinite(threshold))
    text += fmt::format(" ({} voxels)", short_text(threshold / page.voxel));
  return text;
}

std::string skeleton_words(const Page& page) {
  const double theta2 = page.theta2.value_or(0), theta1 = page.theta1.value_or(0);
  std::string text = std::isinf(theta2) ? "Skeleton: no sheets but closed pockets"
                                        : "Skeleton: sheets of erosion thickness ≥ " + length_words(page, theta2);
  text += std::isinf(theta1) ? ", curves only where topology needs them" : ", curves ≥ " + length_words(page, theta1);
  if (page.pruning) text += "; " + pruning_words(page, page.pruning->measure, page.pruning->threshold);
  return text;
}

}  // namespace

std::string label_of(const std::string& measure) {
  if (measure == "lambda") return "λ";
  if (measure == "curve_erosion_thickness") return "curve thickness";
  std::string label = measure;
  std::replace(label.begin(), label.end(), '_', ' ');
  return label;
}

std::string unit_of(const Page& page, const std::string& measure) {
  return measure == "object_angle" ? "°" : page.unit;
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
  if (!file.empty()) lines.push_back(file);
  if (state.layer == "skeleton") lines.push_back(skeleton_words(page));
  if (state.layer == "core" && !state.measure.empty())
    lines.push_back("Medial axis: pruned at " + pruning_words(page, state.measure, state.threshold));
  return lines;
}

}  // namespace quench
