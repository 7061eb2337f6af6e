// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "small_files.h"

namespace quench::small_files {

/// Tiny files of polygons, as all() has them of other formats: `format` is geojson, wkt or svg.
inline std::vector<SmallFile> polygons() {
  return {
      {"collection.geojson", "geojson",
       R"({"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"EPSG:4326"}},"features":[)"
       R"({"type":"Feature","id":7,"properties":{"a":[1,{"b":null}],"c":"\u00e9"},"geometry":{"type":"Polygon",)"
       R"("coordinates":[[[0,0,5],[4,0],[4,4],[0,0,5]],[[1,0.5],[2,5e-1],[2,1]]]}},{"type":"Feature","geometry":null}]})"},
      {"multi.geojson", "geojson",
       R"({"coordinates":[[[[0,0],[1,0],[0,1]]],[[[2,2],[3,2],[2,3]]]],"type":"MultiPolygon"})"},
      {"members.geojson", "geojson",
       R"({"type":"GeometryCollection","geometries":[{"type":"Point","coordinates":[1,2]},)"
       R"({"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1]]]}]})"},
      {"hand.wkt", "wkt",
       "SRID=4326;POLYGON((0 0,4 0,4 4,0 0),(1 .5,2 0.5e0,2 1))\nMULTIPOLYGON Z(((0 0 5,1 0 5,0 1 5)),EMPTY);\n"
       "POINT(1 2)\nGEOMETRYCOLLECTION(POLYGON EMPTY,POLYGONM((0 0 1,1 0 1,1 1 1)))\n"},
      {"path.svg", "svg",
       "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 9 9'><path d='M0 0h9v9H0z'/><g transform='rotate(9 1 1)'>"
       "<path fill-rule='evenodd' d='m1 1l2 0.5.5C1 2 3 4 5 6s1-1 0 0Q1 2 3 4t1 1a2 3 30 016 5zM2-2 3 4'/></g></svg>"},
      {"shapes.svg", "svg",
       "<svg width='90mm' height='9'><rect x='1' y='1' width='2px' height='3' rx='1'/><circle r='4'/><ellipse rx='4' "
       "ry='2'/><svg x='2' width='5' height='5' viewBox='0 0 2 3'><polygon points='0,0 4,0 4,4' "
       "style='fill:red'/></svg>"
       "<polyline transform='skewX(5)scale(2)matrix(1,0,0,1,5,5)' points='1 2 3 4 5 5'/><use/></svg>"},
  };
}

}  // namespace quench::small_files
