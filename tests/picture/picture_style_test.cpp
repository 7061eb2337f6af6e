// SPDX-License-Identifier: Apache-2.0
// The numbers, colours and words of pictures are those of the interactive page: they are looked up in its program.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <map>

#include "picture/caption.h"
#include "picture/style.h"

using namespace quench;
using namespace quench::picture;

namespace picture_style_test {

std::string source(const std::string& file) {
  static std::map<std::string, std::string> known;
  std::string& text = known[file];
  if (text.empty()) {
    std::ifstream in(std::string(QUENCH_VIEWER_SOURCE) + "/" + file, std::ios::binary);
    text = {std::istreambuf_iterator<char>(in), {}};
  }
  return text;
}

void expect_in(const std::string& file, const std::string& words) {
  EXPECT_NE(source(file).find(words), std::string::npos) << file << " has no " << words;
}

/// As TypeScript and GLSL spell them.
std::string number(double x) { return fmt::format("{}", static_cast<float>(x)); }
std::string real(double x) { return number(x) + (number(x).find('.') == std::string::npos ? ".0" : ""); }
std::string hex(std::uint32_t colour) { return fmt::format("\"{:06x}\"", colour); }
std::string vector(const Vec3f& v) {
  return fmt::format("vec3({}, {}, {})", number(v.x()), number(v.y()), number(v.z()));
}
template <class Colours>
std::string list(const Colours& colours) {
  std::string text;
  for (const std::uint32_t colour : colours) text += (text.empty() ? "" : ", ") + hex(colour);
  return text;
}

TEST(PictureStyle, Colours) {
  const std::string file = "colours.ts";
  expect_in(file,
            fmt::format("viridis: {{ label: \"viridis\", stops: [{}], accent: {} }}", list(kViridis), hex(kAccent)));
  expect_in(file, fmt::format("CATEGORICAL = [{}]", list(kParts)));
  expect_in(file, fmt::format("GREY: Rgb = rgb({})", hex(kMissing)));
  expect_in(file, fmt::format("INFINITE: Rgb = rgb({})", hex(kInfinite)));
  const std::string layer = "scene/layer_view.ts";
  expect_in(layer, fmt::format("plain(this.surface, state.dark ? {} : {}", hex(kDark.sheet), hex(kLight.sheet)));
  expect_in(layer,
            fmt::format("plain(this.boundary.mesh, state.dark ? {} : {}", hex(kDark.boundary), hex(kLight.boundary)));
  expect_in(layer, fmt::format("plain(this.seams.mesh, {}", hex(kSeamColour)));
  const std::string shape = "scene/shape_view.ts";
  expect_in(shape,
            fmt::format("tint.value as Vector3).copy(colour(dark ? {} : {}))", hex(kDark.tint), hex(kLight.tint)));
  expect_in(shape, fmt::format("rim.value as Vector3).copy(colour(dark ? {} : {}))", hex(kDark.rim), hex(kLight.rim)));
  // On paper the ground is white all over; the page begins with it at its top.
  expect_in("scene/stage.ts", fmt::format("light: {{ top: {}", hex(kLight.top)));
  expect_in("scene/stage.ts", fmt::format("dark: {{ top: {}, bottom: {} }}", hex(kDark.top), hex(kDark.bottom)));
  for (const Ground& ground : {kLight, kDark})
    expect_in("ui/style.css", fmt::format("--text: #{:06x}; --quiet: #{:06x};", ground.text, ground.quiet));
  for (const auto& [name, colour] : kAxisColours) expect_in("ui/caption.ts", fmt::format("\"#{:06x}\"", colour));
}

TEST(PictureStyle, Camera) {
  const std::string file = "scene/camera.ts";
  expect_in(file, fmt::format("FIELD = ({} * Math.PI) / 180", number(kField)));
  expect_in(file, fmt::format("Math.max(this.distance - {}, this.distance * {})", number(kReach), number(kNearest)));
  expect_in(file, fmt::format("this.distance + (this.orthographic ? 4 : {})", number(kReach)));
  expect_in("app.ts", fmt::format("60000), {})", number(kMargin)));
  for (const Vec3& direction : {kFirstLookOnZ, kFirstLookOnY})
    expect_in("app.ts", fmt::format("new Vector3({}, {}, {})", direction.x(), direction.y(), direction.z()));
}

TEST(PictureStyle, Light) {
  const std::string file = "scene/shaders.ts";
  expect_in(file, "normalize(" + vector(kKeyLight) + ")");
  expect_in(file, "normalize(" + vector(kFillLight) + ")");
  expect_in(file, fmt::format("light = {} + {} * key + {} * fill + {} * head", number(kAmbient), number(kKey),
                              number(kFill), number(kHead)));
  expect_in(file, fmt::format("pow(pow(colour, vec3({0})) * light * light * {1} + spark, vec3(1.0 / {0}))",
                              number(kGamma), number(kExposure)));
  expect_in(file, fmt::format("toEye, {})", number(kSheetGloss)));
  expect_in(file, fmt::format("vec3(0.0, 0.0, 1.0), {})", number(kCurveGloss)));
  expect_in(file, fmt::format("-ray, {})", number(kBallGloss)));
  expect_in(file, fmt::format("pow(1.0 - facing, {})", number(kGlassPower)));
  expect_in(file, fmt::format("tint * ({} + {} * key)", number(kGlassBase), number(kGlassKey)));
  expect_in(file, fmt::format("({:.2f} + {} * edge) * opacity", kGlass, number(kGlassEdge)));
  expect_in("scene/shape_view.ts", fmt::format("opacity * {}", number(kGlassFactor)));
  EXPECT_EQ(kPlaneFill, kGlassOpacity);
  expect_in("state.ts", fmt::format("shapeOpacity: {}", number(kGlassOpacity)));
  expect_in(file, fmt::format("distanceAt(at + step_)), {})", number(kDomeMost)));
  expect_in(file, fmt::format("occlusion(vAt, here, radius) + {} * occlusion(vAt, here, {} * radius)",
                              number(kDomeFartherWeight), real(kDomeFarther)));
  expect_in("scene/stage.ts", fmt::format("dark ? {} : {}", number(kDomeDark), number(kDomeLight)));
  expect_in("scene/stage.ts", fmt::format("{} * this.pixelRatio", number(kDomeReach)));
}

TEST(PictureStyle, Lines) {
  const std::string file = "scene/layer_view.ts";
  expect_in("state.ts", fmt::format("> {} * meta.side ? thin : thick", number(kManyCurves)));
  expect_in("state.ts", fmt::format("meta.plane ? [{}, {}] : [{}, {}]", number(kPlaneCurveWidth),
                                    number(kThinPlaneCurveWidth), number(kCurveWidth), number(kThinCurveWidth)));
  expect_in("scene/plane_view.ts", fmt::format("HALF_WIDTH = {};", number(kOutlineWidth)));
  expect_in("scene/plane_view.ts", fmt::format("COVERS = {};", number(kOutlineCovers)));
  expect_in("app.ts", fmt::format("meta.plane ? 0 : {})", number(kCurveLeast)));
  expect_in(file, fmt::format("state.curveWidth / 2 + (this.flat ? 1 : {})) * pixelRatio", number(kPointMore)));
  expect_in(file, fmt::format("halfWidth!.value = {} * pixelRatio", number(kBoundaryWidth)));
  expect_in(file, fmt::format("halfWidth!.value = {} * pixelRatio", number(kSeamWidth)));
  const auto power = [](double x, int exponent) {
    return fmt::format("{}e-{}", std::lround(x * std::pow(10, exponent)), exponent);
  };
  expect_in(file, "this.boundary = bar(0.8, " + power(kLineBias, 5));
  expect_in(file, "this.seams = bar(1.1, " + power(kLineBias, 5));
  expect_in(file, "this.curves = bar(2.5, " + power(kCurveBias, 4));
  expect_in(file, fmt::format("Math.min(bars === this.seams ? {} : {}, {} / Math.max(covered, 1e-9))",
                              number(kSeamMost), number(kBoundaryMost), number(kCovered)));
  expect_in(file, fmt::format("opacity < {} ? 0 : opacity", number(kPalest)));
  expect_in(file, fmt::format("Math.cos(({} * Math.PI) / 180)", number(kCrease)));
}

TEST(PictureStyle, Words) {
  for (const char* name : {"radius", "detail", "cap_height", "lambda", "burn_time", "erosion_thickness", "object_angle",
                           "mgf", "circumradius", "chord_residual", "core_erosion_thickness",
                           "relative_erosion_thickness", "scale_axis", "curve_burn_time", "curve_erosion_thickness"})
    expect_in("measures.ts", fmt::format("{}: {{ label: \"{}\"", name, label_of(name)));
  expect_in("ui/caption.ts", "`θ₂ = ${");
  expect_in("ui/caption.ts", "`θ₁ = ${");
  expect_in("ui/caption.ts", "join(\" · \")");
}

}  // namespace picture_style_test
