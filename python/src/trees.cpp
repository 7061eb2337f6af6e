// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <variant>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/tree.h"
#include "values.h"

namespace quench::python {
namespace {

using TreePointer = std::shared_ptr<TreeValue>;

/// The options of a tree, with lengths that are resolved when their scale is known.
struct TreeHow {
  pipeline::TreeOptions options;
  bool new_axes = false;  ///< of a tree from a file: its axes are found anew
  std::optional<pipeline::Length> reach, sholl_step;

  pipeline::TreeOptions resolved(const pipeline::Scale& scale) const {
    pipeline::TreeOptions result = options;
    if (reach) result.repair.reach = scale.resolve(*reach, "reach");
    if (sholl_step) result.traits.sholl_step = scale.resolve(*sholl_step, "sholl_step");
    return result;
  }
};

template <class Parse>
auto choice(const std::string& name, const std::string& field, const Parse& parse, const char* names) {
  const auto value = parse(name);
  if (!value) throw Error(ErrorCode::usage, field + " '" + name + "' is not one of " + names, field);
  return *value;
}

TreeHow tree_how(const std::string& kind, const std::string& repair, const std::vector<std::array<double, 3>>& roots,
                 const std::optional<std::uint32_t>& plants, const std::string& reach,
                 const std::optional<std::string>& axes, const std::optional<std::string>& soma,
                 const std::optional<std::array<double, 3>>& down, const std::string& sholl_step) {
  TreeHow how;
  how.options =
      pipeline::defaults_of(choice(kind, "kind", pipeline::tree_kind_of, "'root', 'neuron', 'vessel', 'airway'"));
  how.options.repair.rule = choice(repair, "repair", repair_rule_of, "'off', 'loops', 'gaps', 'all'");
  for (const auto& p : roots) how.options.repair.roots.emplace_back(p[0], p[1], p[2]);
  how.options.hierarchy.roots = how.options.repair.roots;
  if (plants) how.options.repair.plants = *plants;
  if (axes)
    how.options.hierarchy.rule =
        choice(*axes, "axes", axis_rule_of, "'depth', 'length', 'radius', 'strahler', 'continuation'");
  if (soma) how.options.hierarchy.soma = choice(*soma, "soma", soma_rule_of, "'auto', 'none', 'thickest'");
  if (down) {
    how.options.hierarchy.down = Vec3((*down)[0], (*down)[1], (*down)[2]).normalized();
    how.options.find_down = false;
  }
  how.new_axes = axes || soma || !roots.empty();
  how.reach = pipeline::parse_length_or_auto(reach, "reach");
  how.sholl_step = pipeline::parse_length_or_auto(sholl_step, "sholl_step");
  return how;
}

TreePointer made(pipeline::TreeRun&& run, std::shared_ptr<Axis> axis, const TreeHow& how) {
  return std::make_shared<TreeValue>(
      TreeValue{std::move(run), std::move(axis), how.options.kind == pipeline::TreeKind::root});
}

TreePointer tree_of_axis(const std::shared_ptr<Axis>& axis, const TreeHow& how, const std::string& theta1,
                         const py::object& listener, int threads) {
  const auto known = axis->fire;
  const auto fire = run(listener, threads,
                        [&](Context& c) { return compute_fire(*axis, FireOptions::of(known), true, known, c); });
  axis->fire = fire;
  return run(listener, threads, [&](Context& c) {
    const pipeline::SkeletonOptions skeleton = pipeline::skeleton_for_trees({.theta1 = pipeline::parse_theta1(theta1)});
    const auto curves = compute_skeleton(
        axis, *fire, {pipeline::text_of(skeleton.theta2), pipeline::text_of(skeleton.theta1), true}, c);
    const pipeline::GraphOptions graph = pipeline::graph_for_trees(graph_options(*axis), axis->scale());
    const pipeline::TreeCurves of{pipeline::measured_graph(curves->member, graph, axis->scale()), axis->scale(),
                                  graph.voxel, axis->core.coordinates};
    return made(pipeline::run_tree(of, how.resolved(of.scale), axis->shape.get(), &c), axis, how);
  });
}

TreePointer tree_of_result(const std::string& file, const TreeHow& how, const std::string& theta1,
                           const py::object& listener, int threads) {
  return run(listener, threads, [&](Context& c) {
    pipeline::RunOptions options;
    options.skeleton.theta1 = pipeline::parse_theta1(theta1);
    const pipeline::TreeCurves of =
        pipeline::curves_in(pipeline::read_surface(file, &c), file, std::move(options), nullptr, &c);
    return made(pipeline::run_tree(of, how.resolved(of.scale), nullptr, &c), nullptr, how);
  });
}

TreePointer read_tree(const std::string& file, const TreeHow& how, const py::object& listener, int threads) {
  return run(listener, threads, [&](Context& c) {
    bool axes_known = false;
    Tree tree = io::read_tree(file, &axes_known, &c);
    std::vector<Vec3> points;
    for (const Tree::Branch& b : tree.branches) points.insert(points.end(), b.points.begin(), b.points.end());
    const pipeline::Scale scale{.longest_side = longest_side_of(points)};
    return made(pipeline::run_tree(std::move(tree), how.new_axes || !axes_known, how.resolved(scale)), nullptr, how);
  });
}

}  // namespace

py::list columns_of(const Table& table) {
  py::list result;
  for (const Table::Column& column : table.columns) {
    py::object values = std::visit(
        [](const auto& v) -> py::object {
          if constexpr (std::is_same_v<typename std::decay_t<decltype(v)>::value_type, std::string>)
            return py::cast(v);
          else
            return py::cast(own(v));
        },
        column.values);
    result.append(py::make_tuple(column.name, column.unit, column.meaning, values));
  }
  return result;
}

namespace {

Table table_named(const TreeValue& t, const std::string& name) {
  const Traits& traits = t.run.traits;
  if (name == "axes") return traits.axes;
  if (name == "branches") return traits.branches;
  if (name == "sample") return traits.sample;
  if (name == "sholl") return traits.sholl;
  if (name == "depths") return traits.depths;
  if (name == "toporoot") return toporoot_table(t.run.tree, traits);
  return pipeline::table_of(t.run.edits, t.run.tree.coordinates);
}

py::list tree_branches(const TreePointer& t) {
  py::list result;
  for (const Tree::Branch& b : t->run.tree.branches)
    result.append(py::make_tuple(view(t, b.points), view(t, b.radius), static_cast<std::int64_t>(b.parent), b.axis,
                                 b.plant, b.strahler, b.order, b.type, view(t, b.bridged)));
  return result;
}

py::list tree_axes(const TreePointer& t) {
  py::list result;
  for (const Tree::Axis& a : t->run.tree.axes)
    result.append(py::make_tuple(view(t, a.points), view(t, a.radius), static_cast<std::int64_t>(a.parent), a.level,
                                 a.plant, view(t, a.branches), view(t, a.children), a.position, a.stem, a.label));
  return result;
}

py::list tree_plants(const TreePointer& t) {
  py::list result;
  for (const Tree::Plant& p : t->run.tree.plants)
    result.append(py::make_tuple(std::array{p.root[0], p.root[1], p.root[2]}, p.main_axis, p.soma, p.label));
  return result;
}

std::string ending_of(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  for (char& c : ending) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return ending;
}

void write_page_of(const TreeValue& t, const std::string& file, const PictureSize& size, Context& context) {
  const bool picture = ending_of(file) == ".png";
  if (!picture) pipeline::require_page_program();
  pipeline::PageBuilder builder;
  builder.page.title = pipeline::title_of(file);
  std::vector<Vec3> points;
  for (const Tree::Branch& b : t.run.tree.branches) points.insert(points.end(), b.points.begin(), b.points.end());
  Vec3 low = points[0], high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  builder.set_origin(low, high);
  if (t.axis && t.axis->shape) builder.add_shape(*t.axis->shape);
  builder.add_tree(t.run.tree, t.run.traits, t.run.edits, t.upright);
  if (picture)
    write_png(file, draw_page(builder.page, options_of(size), &context), &context);
  else
    builder.write(file);
}

/// False: there is no such format.
bool save(const TreeValue& t, const std::string& file, const std::string& type, bool toporoot, const PictureSize& size,
          Context& context) {
  const Tree& tree = t.run.tree;
  const std::string ending = ending_of(file);
  if (ending == ".swc")
    io::write_swc(file, tree, io::swc_type_of(type, "swc_type"));
  else if (ending == ".rsml")
    io::write_rsml(file, tree, &t.run.traits.axes);
  else if (ending == ".mtg")
    io::write_mtg(file, tree);
  else if (ending == ".vtp")
    io::write_centerlines(file, tree);
  else if (ending == ".graphml")
    io::write_graphml(file, tree);
  else if (ending == ".csv")
    io::write_table(file, toporoot ? toporoot_table(tree, t.run.traits) : t.run.traits.axes);
  else if (ending == ".html" || ending == ".png")
    write_page_of(t, file, size, context);
  else
    return false;
  return true;
}

}  // namespace

void bind_trees(py::module_& m) {
  py::class_<TreeHow>(m, "TreeHow")
      .def(py::init(&tree_how), py::kw_only(), py::arg("kind"), py::arg("repair"), py::arg("roots"), py::arg("plants"),
           py::arg("reach"), py::arg("axes"), py::arg("soma"), py::arg("down"), py::arg("sholl_step"));
  py::class_<TreeValue, TreePointer>(m, "Tree")
      .def("branches", &tree_branches)
      .def("axes", &tree_axes)
      .def("plants", &tree_plants)
      .def("table", [](const TreePointer& t, const std::string& name) { return columns_of(table_named(*t, name)); })
      .def_property_readonly("units", [](const TreePointer& t) { return t->run.tree.coordinates.units; })
      .def_property_readonly("down",
                             [](const TreePointer& t) {
                               const Vec3& d = t->run.tree.down;
                               return std::array{d[0], d[1], d[2]};
                             })
      .def_property_readonly("rule", [](const TreePointer& t) { return name_of(t->run.tree.rule); })
      .def_property_readonly("components_before", [](const TreePointer& t) { return t->run.components_before; })
      .def_property_readonly("loops_before", [](const TreePointer& t) { return t->run.loops_before; })
      .def("edited",
           [](const TreePointer& t) -> py::object {
             if (!t->run.edited) return py::none();
             return py::cast(image_of(*t->run.edited, t->run.tree.coordinates));
           })
      .def("save", [](const TreePointer& t, const std::string& file, const std::string& type, bool toporoot,
                      const PictureSize& size, const py::object& listener, int threads) {
        return run(listener, threads, [&](Context& c) { return save(*t, file, type, toporoot, size, c); });
      });
  m.def("tree_of_axis", &tree_of_axis);
  m.def("tree_of_result", &tree_of_result);
  m.def("read_tree", &read_tree);
  m.def("is_tree_file", [](const std::string& file) { return io::is_tree_file(file); });
}

}  // namespace quench::python
