// SPDX-License-Identifier: Apache-2.0
#include "io/polygon/svg_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/common/words.h"

namespace quench::io {
namespace {

// Products and squares of numbers below this do not overflow.
constexpr double kLargest = 1e100;

}  // namespace

SvgPath::Subpath& SvgPath::subpath() {
  if (!begun_ || subpaths_.empty()) subpaths_.push_back({transform_ * start_, {}});
  begun_ = true;
  return subpaths_.back();
}

void SvgPath::move_to(const Vec2& p) {
  at_ = start_ = p;
  begun_ = false;
}

void SvgPath::line_to(const Vec2& p) {
  subpath().pieces.push_back({false, {p, p, transform_ * p}});
  at_ = p;
}

void SvgPath::cubic_to(const Vec2& a, const Vec2& b, const Vec2& end) {
  subpath().pieces.push_back({true, {transform_ * a, transform_ * b, transform_ * end}});
  at_ = end;
}

void SvgPath::arc_to(const Vec2& radii, double degrees, bool large, bool clockwise, const Vec2& end) {
  Vec2 r = radii.cwiseAbs();
  if (end == at_) return;
  if (r.minCoeff() == 0) return line_to(end);
  const Eigen::Rotation2Dd turn(degrees * std::numbers::pi / 180);
  const Vec2 half = turn.inverse() * Vec2((at_ - end) / 2);
  const double reach = half.cwiseQuotient(r).squaredNorm();
  if (reach > 1) r *= std::sqrt(reach);     // too short to reach: as long as they must be
  const Vec2 unit = half.cwiseQuotient(r);  // on the circle of radius 1, the ends are centre + unit and centre - unit
  const double length = unit.squaredNorm();
  const double rise = length > 0 ? std::sqrt(std::max(0.0, 1 / length - 1)) * (large == clockwise ? -1 : 1) : 0;
  const Vec2 centre(rise * unit[1], -rise * unit[0]);
  const Vec2 from = unit - centre, to = -unit - centre;
  double sweep = std::atan2(from[0] * to[1] - from[1] * to[0], from.dot(to));
  if (clockwise && sweep < 0) sweep += 2 * std::numbers::pi;
  if (!clockwise && sweep > 0) sweep -= 2 * std::numbers::pi;
  if (!(std::abs(sweep) > 0)) return line_to(end);  // radii so much larger or smaller that nothing can be computed
  const Vec2 middle = (at_ + end) / 2;
  const auto place = [&](const Vec2& p) -> Vec2 { return middle + turn * Vec2(r.cwiseProduct(centre + p)); };
  const int pieces = static_cast<int>(std::ceil(std::abs(sweep) / (std::numbers::pi / 8)));
  const double step = sweep / pieces, handle = 4.0 / 3 * std::tan(step / 4), first = std::atan2(from[1], from[0]);
  for (int k = 0; k < pieces; ++k) {
    const double a = first + k * step, b = first + (k + 1) * step;
    const Vec2 pa(std::cos(a), std::sin(a)), pb(std::cos(b), std::sin(b));
    cubic_to(place(pa + handle * Vec2(-pa[1], pa[0])), place(pb - handle * Vec2(-pb[1], pb[0])),
             k + 1 == pieces ? end : place(pb));
  }
}

Polygons SvgPath::flattened(double tolerance) const {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  const auto widen = [&](const Vec2& p) {
    if (!(p.array().abs() < kLargest).all()) throw SvgDamage{"its coordinates are too large"};
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  };
  for (const Subpath& subpath : subpaths_) {
    widen(subpath.start);
    for (const Piece& piece : subpath.pieces)
      for (const Vec2& p : piece.curve ? std::span(piece.points) : std::span(piece.points).last(1)) widen(p);
  }
  const double off = tolerance * (high - low).maxCoeff();
  Polygons result;
  for (const Subpath& subpath : subpaths_) {
    std::vector<Vec2> ring{subpath.start};
    for (const Piece& piece : subpath.pieces) {
      const Vec2 from = ring.back();
      const auto& [a, b, end] = piece.points;
      if (piece.curve) {
        // Wang's bound: n chords of a cubic curve are off by at most 6/8 of its largest second difference over n^2.
        const double bend = std::max((from - 2 * a + b).norm(), (a - 2 * b + end).norm());
        constexpr double most = 1 << 16;
        const double chords = bend > 0 ? std::min(most, std::ceil(std::sqrt(0.75 * bend / off))) : 1;
        for (int k = 1; k < chords; ++k) {
          const double t = k / chords, s = 1 - t;
          ring.emplace_back(s * s * s * from + 3 * s * s * t * a + 3 * s * t * t * b + t * t * t * end);
        }
      }
      ring.push_back(end);
    }
    // Drawing programs round: a curve that ends where it began misses that by a little, and would cross itself there.
    while (ring.size() > 3 && ring.back() != ring.front() && (ring.back() - ring.front()).norm() <= off)
      ring.pop_back();
    const auto second = std::find_if(ring.begin(), ring.end(), [&](const Vec2& p) { return p != ring.front(); });
    if (std::any_of(second, ring.end(), [&](const Vec2& p) { return p != ring.front() && p != *second; }))
      result.rings.push_back(std::move(ring));
  }
  return result;
}

namespace {

/// Numbers of SVG, which need no space between them where a sign or a second point begins the next.
class SvgNumbers {
 public:
  explicit SvgNumbers(std::string_view text) : text_(text) {}

