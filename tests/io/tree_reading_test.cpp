// SPDX-License-Identifier: Apache-2.0
// Trees of other programs: dialects, and files that are damaged.
#include <gtest/gtest.h>

#include "tree_facts.h"

namespace quench {
namespace tree_reading_test {

using namespace testing_trees;

/// 1 - 2 - 3, 2 - 4, and the soma of a second tree.
constexpr const char* kSloppySwc =
    "\xEF\xBB\xBF# a comment\r\n\r\n  4 3 2 -1 0 0.5 2 extra columns\r\n2 3.0 1 0 0 1 1\r\n# another\r\n"
    "1\t2\t0\t0\t0\t2\t-1\r\n3 3 2 1e0 +0 nan 2.0\r\n10 1 9 9 9 3 0\r\n11 2 9 9 12 1 10";

TEST(ReadSwc, SloppyFiles) {
  const TemporaryFolder folder;
  const Tree tree = read_text(folder, "a.swc", kSloppySwc);
  expect_sound(tree, false);
  ASSERT_EQ(tree.plants.size(), 2u);
  ASSERT_EQ(tree.branches.size(), 4u);
  EXPECT_EQ(tree.branches[0].points, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}}));
  EXPECT_EQ(tree.branches[0].radius, (std::vector<double>{2, 1}));
  EXPECT_EQ(tree.branches[1].points[1], Vec3(2, -1, 0));  // children in the order of the file
  EXPECT_EQ(tree.branches[2].points[1], Vec3(2, 1, 0));
  EXPECT_EQ(tree.branches[2].radius[1], 0);  // it was not a number
  EXPECT_EQ(tree.branches[0].strahler, 2u);
  EXPECT_EQ(tree.branches[1].order, 1u);
  EXPECT_EQ(tree.branches[1].type, 3);
  EXPECT_EQ(tree.plants[1].root, Vec3(9, 9, 9));
  EXPECT_EQ(tree.plants[1].soma, 3.);
  const Tree old_mac = read_text(folder, "b.swc", "1 1 0 0 0 1 -1\r2 3 1 0 0 1 1\r");
  EXPECT_EQ(old_mac.branches.size(), 1u);
}

TEST(ReadSwc, SomasOfOneThreeAndManySamples) {
  const TemporaryFolder folder;
  const std::string neurite = "9 3 9 0 0 1 1\n10 3 12 0 0 1 9\n";
  const Tree one = read_text(folder, "a.swc", "1 1 1 2 3 4 -1\n" + neurite);
  EXPECT_EQ(one.plants[0].root, Vec3(1, 2, 3));
  EXPECT_EQ(one.plants[0].soma, 4.);
  const Tree three = read_text(folder, "b.swc", "1 1 1 2 3 4 -1\n2 1 1 -2 3 4 1\n3 1 1 6 3 4 1\n" + neurite);
  EXPECT_EQ(three.plants[0].root, Vec3(1, 2, 3));
  EXPECT_EQ(three.plants[0].soma, 4.);
  ASSERT_EQ(three.branches.size(), 1u);
  EXPECT_EQ(three.branches[0].points, (std::vector<Vec3>{{1, 2, 3}, {9, 0, 0}, {12, 0, 0}}));
  // The outline of a soma of radius 2; a neurite hangs on a sample of it.
  const Tree outline = read_text(folder, "c.swc",
                                 "1 1 2 0 0 0 -1\n2 1 0 2 0 0 1\n3 1 -2 0 0 0 2\n4 1 0 -2 0 0 3\n"
                                 "9 3 9 0 0 1 3\n10 3 12 0 0 1 9\n");
  EXPECT_NEAR(outline.plants[0].root.norm(), 0, 1e-15);
  EXPECT_EQ(outline.plants[0].soma, 2.);
  EXPECT_EQ(outline.branches.size(), 1u);
  // A type that all samples have says nothing.
  const Tree all = read_text(folder, "d.swc", "1 1 0 0 0 1 -1\n2 1 1 0 0 1 1\n3 1 2 0 0 1 2\n4 1 3 0 0 1 3\n");
  EXPECT_FALSE(all.plants[0].soma);
  EXPECT_NEAR(measures_of(all).length, 3, 1e-15);
  // Labels of forks and ends are no types.
  const Tree labels = read_text(folder, "e.swc", "1 0 0 0 0 1 -1\n2 5 1 0 0 1 1\n3 6 2 0 0 1 2\n4 6 1 1 0 1 2\n");
  for (const Tree::Branch& b : labels.branches) EXPECT_EQ(b.type, 0);
}

