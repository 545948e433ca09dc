#include "lab/bench/onnx_peer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>

#include "app/child_program.h"
#include "app/json_output.h"
#include "app/private_folder.h"
#include "lab/bench/benchmarks.h"
#include "lab/commands/output.h"
#include "mien/core/files.h"
#include "mien/core/random.h"
#include "mien/core/sha256.h"
#include "mien/model/causal_network.h"
#include "mien/model/denoiser.h"
#include "mien/model/schedule.h"
#include "mien/onnx/export_model.h"

namespace mien::lab {

namespace fs = std::filesystem;

namespace {

using Floats = std::vector<float>;

constexpr std::size_t kChains[] = {1, 4, 16, 64};
/// More than this is not the same computation.
constexpr double kSameAnswer = 1e-3;
constexpr const char* kInstall =
    "run script/bootstrap, or install Debian's nodejs and npm and call `npm ci` in script/onnxruntime";

Floats noise(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  Floats values(count);
  for (float& v : values) v = static_cast<float>(random.normal());
  return values;
}

app::Json tensor(std::vector<std::size_t> dims, const Floats& data) {
  return {{"dims", std::move(dims)}, {"data", data}};
}

Result<PeerGraph> causal_graph(const model::ModelFile& model, std::size_t steps) {
  const model::Architecture& a = model.architecture;
  MIEN_TRY_ASSIGN(const model::CausalNetwork network, model::CausalNetwork::create(a, model.network));
  model::CausalNetwork::State state(network);
  const Floats conditions = noise(steps * a.condition, 1);
  MIEN_TRY_ASSIGN(std::vector<std::byte> onnx, onnx::onnx_of(model, {.steps = steps}));
  PeerGraph graph{
      .onnx = std::move(onnx), .steps = steps, .inputs = {}, .expected = Floats(steps * a.outputs)};
  for (std::size_t s = 0; s < steps; ++s)
    network.step(std::span(conditions).subspan(s * a.condition, a.condition), state,
                 std::span(graph.expected).subspan(s * a.outputs, a.outputs));
  for (float& v : graph.expected) v = model::from_network(v);
  graph.inputs["condition"] = tensor({steps, a.condition}, conditions);
  for (std::size_t i = 0; i < a.layers; ++i)
    graph.inputs[fmt::format("state_{}", i)] = tensor({1, a.d_model}, Floats(a.d_model));
  return graph;
}

Result<PeerGraph> window_graph(const model::ModelFile& model) {
  const model::Architecture& a = model.architecture;
  MIEN_TRY_ASSIGN(const model::Denoiser denoiser, model::Denoiser::create(a, model.network));
  model::Denoiser::Workspace workspace(denoiser);
  const std::size_t level = model.schedule.levels / 2;
  const Floats condition = noise(a.window * a.condition, 1), noisy = noise(a.window * a.outputs, 2);
  MIEN_TRY_ASSIGN(std::vector<std::byte> onnx, onnx::onnx_of(model));
  PeerGraph graph{.onnx = std::move(onnx), .inputs = {}, .expected = Floats(noisy.size())};
  denoiser.set_condition(condition, workspace);
  denoiser.predict(noisy, level, graph.expected, workspace);
  graph.inputs = {{"noisy", tensor({1, a.window, a.outputs}, noisy)},
                  {"condition", tensor({1, a.window, a.condition}, condition)},
                  {"level", tensor({1}, {static_cast<float>(level)})}};
  return graph;
}

Result<std::vector<PeerGraph>> graphs_of(const model::ModelFile& model) {
  std::vector<PeerGraph> graphs;
  switch (model.architecture.kind) {
    case model::NetworkKind::causal:
      for (const std::size_t steps : kChains) {
        MIEN_TRY_ASSIGN(PeerGraph graph, causal_graph(model, steps));
        graphs.push_back(std::move(graph));
      }
      break;
    case model::NetworkKind::window: {
      MIEN_TRY_ASSIGN(PeerGraph graph, window_graph(model));
      graphs.push_back(std::move(graph));
      break;
    }
    case model::NetworkKind::views:  // bench headset brings graphs of its own.
      break;
  }
  return graphs;
}

/// Writes the graphs, their echoes and the list of both.
Result<void> write_graphs(const std::vector<PeerGraph>& graphs, const PeerEffort& effort,
                          const fs::path& folder) {
  app::Json list = {{"rounds", effort.rounds}, {"round_s", effort.round_s}, {"graphs", app::Json::array()}};
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    MIEN_TRY_ASSIGN(const std::vector<std::byte> echo, onnx::echo_of(graphs[i].onnx));
    const fs::path graph_path = folder / fmt::format("{}.onnx", i),
                   echo_path = folder / fmt::format("{}-echo.onnx", i);
    MIEN_TRY(write_file(graph_path, graphs[i].onnx));
    MIEN_TRY(write_file(echo_path, echo));
    list["graphs"].push_back({{"name", fmt::format("{}", i)},
                              {"model", graph_path.string()},
                              {"echo", echo_path.string()},
                              {"steps", graphs[i].steps},
                              {"inputs", graphs[i].inputs}});
  }
  return write_file(folder / "job.json", list.dump());
}

/// What `node` prints for a script with one argument.
Result<std::string> run_node(const fs::path& script, const fs::path& argument) {
  const auto said = app::run_child({"node", script.string(), argument.string()});
  if (!said && said.error().code == ErrorCode::not_found)
    return fail(ErrorCode::not_found, "there is no program `node`", "ONNX Runtime", kInstall);
  if (!said) return std::unexpected(said.error());
  if (said->succeeded()) return said->out;
  // Node shows the line of the script first; what went wrong stands where "Error" does.
  std::string line = said->complaints;
  if (const auto at = line.find("Error"); at != std::string::npos) line = line.substr(at);
  line = line.substr(0, line.find('\n'));
  return fail(ErrorCode::io, line.empty() ? "it stopped without a word" : line, "node " + script.string(),
              "install it again: " + std::string(kInstall));
}

/// What the script told, as its comment says, against what was expected.
Result<PeerTimes> read_times(const app::Json& told, const std::vector<PeerGraph>& graphs) {
  PeerTimes times;
  times.version = told.at("onnxruntime").get<std::string>();
  times.node = told.at("node").get<std::string>();
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    const app::Json& graph = told.at("graphs").at(i);
    times.graphs.push_back({.steps = graphs[i].steps,
                            .run_s = graph.at("run_s"),
                            .echo_s = graph.at("echo_s"),
                            .step_s = graph.at("step_s"),
                            .best_step_s = graph.at("best_step_s")});
    const auto answer = graph.at("answer").get<Floats>();
    if (!graphs[i].expected.empty() && answer.size() != graphs[i].expected.size())
      return fail(ErrorCode::mismatch, "it gives another number of numbers than we do", "ONNX Runtime");
    for (std::size_t v = 0; v < graphs[i].expected.size(); ++v)
      times.largest_difference =
          std::max(times.largest_difference, std::abs(double{answer[v]} - double{graphs[i].expected[v]}));
    Sha256 hash;
    hash.add(std::as_bytes(std::span(answer)));
    times.hash = hash.hex();
  }
  if (!(times.largest_difference <= kSameAnswer))
    return fail(ErrorCode::mismatch,
                fmt::format("its answer differs from ours by {:.2g}, so its time is of something else",
                            times.largest_difference),
                "ONNX Runtime");
  times.step_s = std::ranges::min(times.graphs, {}, &PeerTimes::Graph::step_s).step_s;
  times.best_step_s = std::ranges::min(times.graphs, {}, &PeerTimes::Graph::best_step_s).best_step_s;
  return times;
}