  void pass_blanks() { text_.remove_prefix(std::min(text_.find_first_not_of(" \t\r\n\f"), text_.size())); }
  void pass_separator() {
    pass_blanks();
    if (text_.starts_with(',')) text_.remove_prefix(1);
    pass_blanks();
  }
  bool at_end() const { return text_.empty(); }
  bool at_number() const { return !text_.empty() && std::string_view("0123456789+-.").find(text_[0]) != text_.npos; }
  char take() {
    const char c = text_.front();
    text_.remove_prefix(1);
    return c;
  }
  std::string_view take_until(char end) {
    const std::size_t length = std::min(text_.find(end), text_.size());
    const std::string_view taken = text_.substr(0, length);
    text_.remove_prefix(std::min(length + 1, text_.size()));
    return taken;
  }

  double number() {
    const auto digits = [&](std::size_t at) {
      while (at < text_.size() && text_[at] >= '0' && text_[at] <= '9') ++at;
      return at;
    };
    std::size_t end = text_.starts_with('+') || text_.starts_with('-') ? 1 : 0;
    end = digits(end);
    if (end < text_.size() && text_[end] == '.') end = digits(end + 1);
    if (end < text_.size() && (text_[end] == 'e' || text_[end] == 'E')) {
      std::size_t exponent = end + 1;
      if (exponent < text_.size() && (text_[exponent] == '+' || text_[exponent] == '-')) ++exponent;
      if (digits(exponent) > exponent) end = digits(exponent);
    }
    double value = 0;
    if (!parse_number(text_.substr(0, end), value) || !(std::abs(value) < kLargest)) fail();
    text_.remove_prefix(end);
    pass_separator();
    return value;
  }
  bool flag() {
    if (!text_.starts_with('0') && !text_.starts_with('1')) fail();
    const bool value = take() == '1';
    pass_separator();
    return value;
  }
  [[noreturn]] void fail() const {
    throw SvgDamage{fmt::format("a number is missing before '{}'", text_.substr(0, 20))};
  }

 private:
  std::string_view text_;
};

/// The commands of a path.
class PathData {
 public:
  PathData(std::string_view text, SvgPath& path) : text_(text), path_(path) {}

  void read() {
    text_.pass_blanks();
    for (char command = 0; !text_.at_end();) {
      if (!text_.at_number()) {
        const bool first = command == 0;
        command = text_.take();
        text_.pass_blanks();
        if (first && command != 'M' && command != 'm') throw SvgDamage{"a path must begin with M"};
      } else if (command == 0 || command == 'Z' || command == 'z') {
        throw SvgDamage{"a path has numbers without a command"};
      } else if (command == 'M' || command == 'm') {
        command = command == 'M' ? 'L' : 'l';  // more points after that of M are those of lines
      }
      segment(command);
    }
  }

 private:
  Vec2 point(bool relative) {
    const double x = text_.number(), y = text_.number();
    return relative ? Vec2(path_.at() + Vec2(x, y)) : Vec2(x, y);
  }
  void quadratic_to(const Vec2& control, const Vec2& end) {
    const Vec2 at = path_.at();
    path_.cubic_to(at + 2.0 / 3 * (control - at), end + 2.0 / 3 * (control - end), end);
    quadratic_ = control;
  }

