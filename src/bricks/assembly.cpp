// SPDX-License-Identifier: Apache-2.0
#include "bricks/assembly.h"

#include <algorithm>
#include <atomic>

#include "base/parallel.h"
#include "base/return_memory.h"
#include "lattice/polytopes.h"
#include "quench/error.h"

namespace quench::bricks {
namespace {

using lattice::prefix_sum;

template <class T>
void release(std::vector<T>& values) {
  std::vector<T>().swap(values);
}

class Assembly {
 public:
  Assembly(std::vector<BrickPart> parts, std::size_t site_count, Context* context)
      : parts_(std::move(parts)), site_count_(site_count), context_(context) {}

  lattice::DualComplex run() {
    place_vertices();
    resolve();
    place_edges();
    place_faces();
    find_sides();
    return std::move(dual_);
  }

 private:
  // Vertices are sorted by their site lists, so first by their smallest sites; a part has all those of a smallest site.
  void place_vertices() {
    first_vertex_.assign(site_count_ + 1, 0);
    number_.resize(parts_.size());
    base::for_chunks(parts_.size(), context_, "merge", 0, 0.05, [&](std::size_t i) {
      const SiteLists& vertices = parts_[i].vertices;
      for (std::size_t v = 0; v < vertices.count(); ++v) ++first_vertex_[vertices.sites[vertices.offsets[v]] + 1];
    });
    prefix_sum(first_vertex_);
    dual_.complex.vertex_count = first_vertex_.back();
    auto& offsets = dual_.vertex_site_offsets;
    offsets.assign(std::size_t{first_vertex_.back()} + 1, 0);
    base::for_chunks(parts_.size(), context_, "merge", 0.05, 0.1, [&](std::size_t i) {
      const SiteLists& vertices = parts_[i].vertices;
      std::vector<std::uint32_t>& number = number_[i];
      number.resize(vertices.count() + parts_[i].elsewhere.size());
      for (std::size_t v = 0; v < vertices.count(); ++v) {
        const std::uint32_t smallest = vertices.sites[vertices.offsets[v]];
        const bool same = v > 0 && vertices.sites[vertices.offsets[v - 1]] == smallest;
        number[v] = same ? number[v - 1] + 1 : first_vertex_[smallest];
        offsets[number[v] + 1] = vertices.offsets[v + 1] - vertices.offsets[v];
      }
    });
    prefix_sum(offsets);
    dual_.vertex_sites.resize(offsets.back());
    base::for_chunks(parts_.size(), context_, "merge", 0.1, 0.2, [&](std::size_t i) {
      SiteLists vertices = std::move(parts_[i].vertices);
      parts_[i].vertices = {};
      for (std::size_t v = 0; v < vertices.count(); ++v)
        std::copy(vertices.sites.begin() + vertices.offsets[v], vertices.sites.begin() + vertices.offsets[v + 1],
                  dual_.vertex_sites.begin() + offsets[number_[i][v]]);
    });
  }

  // Numbers of the vertices that a part knows by four of their sites. Four sites that span space have one sphere, so
  // one vertex.
  void resolve() {
    base::for_chunks(parts_.size(), context_, "merge", 0.2, 0.3, [&](std::size_t i) {
      std::size_t next = number_[i].size() - parts_[i].elsewhere.size();
      for (const auto& key : parts_[i].elsewhere) {
        std::uint32_t v = first_vertex_[key[0]];
        const auto has = [&](std::uint32_t site) {
          const auto sites = dual_.sites_of(v);
          return std::find(sites.begin(), sites.end(), site) != sites.end();
        };
        while (v < first_vertex_[key[0] + 1] && !(has(key[1]) && has(key[2]) && has(key[3]))) ++v;
        if (v == first_vertex_[key[0] + 1])
          throw Error(ErrorCode::invariant, "a brick refers to a vertex of the voxel core that no brick found");
        number_[i][next++] = v;
      }
      release(parts_[i].elsewhere);
    });
    release(first_vertex_);
  }

