#include "lab/bench/benchmarks.h"

#include <fmt/format.h>

#include <memory>

#include "app/json_output.h"
#include "lab/bench/onnx_peer.h"
#include "mien/core/files.h"

namespace mien::lab {
namespace {

struct BenchOnnxruntimeOptions {
  std::vector<std::string> models;
  PeerRequest request;
  bool json = false;
};

app::Json peer_figures(const std::string& model, const PeerTimes& times) {
  app::Json graphs = app::Json::array();
  for (const PeerTimes::Graph& graph : times.graphs)
    graphs.push_back({{"steps", graph.steps},
                      {"run_us", 1e6 * graph.run_s},
                      {"echo_us", 1e6 * graph.echo_s},
                      {"step_us", 1e6 * graph.step_s},
                      {"best_step_us", 1e6 * graph.best_step_s}});
  return {{"model", model},
          {"kind", times.kind},
          {"onnxruntime", times.version},
          {"node", times.node},
          {"step_us", 1e6 * times.step_s},
          {"best_step_us", 1e6 * times.best_step_s},
          {"graphs", graphs},
          {"largest_difference", times.largest_difference},
          {"hash", times.hash}};
}

void print(const std::string& model, const PeerTimes& times) {
  fmt::print("{} ({}), ONNX Runtime {}, Node {}, one thread, fp32\n", model, times.kind, times.version,
             times.node);
  fmt::print("{:>8} {:>12} {:>12} {:>12} {:>12}   us\n", "steps", "a run", "doing nothing", "a step",
             "best step");
  for (const PeerTimes::Graph& graph : times.graphs)
    fmt::print("{:>8} {:>12.1f} {:>13.1f} {:>12.2f} {:>12.2f}\n", graph.steps, 1e6 * graph.run_s,
               1e6 * graph.echo_s, 1e6 * graph.step_s, 1e6 * graph.best_step_s);
  fmt::print("at its best {:.2f} us a step; differs from our run time by {:.2g}; hash {}\n\n",
             1e6 * times.step_s, times.largest_difference, times.hash);
}

Result<void> run_bench_onnxruntime(BenchOnnxruntimeOptions options) {
  if (options.models.empty())
    for (const char* name : {"models/live.safetensors", "models/default.safetensors"}) {
      MIEN_TRY_ASSIGN(const std::filesystem::path path, find_resource(name));
      options.models.push_back(path.string());
    }
  app::Json measured = app::Json::array();
  for (const std::string& model : options.models) {
    options.request.model = model;
    MIEN_TRY_ASSIGN(const PeerTimes times, measure_onnxruntime(options.request));
    if (options.json)
      measured.push_back(peer_figures(model, times));
    else
      print(model, times);
  }
  if (options.json) app::print_json({{"models", measured}});
  return {};
}

}  // namespace

void add_onnxruntime_bench(app::Commands& commands, app::Command bench) {
  auto options = std::make_shared<BenchOnnxruntimeOptions>();
  const app::Command command = commands.add_under(
      bench, "onnxruntime",
      "ONNX Runtime on the same networks, one thread: a causal network's steps in a row within one graph, a "
      "window network's full window",
      "mien bench onnxruntime --json", [options] { return run_bench_onnxruntime(*options); });
  command.add_option("--model", options->models,
                     "A model file; may be given many times (default: the live and the window model)");
  command.add_option("--rounds", options->request.effort.rounds, "Rounds through all graphs")
      .in_range(1, 1000)
      .show_default();
  app::add_json_flag(command, options->json);
}

}  // namespace mien::lab
