// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "base/bucket_queue.h"
#include "quench/error.h"
#include "quench/tree.h"
#include "shape/simple_voxel.h"
#include "shape/voxel_components.h"

namespace quench {
namespace {

using Voxel = std::array<std::int64_t, 3>;

/// The voxels on a straight way between two points in lattice coordinates, each with a face in common with the one
/// before.
template <class Visit>
void walk_voxels(const Vec3& from, const Vec3& to, const Visit& visit) {
  Voxel voxel, last;
  std::array<double, 3> next, each;
  std::int64_t crossings = 0;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    voxel[axis] = static_cast<std::int64_t>(std::floor(from[i]));
    last[axis] = static_cast<std::int64_t>(std::floor(to[i]));
    const double way = to[i] - from[i], border = static_cast<double>(voxel[axis]) + (way > 0 ? 1 : 0);
    next[axis] = way != 0 ? (border - from[i]) / way : std::numeric_limits<double>::infinity();
    each[axis] = way != 0 ? 1 / std::abs(way) : std::numeric_limits<double>::infinity();
    crossings += std::abs(last[axis] - voxel[axis]);
  }
  for (visit(voxel); crossings > 0; --crossings) {
    // Rounding must not lead past the last voxel.
    std::size_t axis = 3;
    for (std::size_t i = 0; i < 3; ++i)
      if (voxel[i] != last[i] && (axis == 3 || next[i] < next[axis])) axis = i;
    voxel[axis] += last[axis] > voxel[axis] ? 1 : -1;
    next[axis] += each[axis];
    visit(voxel);
  }
}

/// Grows the voxels of a forest from one voxel per tree: along the courses of the graph first, thick ones before thin
/// ones, then into the shape, near before far. A voxel is only added where that keeps the topology; so that of the
/// result is that of the seeds, and where courses or tubes meet that the graph does not connect, a layer of voxels
/// stays away.
class Growth {
 public:
  Growth(const VoxelShape& shape, const Repaired& repaired, Context* context)
      : shape_(shape), grid_(shape.grid()), repaired_(repaired), context_(context) {}

  VoxelShape run() {
    draw_courses();
    fill_bridges();
    const VoxelShape room = room_to_grow();
    checkpoint(context_, "edited shape", 0.2);
    open_box(room);
    plant_seeds();
    grow();
    checkpoint(context_, "edited shape", 1);
    return grown_shape();
  }

 private:
  enum Flag : std::uint8_t { kRoom = 1, kGrown = 2, kBlocked = 4, kCourse = 8 };
  struct Mark {
    Voxel voxel;
    std::uint32_t point;  // of the courses: the next one
    friend bool operator<(const Mark& a, const Mark& b) {
      return std::tie(a.voxel[2], a.voxel[1], a.voxel[0], a.point) <
             std::tie(b.voxel[2], b.voxel[1], b.voxel[0], b.point);
    }
  };

  bool in_grid(const Voxel& v) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (v[i] < 0 || v[i] >= grid_.dims[i]) return false;
    return true;
  }
  Vec3 clamped(const Vec3& world) const {
    Vec3 at = grid_.lattice(world);
    for (int i = 0; i < 3; ++i)
      at[i] = std::clamp(at[i], 0.0, static_cast<double>(grid_.dims[static_cast<std::size_t>(i)]) - 1e-6);
    return at;
  }
  static Voxel voxel_of(const Vec3& lattice) {
    return {static_cast<std::int64_t>(std::floor(lattice[0])), static_cast<std::int64_t>(std::floor(lattice[1])),
            static_cast<std::int64_t>(std::floor(lattice[2]))};
  }