  void place_edges() {
    auto& edges = dual_.complex.edges;
    edge_begin_.assign(std::size_t{dual_.complex.vertex_count} + 1, 0);
    base::for_chunks(parts_.size(), context_, "merge", 0.3, 0.35, [&](std::size_t i) {
      for (auto& edge : parts_[i].edges) {
        for (std::uint32_t& v : edge) v = number_[i][v];
        if (edge[0] > edge[1]) std::swap(edge[0], edge[1]);
        std::atomic_ref<std::uint32_t>(edge_begin_[edge[0] + 1]).fetch_add(1, std::memory_order_relaxed);
      }
    });
    prefix_sum(edge_begin_);
    edges.resize(edge_begin_.back());
    {
      std::vector<std::uint32_t> next(edge_begin_.begin(), edge_begin_.end() - 1);
      base::for_chunks(parts_.size(), context_, "merge", 0.35, 0.4, [&](std::size_t i) {
        for (const auto& edge : parts_[i].edges)
          edges[std::atomic_ref<std::uint32_t>(next[edge[0]]).fetch_add(1, std::memory_order_relaxed)] = edge;
        release(parts_[i].edges);
      });
    }
    const std::size_t chunks = base::chunks_for(dual_.complex.vertex_count);
    base::for_chunks(chunks, context_, "merge", 0.4, 0.5, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(dual_.complex.vertex_count, chunk, chunks);
      for (std::size_t v = first; v < last; ++v) {
        const auto begin = edges.begin() + edge_begin_[v], end = edges.begin() + edge_begin_[v + 1];
        std::sort(begin, end);
        if (std::adjacent_find(begin, end) != end)
          throw Error(ErrorCode::invariant, "two bricks found the same edge of the voxel core");
      }
    });
  }

  // Faces are sorted by their sites; a part has all those of a smaller site, in order.
  void place_faces() {
    CellComplex& complex = dual_.complex;
    std::vector<std::uint32_t> first_face(site_count_ + 1, 0);
    base::for_chunks(parts_.size(), context_, "merge", 0.5, 0.55, [&](std::size_t i) {
      for (const auto& sites : parts_[i].face_sites) ++first_face[sites[0] + 1];
    });
    prefix_sum(first_face);
    dual_.face_sites.resize(first_face.back());
    complex.face_offsets.assign(std::size_t{first_face.back()} + 1, 0);
    const auto each_face = [&](std::size_t i, const auto& visit) {
      const auto& sites = parts_[i].face_sites;
      for (std::size_t f = 0, place = 0; f < sites.size(); ++f) {
        place = f > 0 && sites[f - 1][0] == sites[f][0] ? place + 1 : first_face[sites[f][0]];
        visit(f, place);
      }
    };
    base::for_chunks(parts_.size(), context_, "merge", 0.55, 0.6, [&](std::size_t i) {
      const BrickPart& part = parts_[i];
      each_face(i, [&](std::size_t f, std::size_t place) {
        dual_.face_sites[place] = part.face_sites[f];
        complex.face_offsets[place + 1] = part.face_offsets[f + 1] - part.face_offsets[f];
      });
    });
    prefix_sum(complex.face_offsets);
    complex.face_vertices.resize(complex.face_offsets.back());
    base::for_chunks(parts_.size(), context_, "merge", 0.6, 0.7, [&](std::size_t i) {
      BrickPart& part = parts_[i];
      each_face(i, [&](std::size_t f, std::size_t place) {
        std::uint32_t corner = complex.face_offsets[place];
        for (std::uint32_t c = part.face_offsets[f]; c < part.face_offsets[f + 1]; ++c)
          complex.face_vertices[corner++] = number_[i][part.face_corners[c]];
      });
      part = {};
      release(number_[i]);
    });
    parts_.clear();
  }

  void find_sides() {
    CellComplex& complex = dual_.complex;
    complex.face_edges.resize(complex.face_vertices.size());
    const std::size_t chunks = base::chunks_for(complex.face_count());
    base::for_chunks(chunks, context_, "merge", 0.7, 1, [&](std::size_t chunk) {
      const auto [first, last] = base::part_of(complex.face_count(), chunk, chunks);
      for (std::size_t f = first; f < last; ++f) {
        const auto corners = complex.corners(f);
        for (std::size_t i = 0; i < corners.size(); ++i)
          complex.face_edges[complex.face_offsets[f] + i] =
              lattice::edge_between(complex, edge_begin_, corners[i], corners[i + 1 == corners.size() ? 0 : i + 1]);
      }
    });
  }

  std::vector<BrickPart> parts_;
  std::size_t site_count_;
  Context* context_;
  lattice::DualComplex dual_;
  std::vector<std::vector<std::uint32_t>> number_;  // per part: final numbers of its vertices
  std::vector<std::uint32_t> first_vertex_;         // per site: the first vertex whose smallest site it is
  std::vector<std::uint32_t> edge_begin_;           // per vertex: the first edge whose smaller end it is
};

}  // namespace

lattice::DualComplex assemble(std::vector<BrickPart> parts, std::size_t site_count, Context* context) {
  base::return_free_memory();
  lattice::DualComplex dual = Assembly(std::move(parts), site_count, context).run();
  base::return_free_memory();
  return dual;
}

}  // namespace quench::bricks
