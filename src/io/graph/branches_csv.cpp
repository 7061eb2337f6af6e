// SPDX-License-Identifier: Apache-2.0
#include "io/common/text_out.h"
#include "quench/graph.h"
#include "quench/io.h"

/// The branches of a curve graph as a table.
namespace quench::io {

void write_branches(const std::filesystem::path& file, const CurveGraph& graph) {
  write_atomically(file, [&](std::ostream& out) {
    TextOut text(out);
    text.print(
        "branch,from,to,component,from_x,from_y,from_z,to_x,to_y,to_z,from_kind,to_kind,length,mean_radius,min_radius,"
        "max_radius,thickness,tortuosity\n");
    for (std::size_t b = 0; b < graph.branches.size(); ++b) {
      const CurveGraph::Branch& branch = graph.branches[b];
      const CurveGraph::Node &from = graph.nodes[branch.from], &to = graph.nodes[branch.to];
      text.print("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", b, branch.from, branch.to, branch.component,
                 from.point[0], from.point[1], from.point[2], to.point[0], to.point[1], to.point[2], name_of(from.kind),
                 name_of(to.kind), branch.length, branch.mean_radius, branch.min_radius, branch.max_radius,
                 branch.thickness, branch.tortuosity);
    }
    text.flush();
  });
}

}  // namespace quench::io