struct BenchOnnxruntimeOptions {
  std::vector<std::string> models;
  PeerRequest request;
  Output to;
};

const Columns<PeerTimes::Graph>& graph_columns() {
  using Graph = PeerTimes::Graph;
  static const Columns<Graph> columns = {
      {"steps", "steps", "{}", &Graph::steps},
      {"run_us", "a run, us", "{:.1f}", [](const Graph& g) { return 1e6 * g.run_s; }},
      {"echo_us", "doing nothing", "{:.1f}", [](const Graph& g) { return 1e6 * g.echo_s; }},
      {"step_us", "a step", "{:.2f}", [](const Graph& g) { return 1e6 * g.step_s; }},
      {"best_step_us", "best step", "{:.2f}", [](const Graph& g) { return 1e6 * g.best_step_s; }}};
  return columns;
}

app::Json peer_figures(const std::string& model, const PeerTimes& times) {
  return {{"model", model},
          {"kind", times.kind},
          {"onnxruntime", times.version},
          {"node", times.node},
          {"step_us", 1e6 * times.step_s},
          {"best_step_us", 1e6 * times.best_step_s},
          {"graphs", json_of(times.graphs, graph_columns())},
          {"largest_difference", times.largest_difference},
          {"hash", times.hash}};
}

Result<void> run_bench_onnxruntime(BenchOnnxruntimeOptions options) {
  if (options.models.empty())
    for (const char* name : {"models/live.safetensors", "models/default.safetensors"}) {
      MIEN_TRY_ASSIGN(const std::filesystem::path path, find_resource(name));
      options.models.push_back(path.string());
    }
  app::Json measured = app::Json::array();
  measure::Report report("ONNX Runtime, one thread, fp32");
  for (const std::string& model : options.models) {
    options.request.model = model;
    MIEN_TRY_ASSIGN(const PeerTimes times, measure_onnxruntime(options.request));
    measured.push_back(peer_figures(model, times));
    report.table(table_of(
        fmt::format("{} ({}), ONNX Runtime {}, Node {}", model, times.kind, times.version, times.node),
        times.graphs, graph_columns()));
    report.text(fmt::format("At its best {:.2f} us a step; differs from our run time by {:.2g}; hash {}",
                            1e6 * times.step_s, times.largest_difference, times.hash));
  }
  return put_out(options.to, report, {{"models", measured}});
}

}  // namespace

Result<PeerTimes> measure_graphs(const std::vector<PeerGraph>& graphs, const PeerEffort& effort) {
  const auto script = find_resource("script/onnxruntime/time.mjs");
  if (!script || !find_resource("script/onnxruntime/node_modules/onnxruntime-node"))
    return fail(ErrorCode::not_found, "onnxruntime-node is not installed", "ONNX Runtime", kInstall);
  MIEN_TRY_ASSIGN(const app::PrivateFolder folder, app::PrivateFolder::make());
  MIEN_TRY(write_graphs(graphs, effort, folder.path()));
  MIEN_TRY_ASSIGN(const std::string out, run_node(*script, folder.path() / "job.json"));
  try {
    return read_times(app::Json::parse(out), graphs);
  } catch (const app::Json::exception& error) {
    return fail(ErrorCode::internal, error.what(), script->string());
  }
}

Result<PeerTimes> measure_onnxruntime(const PeerRequest& request) {
  MIEN_TRY_ASSIGN(const model::ModelFile model, model::read_model(request.model));
  MIEN_TRY_ASSIGN(const std::vector<PeerGraph> graphs, graphs_of(model));
  MIEN_TRY_ASSIGN(PeerTimes times, measure_graphs(graphs, request.effort));
  times.kind = model.architecture.kind == model::NetworkKind::causal ? "causal" : "window";
  return times;
}

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
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
