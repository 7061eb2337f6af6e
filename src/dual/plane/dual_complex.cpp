#include "dual/plane/dual_complex.h"
#include <algorithm>
#include <map>
#include <set>
namespace quench::dual::plane {
__extension__ using I = __int128;
DualComplex dual_complex(const VoxelShape& shape, std::span<const LatticePoint> sites,
                         const std::array<std::int64_t, 3>& w, Context*) {
  const auto n = static_cast<std::uint32_t>(sites.size());
  const auto X = [&](std::uint32_t i) { return I(sites[i][0]) * w[0]; };
  const auto Y = [&](std::uint32_t i) { return I(sites[i][1]) * w[1]; };
  const auto orient = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return (X(b) - X(a)) * (Y(c) - Y(a)) - (Y(b) - Y(a)) * (X(c) - X(a));
  };
  const auto incircle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    const I ax = X(a) - X(d), ay = Y(a) - Y(d), bx = X(b) - X(d), by = Y(b) - Y(d), cx = X(c) - X(d), cy = Y(c) - Y(d);
    return (ax * ax + ay * ay) * (bx * cy - by * cx) - (bx * bx + by * by) * (ax * cy - ay * cx) +
           (cx * cx + cy * cy) * (ax * by - ay * bx);
  };
  std::map<std::array<int, 2>, std::uint32_t> at;
  for (std::uint32_t i = 0; i < n; ++i) at[{sites[i][0], sites[i][1]}] = i;
  using Edge = std::array<std::uint32_t, 2>;
  std::set<Edge> boundary;
  std::vector<Edge> todo;
  const auto in = [&](int x, int y) { return shape.contains(x, y, 0); };
  for (const auto& s : sites) {
    const int x = s[0], y = s[1];
    if (in(x, y) != in(x, y - 1)) {
      const auto a = at.at({x, y}), b = at.at({x + 1, y});
      boundary.insert(in(x, y) ? Edge{a, b} : Edge{b, a});
    }
    if (in(x, y) != in(x - 1, y)) {
      const auto a = at.at({x, y}), b = at.at({x, y + 1});
      boundary.insert(in(x, y) ? Edge{b, a} : Edge{a, b});
    }
  }
  todo.assign(boundary.begin(), boundary.end());
  std::map<Edge, std::uint32_t> owner;
  std::vector<std::vector<std::uint32_t>> poly;
  std::vector<std::pair<Edge, std::uint32_t>> links;
  while (!todo.empty()) {
    const auto [p, q] = todo.back();
    todo.pop_back();
    if (owner.count({p, q})) continue;
    std::uint32_t best = kNone;
    for (std::uint32_t s = 0; s < n; ++s)
      if (orient(p, q, s) > 0 && (best == kNone || incircle(p, q, best, s) > 0)) best = s;
    std::vector<std::uint32_t> c;
    for (std::uint32_t s = 0; s < n; ++s)
      if (s != p && s != q && orient(p, q, s) > 0 && (s == best || incircle(p, q, best, s) == 0)) c.push_back(s);
    std::sort(c.begin(), c.end(), [&, p = p](auto a, auto b) { return orient(p, a, b) > 0; });
    c.insert(c.begin(), {p, q});
    const auto id = static_cast<std::uint32_t>(poly.size());
    for (std::size_t i = 0; i < c.size(); ++i) {
      const Edge e{c[i], c[(i + 1) % c.size()]};
      owner[e] = id;
      if (!boundary.count(e)) todo.push_back({e[1], e[0]});
    }
    poly.push_back(c);
    std::sort(poly.back().begin(), poly.back().end());
  }
  std::vector<std::uint32_t> order(poly.size()), rank(poly.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return poly[a] < poly[b]; });
  for (std::uint32_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
  DualComplex d;
  d.complex.vertex_count = static_cast<std::uint32_t>(poly.size());
  d.vertex_site_offsets = {0};
  for (auto o : order) {
    d.vertex_sites.insert(d.vertex_sites.end(), poly[o].begin(), poly[o].end());
    d.vertex_site_offsets.push_back(static_cast<std::uint32_t>(d.vertex_sites.size()));
  }
  std::vector<std::pair<Edge, Edge>> edges;
  for (const auto& [e, o] : owner)
    if (e[0] < e[1])
      if (auto f = owner.find({e[1], e[0]}); f != owner.end())
        edges.push_back({{std::min(rank[o], rank[f->second]), std::max(rank[o], rank[f->second])}, e});
  std::sort(edges.begin(), edges.end());
  for (const auto& [ends, s] : edges) {
    d.complex.edges.push_back(ends);
    d.edge_sites.push_back(s);
  }
  return d;
}
}  // namespace quench::dual::plane
