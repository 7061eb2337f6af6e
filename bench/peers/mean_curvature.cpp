// SPDX-License-Identifier: Apache-2.0
// The skeleton of a closed triangle mesh by CGAL's mean curvature flow (Tagliasacchi et al. 2012), default parameters.
//   mean_curvature MESH OUT
// OUT: a line per vertex, "v x y z", and one per edge, "e i j". What CGAL does not take (a mesh it cannot read, or one that
// is not closed, or has several components) is said on stderr, exit status 1.
#include <CGAL/Polygon_mesh_processing/IO/polygon_mesh_io.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/extract_mean_curvature_flow_skeleton.h>

#include <fstream>
#include <iostream>

int main(int argc, char** argv) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  using Skeletonization = CGAL::Mean_curvature_flow_skeletonization<Mesh>;
  if (argc != 3) {
    std::cerr << "usage: mean_curvature MESH OUT\n";
    return 1;
  }
  Mesh mesh;
  if (!CGAL::Polygon_mesh_processing::IO::read_polygon_mesh(argv[1], mesh) || !CGAL::is_triangle_mesh(mesh)) {
    std::cerr << argv[1] << ": not a manifold triangle mesh\n";
    return 1;
  }
  auto components = mesh.add_property_map<Mesh::Face_index, std::size_t>("f:component", 0).first;
  if (!CGAL::is_closed(mesh) || CGAL::Polygon_mesh_processing::connected_components(mesh, components) != 1) {
    std::cerr << argv[1] << ": not closed, or several components\n";
    return 1;
  }
  Skeletonization::Skeleton skeleton;
  CGAL::extract_mean_curvature_flow_skeleton(mesh, skeleton);
  std::ofstream out(argv[2]);
  out.precision(12);
  for (auto v : CGAL::make_range(vertices(skeleton))) out << "v " << skeleton[v].point << '\n';
  for (auto e : CGAL::make_range(edges(skeleton)))
    out << "e " << source(e, skeleton) << ' ' << target(e, skeleton) << '\n';
  return out ? 0 : 1;
}
