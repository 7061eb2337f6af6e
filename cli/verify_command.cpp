// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "core_pipeline.h"
#include "program.h"
#include "quench/io.h"
#include "quench/verify.h"

namespace quench::program {

Action add_verify(CLI::App& app) {
  struct Options {
    ShapeOptions shape;
    std::vector<std::string> results;
    std::string lambda;
    std::size_t samples = 20000;
  };
  auto o = std::make_shared<Options>();
  add_shape_options(app, o->shape);
  app.add_option("RESULT", o->results, "What was computed of the shape (.vtp, ...). Options not given are taken from it")->required();
  app.add_option("--lambda", o->lambda, "The pruning radius the result claims [default: the result's]");
  app.add_option("--samples", o->samples, "Cells per sampled check")->capture_default_str();
  return [o](Session& session) {
    nlohmann::ordered_json report;
    bool passed = true;
    std::string made_with;
    LoadedShape loaded;
    for (std::size_t r = 0; r < o->results.size(); ++r) {
      const std::string& file = o->results[r];
      const PolyData data = io::read_poly_data(file);
      const std::string parameters = parameters_of(data);
      if (r == 0 || parameters != made_with) {  // results of one run share their shape
        ShapeOptions shape = o->shape;
        take_parameters(shape, data);
        loaded = load_shape(shape, session);
        made_with = parameters;
      }
      VerifyOptions options;
      options.samples = o->samples;
      if (!o->lambda.empty())
        options.lambda = parse_length(o->lambda, "--lambda").resolve(loaded.longest_side, loaded.shape.grid().spacing.minCoeff());
      const Certificate certificate = verify(loaded.shape, data, options, &session.context);
      auto& section = report[file] = nlohmann::ordered_json::object();
      for (const Check& check : certificate.checks) {
        fmt::print("{}: {} {}: {}\n", file, check.passed ? "ok  " : "FAIL", check.name, check.detail);
        section[check.name] = {{"passed", check.passed}, {"detail", check.detail}};
      }
      fmt::print("{}: {}\n", file, certificate.passed() ? "verified" : "NOT verified");
      passed = passed && certificate.passed();
    }
    if (!session.options.report.empty()) {
      report["verified"] = passed;
      write_report(session.options.report, report, session);
    }
    return passed ? 0 : static_cast<int>(ErrorCode::invariant);
  };
}

}  // namespace quench::program
