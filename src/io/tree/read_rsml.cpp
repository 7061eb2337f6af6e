// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/text.h"
#include "io/common/words.h"
#include "io/tree/rsml_course.h"
#include "io/tree/tree_samples.h"
#include "quench/error.h"

/// RSML: https://rootsystemml.github.io/. Where a lateral grows from is the place of its parent nearest to its first
/// point: parent-node counts from 0 in some programs, from 1 in others, and is the ID of the parent in more.
namespace quench::io {
namespace {

/// A root element with a polyline of two points or more.
struct Root {
  pugi::xml_node node;
  std::uint32_t parent = kNone;  ///< a root
  std::uint32_t plant = 0;
  std::vector<Vec3> points;    ///< of the file
  std::vector<double> radius;  ///< per point
  std::vector<char> bridged;   ///< per point, or empty: the segment before it
  int type = 0;
  RsmlPlace base;                 ///< on the parent
  std::vector<RsmlPlace> places;  ///< of the points of its course on those of the file: those, and where laterals begin
  std::vector<std::uint32_t> samples;  ///< per place
  double link = 0;                     ///< length of the segment to the place it grows from
  std::uint32_t axis = kNone;
  std::uint32_t first = 0;  ///< sample of its own
};

class RsmlReader {
 public:
  RsmlReader(const FileText& file, Context* context) : file_(file), context_(context) {}

  Tree read() {
    load();
    read_metadata();
    find_roots();
    place_laterals();
    make_samples();
    std::vector<std::uint32_t> plant_of_root;
    Tree tree = tree_of_samples(samples_, &plant_of_root);
    if (tree.branches.empty()) fail("there is no root of two points or more");
    for (std::size_t p = 0, root = 0; p < plants_.size(); ++p) {
      if (main_root_[p] == kNone) continue;
      const std::uint32_t plant = plant_of_root[root++];
      plants_[p].number = plant;
      if (plant == kNone) continue;
      tree.plants[plant].label = rsml_attribute(plants_[p].node, "label").value();
      tree.plants[plant].foreign = without_roots(plants_[p].node);
    }
    make_axes(tree);
    number_branches(tree);
    tree.coordinates.units = unit_;
    if (!has_z_) {
      tree.coordinates.y_down = true;
      tree.down = Vec3::UnitY();
    }
    tree.foreign = without_plants();
    say_links();
    say_left_out();
    return tree;
  }

 private:
  struct Plant {
    pugi::xml_node node;
    std::uint32_t number = kNone;  ///< in the tree
  };

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::input, fmt::format("'{}': {}", file_.name, base::plain(what)));
  }

  void load() {
    checkpoint(context_, "read", 0);
    const pugi::xml_parse_result parsed =
        xml_.load_buffer(file_.bytes.data(), file_.bytes.size(), pugi::parse_default, pugi::encoding_auto);
    if (!parsed)
      fail(fmt::format("the XML is incomplete or damaged at byte {}: {}", parsed.offset, parsed.description()));
    struct Depth : pugi::xml_tree_walker {
      int deepest = 0;
      bool for_each(pugi::xml_node&) override {
        deepest = std::max(deepest, depth());
        return deepest <= kRsmlDeepest;
      }
    } walker;
    xml_.traverse(walker);
    if (walker.deepest > kRsmlDeepest) fail(fmt::format("its elements are nested more than {} deep", kRsmlDeepest));
    if (!rsml_is(xml_.document_element(), "rsml")) fail("this is not an RSML file");
  }

  void read_metadata() {
    const pugi::xml_node metadata = rsml_child(xml_.document_element(), "metadata");
    unit_ = rsml_value_of(rsml_child(metadata, "unit"));
    const std::string text = rsml_value_of(rsml_child(metadata, kRsmlResolution));
    if (text.empty()) return;
    if (double value = 0;
        parse_number(text, value) && value > 0 && value <= kLargestLength && 1 / value <= kLargestLength)
      resolution_ = value;
    else
      note(context_, fmt::format("'{}' has the resolution '{}', which is not a positive number; taken as 1", file_.name,
                                 base::plain(text.substr(0, 40))));
  }

