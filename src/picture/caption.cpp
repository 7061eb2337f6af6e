// SPDX-License-Identifier: Apache-2.0
#include "picture/caption.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "picture/canvas.h"

namespace quench::picture {
namespace {

// Pixels of the page (viewer/src/ui/style.css, colour_bar.ts).
constexpr double kTitle = 19, kText = 14, kSmall = 12;
constexpr double kEdge = 16;  ///< free along the border
constexpr double kBarWidth = 280, kBarHeight = 10, kBarMargin = 14, kTick = 4, kArrow = 8;
constexpr std::size_t kLongTick = 7;  ///< letters of a number beside which no five others fit
constexpr double kAxisLength = 44, kScaleShare = 0.16;

/// Whether something is drawn in the colours of the measure.
bool is_coloured(const Scene& scene, const ViewState& state) {
  if (scene.sheets.size() > 0) return true;
  return state.curves_by_measure && !(scene.curves.empty() && scene.isolated.empty());
}

bool has_room(const PictureOptions& options) { return options.width >= 240 && options.height >= 160; }

/// Everything written over one picture.
class Writing {
 public:
  Writing(Picture& picture, const Page& page, const Ground& ground, double unit)
      : canvas_(picture),
        page_(page),
        width_(picture.width),
        height_(picture.height),
        unit_(unit),
        text_(rgb(ground.text)),
        quiet_(rgb(ground.quiet)) {}

  void lines() {
    double y = kEdge * unit_;
    bool first = true;
    for (const std::string& line : caption_of(page_)) {
      const double size = (first ? kTitle : kText) * unit_;
      y += size * 1.1;
      canvas_.write(canvas_.fitted(line, size, width_ - 2 * kEdge * unit_), size, {kEdge * unit_, y},
                    first ? text_ : quiet_);
      y += size * 0.25;
      first = false;
    }
  }

  /// Swatches of parts with their names, below `title`; `keys`: what is not of parts has its key below.
  void legend(const std::string& title, const std::vector<std::pair<std::string, std::uint32_t>>& names, bool keys) {
    double x = kEdge * unit_;
    const double y = height_ - (kEdge + 4 + (keys ? 20 : 0)) * unit_, size = kSmall * unit_;
    canvas_.write(title, 13 * unit_, {x, y - 22 * unit_}, text_);
    for (const auto& [name, part] : names) {
      const double width = canvas_.width_of(name, size);
      // The right end is that of the scale bar.
      const bool fits = x + 18 * unit_ + width < width_ * (1 - kScaleShare) - 4 * kEdge * unit_;
      if (fits)
        canvas_.fill_box({x, y - 9 * unit_}, {x + 12 * unit_, y + 2 * unit_}, rgb(kParts[part % kParts.size()]));
      canvas_.write(fits ? name : "…", size, {x + (fits ? 18 * unit_ : 0), y}, quiet_);
      if (!fits) return;
      x += width + 34 * unit_;
    }
  }

  void colour_bar(const std::string& measure, const ColourRange& range, bool curves) {
    const double left = kEdge * unit_;
    const double x0 = std::round(left + (range.least < range.low ? kArrow : 0) * unit_);
    const double length = std::round((kBarWidth - 2 * kBarMargin) * unit_);
    const double top = height_ - (kEdge + 34) * unit_;
    keys(left, height_ - kEdge * unit_, range, curves);
    if (!range.finite) return;
    const double lift = has_keys(range, curves) ? 20 * unit_ : 0, y = top - lift;
    const std::string unit = unit_of(page_, measure);
    canvas_.write(label_of(measure) + (unit.empty() ? "" : " (" + unit + ")"), 13 * unit_, {x0, y - 7 * unit_}, text_);
    const int first = static_cast<int>(x0), last = static_cast<int>(x0 + length);
    for (int x = first; x < last; ++x)
      canvas_.fill_box({x, y}, {x + 1, y + kBarHeight * unit_}, colour_at((x + 0.5 - first) / (last - first)));
    const bool flat = !(range.high > range.low);
    std::vector<double> places;
    std::vector<std::string> names;
    for (const int most : {5, 2}) {
      places = ticks(range.low, range.high, most);
      for (double& x : places)
        if (std::abs(x) < 1e-9 * std::abs(range.high)) x = 0;
      names = names_of(places);
      const auto is_short = [&](const std::string& name) { return name.size() <= kLongTick; };
      if (std::all_of(names.begin(), names.end(), is_short)) break;
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double x = places[i], at = x0 + (flat ? 0.5 : (x - range.low) / (range.high - range.low)) * length;
      canvas_.fill_box({at - unit_ / 2, y + (kBarHeight + 1) * unit_},
                       {at + unit_ / 2, y + (kBarHeight + 1 + kTick) * unit_}, text_);
      canvas_.write(names[i], kSmall * unit_, {at - canvas_.width_of(names[i], kSmall * unit_) / 2, y + 28 * unit_},
                    text_);
    }
    // Values beyond the ends take their colours.
    const double slack = 1e-6 * (range.high - range.low);
    if (range.least < range.low - slack) arrow(x0, -kArrow * unit_, y, 0);
    if (range.most > range.high + slack) arrow(x0 + length, kArrow * unit_, y, 1);
  }