TEST(ReadSwc, DamagedFiles) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::string& word) {
    const std::string sentence = refusal(folder, "a.swc", text);
    EXPECT_NE(sentence.find(word), std::string::npos) << sentence;
  };
  refused("", "empty");
  refused("# nothing\n", "no samples");
  refused("1 3 0 0 0 1 -1\n", "no branch");
  refused("1 3 0 0 0 1 -1\n2 3 1 0 0 1 3\n3 3 2 0 0 1 2\n", "line 2: the parents of this sample lead in a circle");
  refused("1 3 0 0 0 1 1\n", "circle");
  refused("1 3 0 0 0 1 -1\n2 3 1 0 0 1 7\n", "line 2: there is no sample of id 7");
  refused("1 3 0 0 0 1 -1\n1 3 1 0 0 1 1\n", "line 2: there is another sample of id 1, in line 1");
  refused("1 3 nan 0 0 1 -1\n", "line 1: a coordinate is not finite");
  refused("1 3 1e200 0 0 1 -1\n", "too large");
  refused("1 3 0 0 0 1\n", "the parent is missing");
  refused("1 3 0 0 0 1 0.5\n", "not a whole number");
  refused("99999999999999999999 3 0 0 0 1 -1\n", "not a whole number");
  refused("id,type,x,y,z,radius,parent\n1,3,0,0,0,1,-1\n", "the id");
  const Tree huge = read_text(folder, "b.swc", "9007199254740992 3 0 0 0 1 -1\n-7 3 1 0 0 1 9007199254740992\n");
  EXPECT_EQ(huge.branches.size(), 1u);
  std::string deep = "1 3 0 0 0 1 -1\n";
  for (int i = 2; i < 200000; ++i) deep += fmt::format("{0} 3 {0} 0 0 1 {1}\n", i, i - 1);
  EXPECT_EQ(read_text(folder, "c.swc", deep).branches.size(), 1u);
}

/// `body`: of a plant.
std::string rsml_of(const std::string& body, const std::string& metadata = "") {
  return "<?xml version='1.0'?><rsml xmlns:po='http://www.plantontology.org/xml-dtd/po.dtd'>" +
         (metadata.empty() ? "" : "<metadata>" + metadata + "</metadata>") + "<scene><plant ID='p1'>" + body +
         "</plant></scene></rsml>";
}

std::string root_of(const std::string& points, const std::string& more = "", const std::string& attributes = "") {
  std::string text = "<root " + attributes + "><geometry><polyline>";
  std::istringstream in(points);
  for (double x = 0, y = 0, z = 0; in >> x >> y >> z;) text += fmt::format("<point x='{}' y='{}' z='{}'/>", x, y, z);
  return text + "</polyline></geometry>" + more + "</root>";
}

TEST(ReadRsml, LateralsAreJoinedWhereTheirParentIsNearest) {
  const TemporaryFolder folder;
  const std::string function =
      "<functions><function domain='polyline' name='diameter'><sample value='2'/>"
      "<sample value='4'/></function></functions>";
  const Tree tree =
      read_text(folder, "a.rsml",
                rsml_of(root_of("0 0 0  0 0 -10", root_of("0.5 0 -2.5 3 0 -3") + root_of("0 0 -10 1 0 -10") +
                                                      root_of("0 0 -2.5 0 3 -3") + function)));
  expect_sound(tree);
  ASSERT_EQ(tree.axes.size(), 4u);
  ASSERT_EQ(tree.axes[0].points.size(), 3u);
  EXPECT_EQ(tree.axes[0].points[1], Vec3(0, 0, -2.5));
  EXPECT_EQ(tree.axes[0].radius, (std::vector<double>{1, 1.25, 2}));
  EXPECT_EQ(tree.axes[1].points, (std::vector<Vec3>{{0.5, 0, -2.5}, {3, 0, -3}}));
  EXPECT_EQ(tree.axes[1].position, 2.5);
  EXPECT_EQ(tree.axes[2].position, 10);  // it goes on where its parent ends
  EXPECT_EQ(tree.axes[3].points.size(), 2u);
  EXPECT_EQ(measures_of(tree).bridged, 0.5);
  EXPECT_EQ(tree.axes[0].children, (std::vector<std::uint32_t>{1, 3, 2}));
  expect_all_formats(tree, folder);
}