  /// In the order of the file: parents first.
  void find_roots() {
    struct Visit {
      pugi::xml_node node;
      std::uint32_t parent;
    };
    std::vector<Visit> open;
    const auto visit_roots = [&](const pugi::xml_node& node, std::uint32_t parent) {
      const std::size_t bottom = open.size();
      for (const pugi::xml_node& child : node.children())
        if (rsml_is(child, "root")) open.push_back({child, parent});
      std::reverse(open.begin() + static_cast<std::ptrdiff_t>(bottom), open.end());
    };
    for (const pugi::xml_node& scene : xml_.document_element().children()) {
      if (!rsml_is(scene, "scene")) continue;
      for (const pugi::xml_node& plant : scene.children()) {
        if (!rsml_is(plant, "plant")) continue;
        plants_.push_back({plant});
        visit_roots(plant, kNone);
        while (!open.empty()) {
          const Visit visit = open.back();
          open.pop_back();
          Root root;
          root.node = visit.node;
          root.parent = visit.parent;
          root.plant = static_cast<std::uint32_t>(plants_.size() - 1);
          read_points(root);
          const bool kept = root.points.size() > 1;
          if (kept) {
            read_radii(root);
            roots_.push_back(std::move(root));
          } else {
            ++left_out_;
          }
          visit_roots(visit.node, kept ? static_cast<std::uint32_t>(roots_.size() - 1) : visit.parent);
        }
      }
    }
  }

  void read_points(Root& root) {
    const pugi::xml_node polyline = rsml_child(rsml_child(root.node, "geometry"), "polyline");
    for (const pugi::xml_node& node : polyline.children()) {
      if (!rsml_is(node, "point")) continue;
      Vec3 point = Vec3::Zero();
      for (int a = 0; a < 3; ++a) {
        const char* name = a == 0 ? "x" : a == 1 ? "y" : "z";
        const pugi::xml_attribute value = rsml_attribute(node, name);
        if (a == 2 && !value) continue;
        has_z_ |= a == 2;
        if (!parse_number(value.value(), point[a])) wrong_point(root, fmt::format("{} is not a number", name));
      }
      point /= resolution_;
      if (!point.allFinite() || point.cwiseAbs().maxCoeff() > kLargestLength)
        wrong_point(root, "is not finite, or too far away");
      root.points.push_back(point);
    }
  }

  [[noreturn]] void wrong_point(const Root& root, const std::string& what) const {
    const std::string id = rsml_attribute(root.node, "id").value();
    fail(fmt::format("point {} of root '{}' {}", root.points.size() + 1, base::plain(id.substr(0, 60)), what));
  }

  void read_radii(Root& root) const {
    for (const RsmlFunction& function : rsml_functions_of(root.node)) {
      const bool diameter = function.name == "diameter";
      if (!diameter && function.name != "radius" && function.name != kRsmlBridged) continue;
      const std::vector<double> values = rsml_at_points(function, root.points);
      if (values.empty()) continue;
      if (function.name == kRsmlBridged)
        for (const double value : values) root.bridged.push_back(value != 0);
      else
        root.radius = radii(values, diameter ? 2 : 1);
    }
    const pugi::xml_node properties = rsml_child(root.node, "properties");
    if (double type = 0; parse_number(rsml_value_of(rsml_child(properties, kRsmlSwcType)), type) && type >= 0)
      root.type = static_cast<int>(std::min(type, 255.0));
    for (const double part : {2., 1.}) {  // one for the whole root
      double value = 0;
      if (root.radius.empty() &&
          parse_number(rsml_value_of(rsml_child(properties, part == 2 ? "diameter" : "radius")), value))
        root.radius = radii(std::vector<double>(root.points.size(), value), part);
    }
    root.radius.resize(root.points.size(), 0);
  }

  std::vector<double> radii(std::vector<double> values, double parts) const {
    for (double& value : values) {
      value /= parts * resolution_;
      if (!(value >= 0 && value <= kLargestLength)) value = 0;
    }
    return values;
  }

