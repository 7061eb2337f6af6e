// SPDX-License-Identifier: Apache-2.0
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "base/platform/child_process.h"
#include "io/common/formats.h"
#include "io/mesh/weld.h"

/// Meshes in the formats of other programs, through Assimp. It stores coordinates in single precision, and a vertex
/// once for each of its normals or texture coordinates: only positions are taken, and equal ones become one vertex.
namespace quench::io {
namespace {

/// Adds a mesh, transformed as a node of the scene says.
void add_mesh(const aiMesh& mesh, const aiMatrix4x4& place, const std::string& file, Weld& weld, Record& data) {
  std::vector<std::uint32_t> vertex(mesh.mNumVertices);
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D p = place * mesh.mVertices[v];
    const Vec3 point(p.x, p.y, p.z);
    if (!point.allFinite())
      throw Error(ErrorCode::input, fmt::format("'{}': a coordinate of vertex {} is not finite", file, v));
    vertex[v] = weld(point, data.points);
  }
  // A reflection turns faces inside out unless their corners are reversed.
  const bool mirrored = aiMatrix3x3(place).Determinant() < 0;
  std::vector<std::uint32_t> corners;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    corners.clear();
    for (unsigned c = 0; c < face.mNumIndices; ++c) {
      if (face.mIndices[c] >= mesh.mNumVertices)
        throw Error(ErrorCode::input, fmt::format("'{}': face {} refers to a vertex that is not there", file, f));
      corners.push_back(vertex[face.mIndices[c]]);
    }
    if (mirrored) std::reverse(corners.begin(), corners.end());
    if (!corners.empty()) add_cell(data, corners, file);
  }
}

/// What Assimp says, as a part of a sentence.
std::string reason_of(const Assimp::Importer& importer) {
  std::string text;
  for (const char c : std::string_view(importer.GetErrorString()).substr(0, 240))
    text += c >= ' ' && c <= '~' ? c : ' ';
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text.empty() ? "no reason given" : text;
}

Record read_scene(const std::string& file) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file, 0);
  if (!scene || !scene->mRootNode)
    throw Error(ErrorCode::input,
                fmt::format("cannot read '{}': {}; it is damaged or of another format", file, reason_of(importer)));

  Record data;
  Weld weld;
  std::vector<std::pair<const aiNode*, aiMatrix4x4>> open{{scene->mRootNode, scene->mRootNode->mTransformation}};
  while (!open.empty()) {
    const auto [node, place] = open.back();
    open.pop_back();
    for (unsigned m = 0; m < node->mNumMeshes; ++m)
      if (node->mMeshes[m] < scene->mNumMeshes) add_mesh(*scene->mMeshes[node->mMeshes[m]], place, file, weld, data);
    for (unsigned c = node->mNumChildren; c > 0; --c)
      open.emplace_back(node->mChildren[c - 1], place * node->mChildren[c - 1]->mTransformation);
  }
  if (data.points.empty())
    throw Error(ErrorCode::input, fmt::format("'{}' has no mesh; export it again with faces", file));
  return data;
}

// A mesh as bytes, from the child process to its parent: every vector as its size and its memory.
template <class Data, class Vector>
void vectors(Data& data, const Vector& vector) {
  vector(data.points);
  vector(data.verts);
  vector(data.lines);
  vector(data.poly_offsets);
  vector(data.poly_corners);
}

std::string packed(const Record& data) {
  std::string bytes;
  const auto put = [&](const void* from, std::size_t size) { bytes.append(static_cast<const char*>(from), size); };
  vectors(data, [&](const auto& values) {
    const std::size_t count = values.size();
    put(&count, sizeof count);
    put(values.data(), count * sizeof values[0]);
  });
  return bytes;
}

Record unpacked(std::string_view bytes) {
  Record data;
  const auto take = [&](void* to, std::size_t size) {
    if (size > bytes.size()) throw Error(ErrorCode::failed, "a mesh was lost between two processes");
    if (size > 0) std::memcpy(to, bytes.data(), size);
    bytes.remove_prefix(size);
  };
  vectors(data, [&](auto& values) {
    std::size_t count = 0;
    take(&count, sizeof count);
    if (count > bytes.size() / sizeof values[0])
      throw Error(ErrorCode::failed, "a mesh was lost between two processes");
    values.resize(count);
    take(values.data(), count * sizeof values[0]);
  });
  return data;
}

}  // namespace

Record read_with_assimp(const std::filesystem::path& path) {
  const std::string file = path.string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw Error(ErrorCode::failed,
                fmt::format("cannot open '{}': {}", file, error ? error.message() : std::string("it is not a file")));
  // On a damaged file Assimp may crash or read endlessly.
  return unpacked(base::read_in_child_process(path, [&] { return packed(read_scene(file)); }));
}

}  // namespace quench::io