  void segment(char command) {
    const bool relative = command >= 'a';
    const char kind = relative ? static_cast<char>(command - 'a' + 'A') : command;
    const Vec2 at = path_.at();
    const bool after_cubic = last_ == 'C' || last_ == 'S', after_quadratic = last_ == 'Q' || last_ == 'T';
    switch (kind) {
      case 'M':
        path_.move_to(point(relative));
        break;
      case 'L':
        path_.line_to(point(relative));
        break;
      case 'H':
        path_.line_to(Vec2(text_.number() + (relative ? at[0] : 0), at[1]));
        break;
      case 'V':
        path_.line_to(Vec2(at[0], text_.number() + (relative ? at[1] : 0)));
        break;
      case 'C':
      case 'S': {
        const Vec2 a = kind == 'C' ? point(relative) : after_cubic ? Vec2(2 * at - cubic_) : at;
        cubic_ = point(relative);
        path_.cubic_to(a, cubic_, point(relative));
        break;
      }
      case 'Q': {
        const Vec2 control = point(relative);
        quadratic_to(control, point(relative));
        break;
      }
      case 'T':
        quadratic_to(after_quadratic ? Vec2(2 * at - quadratic_) : at, point(relative));
        break;
      case 'A': {
        const double rx = text_.number(), ry = text_.number(), degrees = text_.number();
        const bool large = text_.flag(), clockwise = text_.flag();
        path_.arc_to(Vec2(rx, ry), degrees, large, clockwise, point(relative));
        break;
      }
      case 'Z':
        path_.close();
        break;
      default:
        throw SvgDamage{fmt::format("a path has no command '{}'", command)};
    }
    last_ = kind;
  }

  SvgNumbers text_;
  SvgPath& path_;
  char last_ = 0;
  Vec2 cubic_{0, 0}, quadratic_{0, 0};  // the last control point of the last curve
};

SvgTransform one_transform(std::string_view name, const std::vector<double>& n) {
  const auto numbers = [&](std::size_t least, std::size_t most) {
    if (n.size() < least || n.size() > most)
      throw SvgDamage{fmt::format("the transform '{}' has {} numbers", name, n.size())};
  };
  SvgTransform result = SvgTransform::Identity();
  const double radians = std::numbers::pi / 180;
  if (name == "translate") {
    numbers(1, 2);
    result.translate(Vec2(n[0], n.size() > 1 ? n[1] : 0));
  } else if (name == "scale") {
    numbers(1, 2);
    result.scale(Vec2(n[0], n.size() > 1 ? n[1] : n[0]));
  } else if (name == "rotate") {
    numbers(1, 3);
    const Vec2 centre = n.size() == 3 ? Vec2(n[1], n[2]) : Vec2(0, 0);
    result.translate(centre).rotate(n[0] * radians).translate(-centre);
  } else if (name == "skewX" || name == "skewY") {
    numbers(1, 1);
    result.linear()(name == "skewX" ? 0 : 1, name == "skewX" ? 1 : 0) = std::tan(n[0] * radians);
  } else if (name == "matrix") {
    numbers(6, 6);
    result.matrix().topRows<2>() << n[0], n[2], n[4], n[1], n[3], n[5];
  } else {
    throw SvgDamage{fmt::format("the transform '{}' is unknown", name.substr(0, 20))};
  }
  return result;
}

}  // namespace

void read_path_data(std::string_view text, SvgPath& path) { PathData(text, path).read(); }

std::vector<double> read_svg_numbers(std::string_view text) {
  SvgNumbers numbers(text);
  std::vector<double> result;
  for (numbers.pass_blanks(); !numbers.at_end();) result.push_back(numbers.number());
  return result;
}

SvgTransform read_svg_transform(std::string_view text) {
  SvgNumbers left(text);
  SvgTransform result = SvgTransform::Identity();
  for (left.pass_separator(); !left.at_end(); left.pass_separator()) {
    std::string_view name = left.take_until('(');
    name = name.substr(0, name.find_last_not_of(" \t\r\n\f") + 1);
    result = result * one_transform(name, read_svg_numbers(left.take_until(')')));
  }
  return result;
}

}  // namespace quench::io