  /// Of roots without a parent the longest of each plant is its main one; the others grow from its first point.
  void place_laterals() {
    main_root_.assign(plants_.size(), kNone);
    std::vector<double> longest(plants_.size(), -1);
    for (std::uint32_t r = 0; r < roots_.size(); ++r) {
      const Root& root = roots_[r];
      double length = 0;
      for (std::size_t i = 1; i < root.points.size(); ++i) length += (root.points[i] - root.points[i - 1]).norm();
      if (root.parent != kNone || !(length > longest[root.plant])) continue;
      longest[root.plant] = length;
      main_root_[root.plant] = r;
    }
    std::vector<std::vector<RsmlPlace>> added(roots_.size());
    for (std::size_t r = 0; r < roots_.size(); ++r) {
      Root& root = roots_[r];
      if (r % 256 == 0) checkpoint(context_, "read", static_cast<double>(r) / static_cast<double>(roots_.size()));
      if (root.parent == kNone) continue;
      root.base = rsml_nearest_place(roots_[root.parent].points, root.points[0]);
      if (root.base.part > 0) added[root.parent].push_back(root.base);
    }
    for (std::size_t r = 0; r < roots_.size(); ++r) {
      std::vector<RsmlPlace>& places = roots_[r].places;
      places = std::move(added[r]);
      for (std::uint32_t i = 0; i < roots_[r].points.size(); ++i) places.push_back({i, 0});
      std::ranges::sort(places);
      places.erase(std::unique(places.begin(), places.end()), places.end());
    }
  }

  void make_samples() {
    std::vector<std::uint32_t> root_sample(plants_.size(), kNone);
    for (std::uint32_t r = 0; r < roots_.size(); ++r) {
      Root& root = roots_[r];
      std::uint32_t base = kNone;
      if (root.parent == kNone) {
        const std::uint32_t main = main_root_[root.plant];
        std::uint32_t& shared = root_sample[root.plant];
        if (shared == kNone) {
          shared = static_cast<std::uint32_t>(samples_.size());
          const Root& longest = roots_[main];
          samples_.push_back({.point = longest.points[0], .radius = longest.radius[0], .type = longest.type});
        }
        base = shared;
      } else {
        const Root& parent = roots_[root.parent];
        base = parent.samples[static_cast<std::size_t>(std::ranges::lower_bound(parent.places, root.base) -
                                                       parent.places.begin())];
      }
      add_samples(root, base);
    }
  }

  void add_samples(Root& root, std::uint32_t base) {
    root.link = (samples_[base].point - root.points[0]).norm();
    // A link of the length of rounding is none.
    if (!(root.link > 1e-9 * (root.points[0].cwiseAbs().maxCoeff() + longest_side_of(root.points)))) root.link = 0;
    const bool linked = root.link > 0;
    root.axis = axes_++;
    root.first = static_cast<std::uint32_t>(samples_.size());
    std::uint32_t last = base;
    for (std::size_t i = 0; i < root.places.size(); ++i) {
      if (i > 0 || linked) {
        const RsmlPlace& place = root.places[i];
        const std::size_t to = place.index + (place.part > 0);
        TreeSample sample;
        sample.point = rsml_point_at(root.points, place);
        sample.radius = root.radius[place.index];
        if (place.part > 0) sample.radius += place.part * (root.radius[to] - root.radius[place.index]);
        sample.type = root.type;
        sample.parent = last;
        sample.axis = root.axis;
        sample.bridged = i == 0 || (!root.bridged.empty() && root.bridged[to]);
        if (last == base) sample.base_radius = root.radius[0];
        const double before = last == base ? 0 : along_[last];
        along_.resize(samples_.size(), 0);
        along_.push_back(i == 0 ? 0 : before + (sample.point - samples_[last].point).norm());
        last = static_cast<std::uint32_t>(samples_.size());
        samples_.push_back(sample);
      }
      root.samples.push_back(last);
    }
  }

