// SPDX-License-Identifier: Apache-2.0
// A reader of surfaces and medial axes: QUENCH_FUZZ_READER names it. What it accepts must be valid, and must do for
// what the program makes of it.
#include <sstream>

#include "io/common/formats.h"
#include "quench/axis.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quench;
  fuzz::reads_or_refuses([&] {
    const Record read = io::QUENCH_FUZZ_READER({"file", std::string(reinterpret_cast<const char*>(data), size)});
    try {
      read.validate();
    } catch (const Error&) {
      fuzz::defect("the reader accepted a file and made invalid data of it");
    }
    const TriangleMesh mesh = to_triangle_mesh(read);
    for (const auto& triangle : mesh.triangles)
      for (const std::uint32_t corner : triangle)
        if (corner >= mesh.points.size()) fuzz::defect("a triangle has a corner that is no point");
    if (size % 16 == 0) {  // takes ten times as long as reading
      std::ostringstream xml;
      io::write_vtp(xml, read);
      const Record again = io::read_vtp({"again", std::move(xml).str()});
      if (again.points != read.points || again.lines != read.lines || again.poly_corners != read.poly_corners)
        fuzz::defect("written as VTP and read again, the data differ");
    }
    AxisRepair repair;
    medial_axis_of(read, &repair);
  });
  return 0;
}