TEST(ReadRsml, Dialects) {
  const TemporaryFolder folder;
  const Tree box = read_text(folder, "a.rsml",
                             "<rsml><metadata><unit>cm</unit><resolution>2</resolution></metadata><scene><plant>"
                             "<root ID='1'><geometry><polyline><Point x='0' y='0' z='0'/><Point x='4' y='0' z='0'/>"
                             "</polyline></geometry><root/><functions><functions domain='polyline' name='radius'>"
                             "<sample>1</sample></functions></functions></root><root/></plant><plant/></scene></rsml>");
  expect_sound(box);
  EXPECT_EQ(box.coordinates.units, "cm");
  EXPECT_EQ(measures_of(box).length, 2);
  EXPECT_EQ(box.axes[0].radius, (std::vector<double>{0.5, 0.5}));
  io::write_rsml(folder / "b.rsml", box);
  expect_same(box, io::read_tree(folder / "b.rsml"));
  EXPECT_NE(text_of(folder / "b.rsml").find("<point x=\"4\""), std::string::npos);  // in pixels again
  // In the plane; a root of another origin; a diameter for the whole root.
  const Tree flat = read_text(folder, "c.rsml",
                              rsml_of("<root><geometry><polyline><point x='1' y='2'/><point x='1' y='5'/></polyline>"
                                      "</geometry><properties><diameter value='0.5'/></properties></root>"
                                      "<root><geometry><polyline><point x='2' y='2'/><point x='2' y='3'/></polyline>"
                                      "</geometry></root>"));
  expect_sound(flat);
  EXPECT_EQ(flat.down, Vec3::UnitY());
  EXPECT_TRUE(flat.coordinates.y_down);
  EXPECT_EQ(flat.axes[0].radius, (std::vector<double>{0.25, 0.25}));
  EXPECT_EQ(flat.axes[1].level, 0u);
  EXPECT_EQ(flat.axes[1].points, (std::vector<Vec3>{{2, 2, 0}, {2, 3, 0}}));
  EXPECT_EQ(measures_of(flat).bridged, 1);
  expect_all_formats(flat, folder);
  EXPECT_EQ(text_of(folder / "a.rsml").find(" z="), std::string::npos);
  // Functions by length and evenly spread.
  const auto thick = [&](const std::string& function) {
    return read_text(folder, "d.rsml", rsml_of(root_of("0 0 0 1 0 0 4 0 0", "<functions>" + function + "</functions>")))
        .axes[0]
        .radius;
  };
  EXPECT_EQ(thick("<function domain='uniform' name='diameter'><sample value='2'/><sample value='10'/></function>"),
            (std::vector<double>{1, 2, 5}));
  EXPECT_EQ(thick("<function domain='uniform' origin='tip' name='diameter'><sample value='10'/><sample value='2'/>"
                  "</function>"),
            (std::vector<double>{1, 2, 5}));
  EXPECT_EQ(thick("<function domain='length' name='radius'><sample position='1' value='1'/>"
                  "<sample position='2' value='4'/></function>"),
            (std::vector<double>{1, 1, 4}));
}

TEST(ReadRsml, WhatIsNotKnownIsWrittenAgain) {
  const TemporaryFolder folder;
  const Tree tree = read_text(
      folder, "a.rsml",
      rsml_of("<annotations><a x='1'>text &amp; more</a></annotations>" +
                  root_of("0 0 0 0 0 -4",
                          root_of("1 0 -1 5 0 -1",
                                  "<functions><function domain='polyline' name='age'><sample value='8'/><sample "
                                  "value='6'/></function><function domain='length' name='hair'><sample position='3' "
                                  "value='1'/></function><function domain='uniform' name='grey'><sample value='1'/>"
                                  "</function></functions>",
                                  "id='77' po:accession='PO:0020121'") +
                              "<properties><branch-list value='complete'/><length value='0'/></properties><functions>"
                              "<function domain='polyline' name='age'><sample value='4'/><sample value='0'/></function>"
                              "</functions>",
                          "id='x' label='L'"),
              "<unit>mm</unit><user>me</user><image><name>a.png</name></image>"));
  io::write_rsml(folder / "b.rsml", tree);
  const std::string text = text_of(folder / "b.rsml");
  for (const char* kept :
       {"<annotations>", "<a x=\"1\">text &amp; more</a>", "<branch-list value=\"complete\"", "<user>me</user>",
        "<name>a.png</name>", "po:accession=\"PO:0020121\"", "xmlns:po=", "id=\"77\"", "label=\"L\"", "name=\"age\"",
        "<plant ID=\"p1\">", "<sample position=\"3\" value=\"1\"", "name=\"grey\""})
    EXPECT_NE(text.find(kept), std::string::npos) << kept << "\n" << text;
  EXPECT_NE(text.find("<sample value=\"3\""), std::string::npos);  // the age where the lateral is joined
  EXPECT_NE(text.find("<length value=\"4\""), std::string::npos);
  const auto facts = described(folder, "b.rsml");
  EXPECT_NE(facts.at("found").find("age:2"), std::string::npos);
  io::write_rsml(folder / "c.rsml", io::read_tree(folder / "b.rsml"));
  EXPECT_EQ(text, text_of(folder / "c.rsml"));
}