  void make_axes(Tree& tree) const {
    tree.axes.resize(axes_);
    for (const Root& root : roots_) {
      Tree::Axis& axis = tree.axes[root.axis];
      const std::uint32_t base = samples_[root.first].parent;
      axis.parent = root.parent == kNone ? kNone : roots_[root.parent].axis;
      axis.level = axis.parent == kNone ? 0 : tree.axes[axis.parent].level + 1;
      axis.plant = plants_[root.plant].number;
      axis.label = rsml_attribute(root.node, "label").value();
      axis.foreign = rsml_foreign_part(root.node, root.places);
      for (const std::uint32_t sample : root.samples) {  // its own: not the segment that joins it to its parent
        axis.points.push_back(samples_[sample].point);
        axis.radius.push_back(samples_[sample].radius);
      }
      axis.radius[0] = root.radius[0];
      if (axis.parent != kNone && samples_[base].axis == axis.parent) axis.position = along_[base];
      if (axis.parent == kNone && main_root_[root.plant] == index_of(root))
        tree.plants[axis.plant].main_axis = root.axis;
    }
    for (std::uint32_t b = 0; b < tree.branches.size(); ++b) tree.axes[tree.branches[b].axis].branches.push_back(b);
    for (std::uint32_t a = 0; a < tree.axes.size(); ++a)
      if (const std::uint32_t parent = tree.axes[a].parent; parent != kNone) tree.axes[parent].children.push_back(a);
    for (Tree::Axis& axis : tree.axes)
      std::ranges::stable_sort(axis.children, {}, [&](std::uint32_t child) { return tree.axes[child].position; });
  }

  std::uint32_t index_of(const Root& root) const { return static_cast<std::uint32_t>(&root - roots_.data()); }

  static std::string without_roots(const pugi::xml_node& plant) {
    pugi::xml_document document;
    pugi::xml_node kept = document.append_child("plant");
    for (const pugi::xml_attribute& a : plant.attributes()) kept.append_copy(a);
    for (const pugi::xml_node& node : plant.children())
      if (!rsml_is(node, "root")) kept.append_copy(node);
    return rsml_text_of(kept);
  }

  std::string without_plants() const {
    pugi::xml_document document;
    pugi::xml_node kept = document.append_child("rsml"), scene;
    for (const pugi::xml_attribute& a : xml_.document_element().attributes()) kept.append_copy(a);
    for (const pugi::xml_node& node : xml_.document_element().children()) {
      if (!rsml_is(node, "scene")) {
        kept.append_copy(node);
        continue;
      }
      if (!scene) scene = kept.append_child("scene");
      for (const pugi::xml_attribute& a : node.attributes()) scene.append_copy(a);
      for (const pugi::xml_node& part : node.children())
        if (!rsml_is(part, "plant")) scene.append_copy(part);
    }
    return rsml_text_of(kept);
  }

  void say_links() const {
    const auto linked = std::ranges::count_if(roots_, [](const Root& root) { return root.link > 0; });
    double sum = 0;
    for (const Root& root : roots_) sum += root.link;
    if (linked > 0)
      note(context_, fmt::format("'{}': {} where no other root is, and {} joined to the nearest place of the parent by "
                                 "straight segments, {:.4g} long in all, which are bridged and no part of the roots",
                                 file_.name, base::counted(linked, "root begins", "roots begin"),
                                 linked == 1 ? "is" : "are", sum));
  }

  void say_left_out() const {
    if (left_out_ > 0)
      note(context_,
           fmt::format("'{}': {} of fewer than two points left out", file_.name, base::counted(left_out_, "root")));
  }

  const FileText& file_;
  Context* context_;
  pugi::xml_document xml_;
  std::string unit_;
  double resolution_ = 1;
  bool has_z_ = false;
  std::vector<Plant> plants_;
  std::vector<Root> roots_;
  std::vector<std::uint32_t> main_root_;  ///< per plant
  std::vector<TreeSample> samples_;
  std::vector<double> along_;  ///< per sample: the length along its axis
  std::uint32_t axes_ = 0;
  std::int64_t left_out_ = 0;  ///< roots
};

}  // namespace

Tree read_rsml(const FileText& file, Context* context) { return RsmlReader(file, context).read(); }

}  // namespace quench::io
