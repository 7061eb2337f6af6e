// SPDX-License-Identifier: Apache-2.0
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <utility>
#include <vector>

#include "formats.h"
#include "weld.h"

/// Meshes in the formats of other programs, through Assimp. It stores coordinates in single precision, and corners as
/// often as normals or texture need: only positions are taken, and equal ones become one vertex.
namespace quench::io {
namespace {

/// Adds a mesh in the place where a node of the scene puts it.
void add_mesh(const aiMesh& mesh, const aiMatrix4x4& place, const std::string& file, Weld& weld, PolyData& data) {
  std::vector<std::uint32_t> vertex(mesh.mNumVertices);
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D p = place * mesh.mVertices[v];
    const Vec3 point(p.x, p.y, p.z);
    if (!point.allFinite())
      throw Error(ErrorCode::input, fmt::format("'{}': a coordinate of vertex {} is not finite", file, v));
    vertex[v] = weld(point, data.points);
  }
  // A place that mirrors turns the faces inside out unless their corners are reversed.
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

}  // namespace

PolyData read_with_assimp(const std::filesystem::path& path) {
  const std::string file = path.string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw Error(ErrorCode::failed,
                fmt::format("cannot open '{}': {}", file, error ? error.message() : std::string("it is no file")));
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file, 0);
  if (!scene || !scene->mRootNode)
    throw Error(ErrorCode::input, fmt::format("cannot read '{}': {}", file, importer.GetErrorString()));

  PolyData data;
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
  if (data.points.empty()) throw Error(ErrorCode::input, fmt::format("'{}' has no mesh", file));
  return data;
}

}  // namespace quench::io