  /// `per_pixel`: world units.
  void scale_bar(double per_pixel) {
    const double length = round_length(kScaleShare * width_ * per_pixel), pixels = length / per_pixel;
    const double right = width_ - kEdge * unit_, y = height_ - (kEdge + 6) * unit_;
    canvas_.fill_box({right - pixels, y - unit_}, {right, y + unit_}, text_);
    for (const double x : {right - pixels, right - 2 * unit_})
      canvas_.fill_box({x, y - 5 * unit_}, {x + 2 * unit_, y + 5 * unit_}, text_);
    const std::string text = short_text(length) + (page_.unit.empty() ? "" : " " + page_.unit);
    canvas_.write(text, 13 * unit_, {right - pixels / 2 - canvas_.width_of(text, 13 * unit_) / 2, y - 9 * unit_},
                  text_);
  }

  void axes(const Camera& camera) {
    struct Axis {
      const char* name;
      Vec3 direction;
      std::uint32_t colour;
    };
    std::vector<Axis> axes;
    for (int i = 0; i < (page_.plane ? 2 : 3); ++i) {
      const auto [name, colour] = kAxisColours[static_cast<std::size_t>(i)];
      axes.push_back({name, camera.turned(Vec3::Unit(i)), colour});
    }
    // What points to the eye comes last.
    std::sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) { return a.direction.z() < b.direction.z(); });
    const Point zero(width_ - (kEdge + 62) * unit_, height_ - (kEdge + 106) * unit_);
    for (const Axis& axis : axes) {
      const Point along = Point(axis.direction.x(), -axis.direction.y()) * (kAxisLength * unit_);
      const Vec3f colour = rgb(axis.colour);
      canvas_.stroke(zero, zero + along, 2 * unit_, colour);
      if (along.norm() > 12 * unit_) {
        const Point tip = along.normalized() * (9 * unit_), side = Point(-tip.y(), tip.x()) * 0.45, end = zero + along;
        const Point head[] = {end + tip * 0.3, end - tip * 0.7 + side, end - tip * 0.7 - side};
        canvas_.fill(head, colour);
      }
      const Point middle =
          zero + along + (along.norm() > 1e-9 ? Point(along.normalized()) : Point(0.7, 0.7)) * (13 * unit_);
      const double size = 13 * unit_;
      canvas_.write(axis.name, size, {middle.x() - canvas_.width_of(axis.name, size) / 2, middle.y() + 0.28 * size},
                    colour);
    }
  }

 private:
  static bool has_keys(const ColourRange& range, bool curves) { return curves || range.infinite || range.missing; }

  void keys(double x, double baseline, const ColourRange& range, bool curves) {
    const auto key = [&](const char* name, std::uint32_t colour) {
      canvas_.fill_box({x, baseline - 7 * unit_}, {x + 14 * unit_, baseline - 2 * unit_}, rgb(colour));
      x += 20 * unit_;
      canvas_.write(name, kSmall * unit_, {x, baseline}, quiet_);
      x += canvas_.width_of(name, kSmall * unit_) + 16 * unit_;
    };
    if (curves) key("curves", kAccent);
    if (range.infinite) key("infinite", kInfinite);
    if (range.missing) key("no value", kMissing);
  }

  void arrow(double x, double reach, double y, double t) {
    const Point corners[] = {{x, y}, {x + reach, y + kBarHeight * unit_ / 2}, {x, y + kBarHeight * unit_}};
    canvas_.fill(corners, colour_at(t));
  }

  Canvas canvas_;
  const Page& page_;
  double width_, height_, unit_;
  Vec3f text_, quiet_;
};

}  // namespace

double line_unit(const PictureOptions& options) {
  return std::max(0.5, std::min(options.width / 1600.0, options.height / 1000.0));
}
// Larger than in the page: a picture is often printed as wide as a column.
double letter_unit(const PictureOptions& options) { return 1.4 * line_unit(options); }

Insets insets_of(const PictureOptions& options) {
  const double unit = letter_unit(options), edge = kEdge * unit;
  if (!options.caption || !has_room(options)) return {edge, edge, edge, edge};
  return {edge, edge, edge + (kTitle + kText) * 1.35 * unit, edge + 50 * unit};
}

void write_captions(Picture& picture, const Page& page, const Scene& scene, const ViewState& state,
                    const ColourRange& range, const Camera& camera, const PictureOptions& options) {
  if (!has_room(options) || (!options.caption && !options.axes)) return;
  Writing writing(picture, page, state.dark ? kDark : kLight, letter_unit(options));
  if (options.caption) {
    writing.lines();
    const bool curves = !scene.curves.empty() && !state.curves_by_measure && scene.curve_parts.empty();
    if (!scene.part_names.empty()) writing.legend(label_of(state.color), scene.part_names, curves);
    if (is_coloured(scene, state) || !scene.part_names.empty())
      writing.colour_bar(state.surface.empty() ? state.color : state.surface, range, curves);
    writing.scale_bar(camera.per_pixel() / scene.placement.scale);
  }
  if (options.axes) writing.axes(camera);
}

}  // namespace quench::picture
