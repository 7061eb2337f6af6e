// SPDX-License-Identifier: Apache-2.0
#include "tree/course.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace quench::tree {

void Course::append(const Tree::Branch& branch) {
  for (std::size_t i = points_.empty() ? 0 : 1; i < branch.points.size(); ++i)
    append(branch.points[i], branch.radius[i]);
}

void Course::append(const Vec3& point, double radius) {
  at_.push_back(points_.empty() ? 0 : at_.back() + (point - points_.back()).norm());
  points_.push_back(point);
  radius_.push_back(radius);
}

Course Course::reversed(double length) const {
  Course back;
  for (std::size_t i = points_.size(); i-- > 0 && (back.size() == 0 || back.length() < length);)
    back.append(points_[i], radius_[i]);
  return back;
}

std::pair<std::size_t, double> Course::place(double length) const {
  const auto after = std::upper_bound(at_.begin(), at_.end(), length);
  if (after == at_.begin()) return {0, 0};
  if (after == at_.end()) return {at_.size() - 1, 0};
  const auto i = static_cast<std::size_t>(after - at_.begin()) - 1;
  return {i, (length - at_[i]) / (at_[i + 1] - at_[i])};
}

Vec3 Course::point_at(double length) const {
  const auto [i, t] = place(length);
  return t == 0 ? points_[i] : Vec3((1 - t) * points_[i] + t * points_[i + 1]);
}

double Course::radius_at(double length) const {
  const auto [i, t] = place(length);
  return t == 0 ? radius_[i] : (1 - t) * radius_[i] + t * radius_[i + 1];
}

Course smoothed(const Course& course) {
  constexpr int kSteps = 4;  // to each side
  Course result;
  for (std::size_t i = 0; i < course.size(); ++i) {
    const double at = course.at()[i], reach = std::min({course.radius()[i], at, course.length() - at});
    Vec3 sum = kSteps * course.points()[i];
    for (int k = 1; k < kSteps; ++k)
      sum += (kSteps - k) * (course.point_at(at - reach * k / kSteps) + course.point_at(at + reach * k / kSteps));
    result.append(reach > 0 ? Vec3(sum / (kSteps * kSteps)) : course.points()[i], course.radius()[i]);
  }
  return result;
}

namespace {

// Calls visit(i) for each segment i, i + 1 that lies between two lengths, at least in part. A course of one point has
// one, from it to itself.
template <class Visit>
void for_segments(const Course& course, double low, double high, const Visit& visit) {
  if (course.size() == 1) visit(std::size_t{0}, std::size_t{0});
  for (std::size_t i = 0; i + 1 < course.size(); ++i)
    if (course.at()[i + 1] >= low && course.at()[i] <= high) visit(i, i + 1);
}

void offer(Foot& best, double at, double distance) {
  if (distance < best.distance) best = {at, distance};
}

}  // namespace

Foot nearest_on(const Course& course, const Vec3& point, double low, double high) {
  Foot best;
  for_segments(course, low, high, [&](std::size_t i, std::size_t j) {
    const Vec3 &a = course.points()[i], d = course.points()[j] - a;
    const double dd = d.squaredNorm();
    const double t = dd > 0 ? std::clamp((point - a).dot(d) / dd, 0.0, 1.0) : 0;
    offer(best, course.at()[i] + t * (course.at()[j] - course.at()[i]), (point - a - t * d).norm());
  });
  return best;
}

Foot nearest_to_ray(const Course& course, const Vec3& from, const Vec3& direction, double low, double high) {
  Foot best;
  for_segments(course, low, high, [&](std::size_t i, std::size_t j) {
    const Vec3 &a = course.points()[i], d = course.points()[j] - a;
    // Seen along the ray the segment is a segment of the plane: where is it nearest to the origin?
    const Vec3 w = a - from, flat = d - d.dot(direction) * direction, start = w - w.dot(direction) * direction;
    const double ff = flat.squaredNorm();
    const double t = ff > 0 ? std::clamp(-start.dot(flat) / ff, 0.0, 1.0) : 0;
    for (const double u : {t, 0.0, 1.0}) {
      const Vec3 x = w + u * d;
      const double along = std::max(0.0, x.dot(direction));
      offer(best, course.at()[i] + u * (course.at()[j] - course.at()[i]), (x - along * direction).norm());
    }
  });
  return best;
}

Window window_of(const Course& course, double ball) {
  constexpr int kStations = 5;
  const double end = ball > 0 ? std::min(course.length(), kWindow * ball) : course.length();
  const double begin = end / 3;
  Window window;
  window.direction = course.point_at(end) - course.point_at(begin);
  for (int i = 0; i < kStations; ++i)
    window.radius += course.radius_at(begin + (end - begin) * i / (kStations - 1)) / kStations;
  return window;
}

double radius_integral(const Course& course, double length) {
  double sum = 0;
  for (std::size_t i = 1; i < course.size() && course.at()[i - 1] < length; ++i) {
    const double end = std::min(length, course.at()[i]);
    sum += (end - course.at()[i - 1]) * (course.radius()[i - 1] + course.radius_at(end)) / 2;
  }
  return sum;
}

double angle_between(const Vec3& a, const Vec3& b) {
  const double sine = a.cross(b).norm(), cosine = a.dot(b);
  return sine == 0 && cosine == 0 ? std::numbers::pi / 2 : std::atan2(sine, cosine);
}

}  // namespace quench::tree