  void draw_courses() {
    const double least = 0.5 * grid_.spacing.minCoeff();
    const auto add_point = [&](const Vec3& point, double radius) {
      points_.push_back(point);
      radius_.push_back(std::max(radius, least));
      thickest_ = std::max(thickest_, radius_.back());
    };
    for (const CurveGraph::Branch& branch : repaired_.graph.branches)
      for (std::size_t i = 0; i < branch.points.size(); ++i) {
        add_point(branch.points[i], branch.radius[i]);
        const auto number = static_cast<std::uint32_t>(points_.size() - 1);
        walk_voxels(clamped(branch.points[i == 0 ? 0 : i - 1]), clamped(branch.points[i]), [&](const Voxel& voxel) {
          course_.push_back({voxel, number});
        });
      }
    for (const CurveGraph::Node& node : repaired_.graph.nodes) {
      if (node.degree > 0) continue;
      add_point(node.point, node.radius);
      course_.push_back({voxel_of(clamped(node.point)), static_cast<std::uint32_t>(points_.size() - 1)});
    }
    std::sort(course_.begin(), course_.end());
    course_.erase(
        std::unique(course_.begin(), course_.end(), [](const Mark& a, const Mark& b) { return a.voxel == b.voxel; }),
        course_.end());
    for (const Mark& mark : course_) added_.push_back(mark.voxel);
  }

