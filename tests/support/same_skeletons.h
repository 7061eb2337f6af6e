// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "quench/skeleton.h"

/// All that families and skeletons consist of is the same, to the bit.
namespace quench::testing_skeletons {

inline void expect_same(const CellComplex& a, const CellComplex& b) {
  EXPECT_EQ(a.vertex_count, b.vertex_count);
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.face_offsets, b.face_offsets);
  EXPECT_EQ(a.face_vertices, b.face_vertices);
  EXPECT_EQ(a.face_edges, b.face_edges);
}

inline void expect_same(const Skeleton& a, const Skeleton& b) {
  expect_same(a.complex, b.complex);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.radius, b.radius);
  EXPECT_EQ(a.burn_time, b.burn_time);
  EXPECT_EQ(a.curve_burn_time, b.curve_burn_time);
  EXPECT_EQ(a.on_curve, b.on_curve);
  EXPECT_EQ(a.face_thickness, b.face_thickness);
  EXPECT_EQ(a.face_level, b.face_level);
  EXPECT_EQ(a.face_sheet, b.face_sheet);
  EXPECT_EQ(a.edge_branch, b.edge_branch);
  EXPECT_EQ(a.theta1_radii, b.theta1_radii);
  EXPECT_EQ(a.rims_above, b.rims_above);
  EXPECT_EQ(a.full_tips, b.full_tips);
  EXPECT_EQ(a.smooth, b.smooth);
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  EXPECT_TRUE(std::ranges::equal(a.edge_thickness, b.edge_thickness, same));
  EXPECT_TRUE(std::ranges::equal(a.edge_level, b.edge_level, same));
}

inline void expect_same(const SkeletonFamily& a, const SkeletonFamily& b) {
  expect_same(a.refined.complex, b.refined.complex);
  EXPECT_EQ(a.refined.points, b.refined.points);
  EXPECT_EQ(a.refined.radius, b.refined.radius);
  EXPECT_EQ(a.refined.burn_time, b.refined.burn_time);
  EXPECT_EQ(a.refined.curve_vertex, b.refined.curve_vertex);
  EXPECT_EQ(a.refined.curve_edge, b.refined.curve_edge);
  EXPECT_EQ(a.refined.face_thickness, b.refined.face_thickness);
  EXPECT_EQ(a.refined.polygon_of, b.refined.polygon_of);
  EXPECT_EQ(a.refined.curve_burn_time, b.refined.curve_burn_time);
  EXPECT_EQ(a.refined.exit, b.refined.exit);
  EXPECT_EQ(a.refined.medial_point, b.refined.medial_point);
  EXPECT_EQ(a.refined.radius_rule, b.refined.radius_rule);
  EXPECT_EQ(a.refined.incomplete, b.refined.incomplete);
  EXPECT_EQ(a.theta2_floor, b.theta2_floor);
  EXPECT_EQ(a.theta1_floor, b.theta1_floor);
  EXPECT_EQ(a.corner_sheet_level, b.corner_sheet_level);
  EXPECT_EQ(a.face_sheet_level, b.face_sheet_level);
  EXPECT_EQ(a.edge_sheet_level, b.edge_sheet_level);
  EXPECT_EQ(a.vertex_sheet_level, b.vertex_sheet_level);
  EXPECT_EQ(a.curve_thickness, b.curve_thickness);
  EXPECT_EQ(a.curve_level, b.curve_level);
}

}  // namespace quench::testing_skeletons
