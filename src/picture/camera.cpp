// SPDX-License-Identifier: Apache-2.0
#include "picture/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/text.h"

namespace quench::picture {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double tangent() { return std::tan(kField / 2 * std::numbers::pi / 180); }

/// Places around the balls of tubes, of many some: where what is drawn of them ends.
std::vector<Vec3f> outsides(const Scene& scene) {
  std::vector<Vec3f> places;
  for (std::size_t i = 0; i < scene.points.size(); i += scene.points.size() / 20000 + 1)
    for (int axis = 0; axis < 3; ++axis)
      for (const float sign : {-1.0F, 1.0F})
        places.push_back(scene.points[i] + Vec3f(Vec3f::Unit(axis) * (sign * scene.radius[i])));
  return places;
}

/// The shape is a volume: its file says so.
bool stands_on_z(const Page& page) {
  for (const auto& [what, name] : page.files) {
    if (what != "shape") continue;
    std::string lower = name;
    for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    for (const char* end : {".nrrd", ".nhdr", ".nii", ".nii.gz", ".mha", ".mhd", ".mrc", ".map", ".vol", ".npy", ".tif",
                            ".tiff", ".sof", ".out", ".h5", ".hdf5", ".hdf", ".ims", ".dcm"})
      if (lower.ends_with(end)) return true;
  }
  return false;
}

}  // namespace

double Camera::focus() const { return height_ / 2.0 / tangent(); }

void Camera::look(const Vec3& position, const Vec3& target, const Vec3& up) {
  target_ = target;
  eye_ = position;
  distance_ = std::max(1e-6, (position - target).norm());
  Vec3 back = position - target;
  back = back.norm() > 0 ? Vec3(back.normalized()) : Vec3(Vec3::UnitZ());
  Vec3 right = up.cross(back);
  // Up along the line of sight says nothing: any direction across it will do.
  if (!(right.norm() > 1e-9 * up.norm()))
    right = std::abs(back.z()) < 0.9 ? Vec3::UnitZ().cross(back) : Vec3::UnitX().cross(back);
  right.normalize();
  turn_ << right.transpose(), back.cross(right).transpose(), back.transpose();
}

void Camera::frame(std::span<const Vec3f> points, std::size_t stride) {
  std::vector<Vec3> seen;
  for (std::size_t i = 0; i < points.size(); i += stride) seen.push_back(turn_ * points[i].cast<double>());
  if (seen.empty()) return;
  Vec3 low = seen[0], high = seen[0];
  for (const Vec3& p : seen) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double per_height = height_ / std::max(1.0, height_ - insets_.top - insets_.bottom);
  const double per_width = height_ / std::max(1.0, width_ - insets_.left - insets_.right);
  Vec3 middle = 0.5 * (low + high);
  // More than once: perspective moves the middle of what is seen.
  for (int round = 0; round < 4; ++round) {
    double need = 0, bottom = kInfinity, top = -kInfinity, left = kInfinity, right = -kInfinity;
    for (const Vec3& p : seen) {
      const Vec3 d = p - middle;
      need = std::max(
          {need, std::abs(d.x()) * per_width / tangent() + d.z(), std::abs(d.y()) * per_height / tangent() + d.z()});
      const double w = distance_ - d.z();
      left = std::min(left, d.x() / w);
      right = std::max(right, d.x() / w);
      bottom = std::min(bottom, d.y() / w);
      top = std::max(top, d.y() / w);
    }
    distance_ = std::max(1e-3, need * kMargin);
    if (round == 0 || round == 3) continue;
    middle.x() += (left + right) / 2 * distance_;
    middle.y() += (bottom + top) / 2 * distance_;
  }
  target_ = turn_.transpose() * middle;
  eye_ = target_ + distance_ * turn_.row(2).transpose();
}

/// From the front, y as the page says, whatever the direction that was asked for.
void look_at_plane(Camera& camera, bool y_down, const Vec3& target, double distance) {
  const double sign = y_down ? -1 : 1;
  camera.look(target + sign * distance * Vec3::UnitZ(), target, sign * Vec3::UnitY());
}

Camera first_look(const Page& page, const ViewState& state, const Scene& scene, int width, int height,
                  const Insets& insets) {
  Camera camera(width, height, insets);
  if (state.camera) {
    const auto& c = *state.camera;
    const Vec3 position = scene.placement.to_scene({c[0], c[1], c[2]}),
               target = scene.placement.to_scene({c[3], c[4], c[5]});
    if (page.plane)
      look_at_plane(camera, page.y_down, target, (position - target).norm());
    else
      camera.look(position, target, {c[6], c[7], c[8]});
    return camera;
  }
  if (state.layer == "tree" && page.tree) {
    camera.look(3 * page.tree->to_eye, Vec3::Zero(), page.tree->up);
    camera.frame(outsides(scene), 1);
    return camera;
  }
  const bool on_z = stands_on_z(page);
  const Vec3 to_eye = on_z ? kFirstLookOnZ : kFirstLookOnY;
  if (page.plane)
    look_at_plane(camera, page.y_down, Vec3::Zero(), 3);
  else
    camera.look(3 * to_eye.normalized(), Vec3::Zero(), on_z ? Vec3::UnitZ() : Vec3::UnitY());
  const std::vector<Vec3f>& framed = scene.shape_points.empty() ? scene.points : scene.shape_points;
  camera.frame(framed, framed.size() / 20000 + 1);
  return camera;
}

}  // namespace quench::picture