  // Voxels whose centres are nearer to a bridge than its radius there.
  void fill_bridges() {
    for (std::size_t b = 0; b < repaired_.bridged.size(); ++b) {
      const CurveGraph::Branch& branch = repaired_.graph.branches[b];
      for (std::size_t s = 0; s < repaired_.bridged[b].size(); ++s)
        if (repaired_.bridged[b][s])
          fill_tube(branch.points[s], branch.radius[s], branch.points[s + 1], branch.radius[s + 1]);
    }
  }
  void fill_tube(const Vec3& a, double radius_a, const Vec3& b, double radius_b) {
    const Vec3 along = b - a;
    const double l2 = along.squaredNorm(), most = std::max(radius_a, radius_b);
    const Vec3 p = grid_.lattice(a), q = grid_.lattice(b), margin = Vec3::Constant(most).cwiseQuotient(grid_.spacing);
    Voxel low, high;
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<std::size_t>(i);
      low[axis] = std::max<std::int64_t>(static_cast<std::int64_t>(std::floor(std::min(p[i], q[i]) - margin[i])), 0);
      high[axis] =
          std::min(static_cast<std::int64_t>(std::floor(std::max(p[i], q[i]) + margin[i])), grid_.dims[axis] - 1);
    }
    for (std::int64_t z = low[2]; z <= high[2]; ++z)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t x = low[0]; x <= high[0]; ++x) {
          const Vec3 centre = centre_of({x, y, z});
          const double t = l2 > 0 ? std::clamp((centre - a).dot(along) / l2, 0.0, 1.0) : 0;
          if ((centre - a - t * along).norm() <= (1 - t) * radius_a + t * radius_b) added_.push_back({x, y, z});
        }
  }
  Vec3 centre_of(const Voxel& v) const {
    return grid_.world(Vec3(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])) +
                       Vec3::Constant(0.5));
  }

  // The components of the shape that courses run through, courses and bridges, without cavities.
  VoxelShape room_to_grow() {
    std::sort(added_.begin(), added_.end(),
              [](const Voxel& a, const Voxel& b) { return std::tie(a[2], a[1], a[0]) < std::tie(b[2], b[1], b[0]); });
    base::UnionFind sets = shape::foreground_components(shape_, context_);
    std::vector<char> kept(shape_.runs().size(), 0);
    for (const Mark& mark : course_) {
      const auto row = shape_.row(mark.voxel[1], mark.voxel[2]);
      for (const Run& run : row)
        if (run.begin <= mark.voxel[0] && mark.voxel[0] < run.end)
          kept[sets.find(static_cast<std::uint32_t>(&run - shape_.runs().data()))] = 1;
    }
    VoxelShape room(grid_);
    std::vector<Run> runs;
    std::size_t next = 0;
    shape::for_scanlines(shape_, nullptr, "", [&](std::int64_t y, std::int64_t z) {
      runs.clear();
      for (const Run& run : shape_.row(y, z))
        if (kept[sets.find(static_cast<std::uint32_t>(&run - shape_.runs().data()))]) runs.push_back(run);
      for (; next < added_.size() && added_[next][1] == y && added_[next][2] == z; ++next) {
        const auto x = static_cast<std::int32_t>(added_[next][0]);
        runs.push_back({x, x + 1});
      }
      std::ranges::sort(runs, {}, &Run::begin);
      room.append_row(runs);
    });
    ForegroundOptions filling;
    filling.fill_cavities = true;
    return room.empty() ? room : clean(room, filling, nullptr, nullptr);
  }

  void open_box(const VoxelShape& room) {
    const VoxelShape::Box box = room.foreground_box();
    for (std::size_t i = 0; i < 3; ++i) {
      low_[i] = box.begin[i] - 1;
      size_[i] = box.end[i] - box.begin[i] + 2;
    }
    const double voxels = static_cast<double>(size_[0]) * static_cast<double>(size_[1]) * static_cast<double>(size_[2]);
    if (voxels > std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorCode::failed,
                  "the box around the shape has more than 2^32 voxels, too many for the edited shape", "edited shape");
    step_ = {1, size_[0], size_[0] * size_[1]};
    flags_.assign(static_cast<std::size_t>(size_[0] * size_[1] * size_[2]), 0);
    for (std::int64_t z = box.begin[2]; z < box.end[2]; ++z)
      for (std::int64_t y = box.begin[1]; y < box.end[1]; ++y)
        for (const Run& run : room.row(y, z)) {
          const std::size_t first = index({run.begin, y, z});
          std::fill_n(flags_.begin() + static_cast<std::ptrdiff_t>(first), run.end - run.begin, std::uint8_t{kRoom});
        }
    for (const Mark& mark : course_) flags_[index(mark.voxel)] |= kCourse;
  }
  std::size_t index(const Voxel& v) const {
    return static_cast<std::size_t>((v[0] - low_[0]) * step_[0] + (v[1] - low_[1]) * step_[1] +
                                    (v[2] - low_[2]) * step_[2]);
  }
  Voxel voxel(std::size_t i) const {
    const auto n = static_cast<std::int64_t>(i);
    return {low_[0] + n % size_[0], low_[1] + n / step_[1] % size_[1], low_[2] + n / step_[2]};
  }
  std::size_t neighbour(std::size_t i, int n) const {
    return static_cast<std::size_t>(static_cast<std::int64_t>(i) + (n % 3 - 1) * step_[0] + (n / 3 % 3 - 1) * step_[1] +
                                    (n / 9 - 1) * step_[2]);
  }

  // The thickest voxel of each tree that is not beside that of another one; where there is none, one that has no face
  // in common with it.
  void plant_seeds() {
    std::vector<std::vector<std::pair<double, Vec3>>> places(repaired_.graph.components);
    for (const CurveGraph::Branch& branch : repaired_.graph.branches)
      for (std::size_t i = 0; i < branch.points.size(); ++i)
        places[branch.component].push_back({-branch.radius[i], branch.points[i]});
    for (const CurveGraph::Node& node : repaired_.graph.nodes)
      if (node.degree == 0) places[node.component].push_back({-node.radius, node.point});
    for (auto& of_tree : places) {
      std::ranges::stable_sort(of_tree, {}, [](const auto& place) { return place.first; });
      const auto plant = [&](std::uint32_t neighbours) {
        for (const auto& [radius, point] : of_tree) {
          const std::size_t i = index(voxel_of(clamped(point)));
          if ((flags_[i] & kGrown) || (around(i) & neighbours)) continue;
          flags_[i] |= kGrown;
          seeds_.push_back(i);
          return true;
        }
        return false;
      };
      if (!plant(~0u)) plant(shape::kFaceNeighbours);
    }
  }

  using Queue = base::BucketQueue<std::uint64_t>;

  std::uint32_t point_at(std::size_t i) const {
    const Mark wanted{voxel(i), 0};
    return std::lower_bound(course_.begin(), course_.end(), wanted)->point;
  }
  double distance(const Vec3& centre, std::uint32_t point) const {
    return (centre - points_[point]).norm() / radius_[point];
  }

  // Courses come first. What is near to a tube for its radius belongs to it.
  void push(Queue& queue, std::size_t i, std::uint32_t point) const {
    if (flags_[i] & kCourse) {
      const std::uint32_t own = point_at(i);
      queue.push(-radius_[own] / thickest_, std::uint64_t{i} << 32 | own);
      return;
    }
    const Vec3 centre = centre_of(voxel(i));
    double nearest = distance(centre, point);
    for (const int way : {-1, 1})
      while (true) {
        const std::uint32_t other = point + static_cast<std::uint32_t>(way);
        if (other >= points_.size()) break;
        const double there = distance(centre, other);
        if (there >= nearest) break;
        nearest = there;
        point = other;
      }
    queue.push(nearest, std::uint64_t{i} << 32 | point);
  }

  void grow() {
    Queue queue(-1, 1.0 / 64);
    for (const std::size_t i : seeds_) push_neighbours(queue, i, point_at(i));
    Queue::Entry entry{};
    const auto is_grown = [&](const Queue::Entry& e) { return (flags_[e.id >> 32] & kGrown) != 0; };
    std::uint64_t steps = 0;
    while (queue.pop(entry, is_grown)) {
      if (++steps % 65536 == 0) checkpoint(context_, "edited shape", 0.5);
      const auto i = static_cast<std::size_t>(entry.id >> 32);
      if (is_grown(entry)) continue;
      if (!shape::is_simple(around(i))) {
        flags_[i] |= kBlocked;
        continue;
      }
      flags_[i] = static_cast<std::uint8_t>((flags_[i] | kGrown) & ~kBlocked);
      push_neighbours(queue, i, static_cast<std::uint32_t>(entry.id));
    }
  }

  // Voxels that were not simple may have become so.
  void push_neighbours(Queue& queue, std::size_t i, std::uint32_t point) {
    for (int n = 0; n < 27; ++n) {
      const std::size_t j = neighbour(i, n);
      const std::uint8_t flags = flags_[j];
      if (!(flags & kRoom) || (flags & kGrown)) continue;
      const bool face = shape::kFaceNeighbours >> n & 1u;
      if (!face && !(flags & kBlocked)) continue;
      flags_[j] = static_cast<std::uint8_t>(flags & ~kBlocked);
      push(queue, j, point);
    }
  }

  shape::Neighbours around(std::size_t i) const {
    shape::Neighbours result = 0;
    for (int n = 0; n < 27; ++n)
      if (flags_[neighbour(i, n)] & kGrown) result |= 1u << n;
    return result & ~shape::kCentre;
  }

  VoxelShape grown_shape() const {
    VoxelShape result(grid_);
    std::vector<Run> runs;
    for (std::int64_t z = 0; z < grid_.dims[2]; ++z)
      for (std::int64_t y = 0; y < grid_.dims[1]; ++y) {
        runs.clear();
        const std::int64_t row = y - low_[1], slice = z - low_[2];
        if (row >= 0 && row < size_[1] && slice >= 0 && slice < size_[2])
          for (std::int64_t x = 0; x < size_[0]; ++x)
            if (flags_[static_cast<std::size_t>(x + row * step_[1] + slice * step_[2])] & kGrown) {
              const auto at = static_cast<std::int32_t>(x + low_[0]);
              runs.push_back({at, at + 1});
            }
        result.append_row(runs);
      }
    return result;
  }

  const VoxelShape& shape_;
  const Grid& grid_;
  const Repaired& repaired_;
  Context* context_;
  std::vector<Vec3> points_;  // of all courses, branch by branch
  std::vector<double> radius_;
  double thickest_ = 0;
  std::vector<Mark> course_;  // voxels of courses, in order of z, y, x
  std::vector<Voxel> added_;  // of courses and bridges
  Voxel low_{}, size_{}, step_{};
  std::vector<std::uint8_t> flags_;  // per voxel of the box
  std::vector<std::size_t> seeds_;
};

}  // namespace

VoxelShape edited_shape(const VoxelShape& shape, const CurveGraph& /*graph*/, const Repaired& repaired,
                        Context* context) {
  const CurveGraph& tree = repaired.graph;
  if (tree.sheets > 0 || tree.branches.size() + tree.components != tree.nodes.size())
    throw Error(ErrorCode::usage, "the edited shape is that of a graph without loops", "repair");
  return Growth(shape, repaired, context).run();
}

}  // namespace quench
