// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <utility>

#include "quench/geometry.h"

/// Numbers and colours of the interactive page (viewer/src), so that picture and page look the same; picture_style_test
/// compares the two. Lengths are in scene units, the longest side of the shape, where nothing else is said.
namespace quench::picture {

using Vec3f = Eigen::Vector3f;

/// 0xRRGGBB as red, green, blue of 0 to 1.
inline Vec3f rgb(std::uint32_t hex) {
  const auto channel = [&](int shift) { return static_cast<float>(hex >> shift & 255) / 255; };
  return {channel(16), channel(8), channel(0)};
}

// scene/camera.ts
inline constexpr double kField = 30;      ///< degrees from the bottom of the picture to its top
inline constexpr double kReach = 2.2;     ///< what is nearer to the eye than this before the target is not drawn
inline constexpr double kNearest = 0.01;  ///< ... or this share of the distance, where that is more
inline constexpr double kMargin = 1.04;   ///< around what is framed
// app.ts: from the target to the eye; volumes stand on z, meshes on y
inline const Vec3 kFirstLookOnZ{0.62, -0.72, 0.32}, kFirstLookOnY{0.55, 0.3, 0.78};

// shaders.ts: light of matte surfaces
inline const Vec3f kKeyLight{0.45F, 0.7F, 0.75F};
inline const Vec3f kFillLight{-0.75F, 0.1F, 0.5F};
inline constexpr float kAmbient = 0.34F, kKey = 0.46F, kFill = 0.14F, kHead = 0.22F;
inline constexpr float kExposure = 1.25F, kGamma = 2.2F;
inline constexpr float kSheetGloss = 0.05F, kCurveGloss = 0.18F, kBallGloss = 0.12F;

// shaders.ts: glass
inline constexpr float kGlass = 0.1F, kGlassEdge = 0.75F, kGlassPower = 2.6F;
inline constexpr float kGlassBase = 0.75F, kGlassKey = 0.25F;
inline constexpr float kGlassOpacity = 0.5F, kGlassFactor = 1.2F;

// shaders.ts, scene/stage.ts: eye-dome lighting; reach in pixels
inline constexpr float kDomeReach = 1.3F, kDomeFarther = 4, kDomeFartherWeight = 0.6F, kDomeMost = 0.05F;
inline constexpr float kDomeLight = 24, kDomeDark = 32;

// scene/layer_view.ts: half widths in pixels; biases towards the eye in parts of the depth range
inline constexpr float kCurveWidth = 5, kThinCurveWidth = 3;  ///< whole widths (state.ts)
inline constexpr float kManyCurves = 12;                      ///< longer in all: thin (state.ts)
inline constexpr float kCurveLeast = 0.0016F;
inline constexpr float kTubeLeast = 0.6F;  ///< half a tube
inline constexpr float kPointMore = 2;     ///< isolated points, beyond the curves
inline constexpr float kBoundaryWidth = 0.55F, kSeamWidth = 0.75F;
inline constexpr float kLineBias = 4e-5F, kCurveBias = 2e-4F;
inline constexpr float kBoundaryMost = 0.7F, kSeamMost = 0.9F, kCovered = 0.012F, kPalest = 0.12F;

inline constexpr double kCrease = 35;  ///< degrees: sharper edges are not smoothed

// Of pictures only: on white paper the glass needs outlines; steps are those of log2 of the distance.
inline constexpr float kOutline = 0.8F, kOutlineStep = 0.004F;

// Of the plane: scene/plane_view.ts, state.ts. Half the width of the outline in pixels, how much of the tint the shape
// has; whole widths of curves.
inline constexpr float kOutlineWidth = 0.6F, kPlaneFill = 0.5F;
inline constexpr float kOutlineCovers = 0.15F;  ///< that share of the shape before it pales
inline constexpr float kPlaneCurveWidth = 3, kThinPlaneCurveWidth = 2;

/// The colours of one ground, light or dark.
struct Ground {
  std::uint32_t top, bottom, sheet, boundary, tint, rim, text, quiet;
};
inline constexpr Ground kLight{0xffffff, 0xffffff, 0xa9bccf, 0x20242c, 0x99a8bd, 0x4d5e75, 0x171b21, 0x5b6470};
inline constexpr Ground kDark{0x1b1f26, 0x0e1014, 0x8fa3b8, 0xd5dae2, 0x8091a8, 0xc7d9f2, 0xeef1f5, 0x9aa5b3};
inline constexpr std::uint32_t kSeamColour = 0x0b0d12;

// ui/caption.ts
inline constexpr std::array<std::pair<const char*, std::uint32_t>, 3> kAxisColours{
    {{"x", 0xd1495b}, {"y", 0x3a9a4b}, {"z", 0x3d6fd0}}};

// colours.ts
inline constexpr std::array<std::uint32_t, 10> kViridis{0x46206f, 0x443a83, 0x355f8d, 0x2a788e, 0x21918c,
                                                        0x22a884, 0x44bf70, 0x7ad151, 0xbddf26, 0xfde725};
inline constexpr std::uint32_t kAccent = 0xf4511e;    ///< curves of one colour
inline constexpr std::uint32_t kMissing = 0x8c8f94;   ///< no value
inline constexpr std::uint32_t kInfinite = 0xcc79a7;  ///< no fire comes

/// Parts that are told apart by their colour: each number has that of its remainder.
inline constexpr std::array<std::uint32_t, 12> kParts{0x4e79a7, 0xf28e2b, 0x59a14f, 0xe15759, 0x76b7b2, 0xedc948,
                                                      0xb07aa1, 0xff9da7, 0x9c755f, 0x2f9fd0, 0xa0cb50, 0x8064d0};

/// What infinite and missing values are written as, so that between them and others they win.
inline constexpr float kCodeInfinite = 1e30F, kCodeMissing = -1e30F, kCodeLimit = 1e20F;

/// The colour at 0 to 1 of the map.
Vec3f colour_at(double t);

}  // namespace quench::picture