TEST(ReadRsml, RootsKeepTheirOwnRadii) {
  const TemporaryFolder folder;
  const auto thick = [](const char* diameter) {
    return fmt::format("<properties><diameter value='{}'/></properties>", diameter);
  };
  const Tree tree = read_text(folder, "a.rsml",
                              rsml_of(root_of("0 0 0 0 0 -4", root_of("0 0 -1 5 0 -1", thick("2")) +
                                                                  root_of("0 3 -2 0 9 -2", thick("4")) + thick("20"))));
  EXPECT_EQ(tree.axes[1].radius, (std::vector<double>{1, 1}));
  EXPECT_EQ(tree.axes[2].radius, (std::vector<double>{2, 2}));
  EXPECT_EQ(std::get<std::vector<double>>(traits_of(tree).sample.find("total_length")->values)[0], 15);
  EXPECT_EQ(std::get<std::vector<double>>(traits_of(tree).sample.find("bridged_length")->values)[0], 3);
}

TEST(ReadRsml, AnUnknownUnitStaysUnknown) {
  const TemporaryFolder folder;
  for (const std::string unit : {"", "pixel"}) {
    read_text(folder, "a.rsml", rsml_of(root_of("0 0 0 0 0 -4"), unit.empty() ? "" : "<unit>" + unit + "</unit>"));
    io::write_rsml(folder / "b.rsml", io::read_tree(folder / "a.rsml"));
    EXPECT_EQ(described(folder, "b.rsml").at("unit"), unit.empty() ? "None" : unit);
    EXPECT_EQ(io::read_tree(folder / "b.rsml").coordinates.units, unit);
  }
}

TEST(ReadRsml, DamagedFiles) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::string& word) {
    const std::string sentence = refusal(folder, "a.rsml", text);
    EXPECT_NE(sentence.find(word), std::string::npos) << sentence;
  };
  const std::string whole = rsml_of(root_of("0 0 0 1 0 0", root_of("1 0 0 2 0 0")));
  EXPECT_EQ(read_text(folder, "w.rsml", whole).axes.size(), 2u);
  for (std::size_t size = 1; size + 1 < whole.size(); ++size) refusal(folder, "a.rsml", whole.substr(0, size));
  refused("<svg/>", "not an RSML file");
  refused("<rsml/>", "no root of two points");
  refused(rsml_of("<root/>"), "no root of two points");
  refused(rsml_of(root_of("0 0 0")), "no root of two points");
  refused(rsml_of("<root id='r\n1'><geometry><polyline><point x='0' y='nan'/></polyline></geometry></root>"),
          "point 1 of root 'r 1'");
  refused(rsml_of("<root><geometry><polyline><point x='0'/></polyline></geometry></root>"), "y is not a number");
  refused(rsml_of(root_of("0 0 0 1e200 0 0")), "too far");
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<root>";
  for (int i = 0; i < 100000; ++i) deep += "</root>";
  refused(rsml_of(deep), "nested more than 1000 deep");
  // Entities are not expanded.
  std::string laughs = "<!DOCTYPE rsml [<!ENTITY a 'ha'>";
  for (char c = 'b'; c < 'z'; ++c)
    laughs += fmt::format("<!ENTITY {0} '&{1};&{1};&{1};&{1};&{1};&{1};&{1};&{1};'>", c, static_cast<char>(c - 1));
  const Tree dull = read_text(
      folder, "b.rsml", laughs + "]>" + rsml_of(root_of("0 0 0 1 0 0", "<b>&y;</b>"), "<user>&y;</user>").substr(21));
  EXPECT_EQ(dull.axes.size(), 1u);
  const Tree odd = read_text(
      folder, "c.rsml", rsml_of(root_of("0 0 0 0 0 0 0 0 0", root_of("0 0 0 1 1 1")), "<resolution>0</resolution>"));
  expect_sound(odd);
}

}  // namespace tree_reading_test
}  // namespace quench
