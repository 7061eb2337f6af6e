// SPDX-License-Identifier: Apache-2.0
#include "picture/light.h"

#include <algorithm>
#include <cmath>

namespace quench::picture {
namespace {

constexpr std::size_t kMapSteps = 1024, kSteps = 4096;
constexpr float kBrightest = 4;

float power40(float x) {
  const float x2 = x * x, x4 = x2 * x2, x8 = x4 * x4, x16 = x8 * x8;
  return x16 * x16 * x8;
}

}  // namespace

Light::Light(const ColourRange& range, bool dark)
    : low_(static_cast<float>(range.low)),
      factor_(1 / std::max(static_cast<float>(range.high - range.low), 1e-30F)),
      key_(kKeyLight.normalized()),
      fill_(kFillLight.normalized()),
      tint_(rgb(dark ? kDark.tint : kLight.tint)),
      rim_(rgb(dark ? kDark.rim : kLight.rim)),
      missing_(linear(rgb(kMissing))),
      infinite_(linear(rgb(kInfinite))) {
  for (std::size_t i = 0; i <= kMapSteps; ++i)
    map_.push_back(linear(colour_at(static_cast<double>(i) / static_cast<double>(kMapSteps))));
  for (std::size_t i = 0; i <= kSteps; ++i) {
    const float root = static_cast<float>(i) / kSteps;
    encoded_.push_back(std::pow(root * root * kBrightest, 1 / kGamma));
    edge_.push_back(std::pow(1 - root, kGlassPower));
  }
}

Vec3f Light::linear(const Vec3f& colour) {
  return colour.unaryExpr([](float x) { return std::pow(x, kGamma); });
}

Vec3f Light::colour_of(float value) const {
  if (value > kCodeLimit) return infinite_;
  if (value < -kCodeLimit) return missing_;
  const float t = std::clamp((value - low_) * factor_, 0.0F, 1.0F);
  return map_[static_cast<std::size_t>(t * kMapSteps + 0.5F)];
}

float Light::encoded(float x) const {
  return encoded_[static_cast<std::size_t>(std::sqrt(std::clamp(x / kBrightest, 0.0F, 1.0F)) * kSteps + 0.5F)];
}

Vec3f Light::lit(const Vec3f& linear_colour, const Vec3f& normal, const Vec3f& to_eye, float gloss) const {
  const Vec3f n = normal.dot(to_eye) < 0 ? Vec3f(-normal) : normal;
  const float light = kAmbient + kKey * std::max(n.dot(key_), 0.0F) + kFill * std::max(n.dot(fill_), 0.0F) +
                      kHead * std::max(n.dot(to_eye), 0.0F);
  const float spark = gloss * power40(std::max(n.dot((key_ + to_eye).normalized()), 0.0F));
  const Vec3f sum = linear_colour * (light * light * kExposure) + Vec3f::Constant(spark);
  return {encoded(sum.x()), encoded(sum.y()), encoded(sum.z())};
}

Light::Glass Light::glass(const Vec3f& normal, const Vec3f& to_eye) const {
  const float dot = normal.dot(to_eye);
  const float edge = edge_[static_cast<std::size_t>(std::clamp(std::abs(dot), 0.0F, 1.0F) * kSteps + 0.5F)];
  const float key = 0.5F + 0.5F * normal.dot(key_) * (dot < 0 ? -1.0F : 1.0F);
  const Vec3f inside = tint_ * (kGlassBase + kGlassKey * key);
  return {inside + (rim_ - inside) * edge,
          std::clamp((kGlass + kGlassEdge * edge) * kGlassOpacity * kGlassFactor, 0.0F, 1.0F)};
}

}  // namespace quench::picture
