#include "app/bench/onnx_peer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "app/child_program.h"
#include "app/json_output.h"
#include "app/private_folder.h"
#include "mien/core/files.h"
#include "mien/core/random.h"
#include "mien/core/sha256.h"
#include "mien/model/causal_network.h"
#include "mien/model/denoiser.h"
#include "mien/model/schedule.h"
#include "mien/onnx/export_model.h"

namespace mien::app {
namespace fs = std::filesystem;
namespace {

using Floats = std::vector<float>;

constexpr std::size_t kChains[] = {1, 4, 16, 64};
/// More than this is not the same computation.
constexpr double kSameAnswer = 1e-3;
constexpr const char* kInstall =
    "run script/bootstrap, or install Debian's nodejs and npm and call `npm ci` in script/onnxruntime";

/// One graph to be timed, what goes in, and what must come out.
struct Job {
  onnx::ExportRequest request;
  Json inputs;
  Floats expected;
};

Floats noise(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  Floats values(count);
  for (float& v : values) v = static_cast<float>(random.normal());
  return values;
}

Json tensor(std::vector<std::size_t> dims, const Floats& data) {
  return {{"dims", std::move(dims)}, {"data", data}};
}

Result<Job> causal_job(const model::ModelFile& model, std::size_t steps) {
  const model::Architecture& a = model.architecture;
  MIEN_TRY_ASSIGN(const model::CausalNetwork network, model::CausalNetwork::create(a, model.network));
  model::CausalNetwork::State state(network);
  const Floats conditions = noise(steps * a.condition, 1);
  Job job{.request = {.steps = steps}, .inputs = {}, .expected = Floats(steps * a.outputs)};
  for (std::size_t s = 0; s < steps; ++s)
    network.step(std::span(conditions).subspan(s * a.condition, a.condition), state,
                 std::span(job.expected).subspan(s * a.outputs, a.outputs));
  for (float& v : job.expected) v = model::from_network(v);
  job.inputs["condition"] = tensor({steps, a.condition}, conditions);
  for (std::size_t i = 0; i < a.layers; ++i)
    job.inputs[fmt::format("state_{}", i)] = tensor({1, a.d_model}, Floats(a.d_model));
  return job;
}

Result<Job> window_job(const model::ModelFile& model) {
  const model::Architecture& a = model.architecture;
  MIEN_TRY_ASSIGN(const model::Denoiser denoiser, model::Denoiser::create(a, model.network));
  model::Denoiser::Workspace workspace(denoiser);
  const std::size_t level = model.schedule.levels / 2;
  const Floats condition = noise(a.window * a.condition, 1), noisy = noise(a.window * a.outputs, 2);
  Job job{.request = {}, .inputs = {}, .expected = Floats(noisy.size())};
  denoiser.set_condition(condition, workspace);
  denoiser.predict(noisy, level, job.expected, workspace);
  job.inputs = {{"noisy", tensor({1, a.window, a.outputs}, noisy)},
                {"condition", tensor({1, a.window, a.condition}, condition)},
                {"level", tensor({1}, {static_cast<float>(level)})}};
  return job;
}

Result<std::vector<Job>> jobs_of(const model::ModelFile& model) {
  std::vector<Job> jobs;
  switch (model.architecture.kind) {
    case model::NetworkKind::causal:
      for (const std::size_t steps : kChains) {
        MIEN_TRY_ASSIGN(Job job, causal_job(model, steps));
        jobs.push_back(std::move(job));
      }
      break;
    case model::NetworkKind::window: {
      MIEN_TRY_ASSIGN(Job job, window_job(model));
      jobs.push_back(std::move(job));
      break;
    }
  }
  return jobs;
}

/// Writes the graphs, their echoes and the list of both.
Result<void> write_jobs(const model::ModelFile& model, const std::vector<Job>& jobs,
                        const PeerRequest& request, const fs::path& folder) {
  Json list = {{"rounds", request.rounds}, {"round_s", request.round_s}, {"graphs", Json::array()}};
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    MIEN_TRY_ASSIGN(const std::vector<std::byte> graph, onnx::onnx_of(model, jobs[i].request));
    MIEN_TRY_ASSIGN(const std::vector<std::byte> echo, onnx::echo_of(graph));
    const fs::path graph_path = folder / fmt::format("{}.onnx", i),
                   echo_path = folder / fmt::format("{}-echo.onnx", i);
    MIEN_TRY(write_file(graph_path, graph));
    MIEN_TRY(write_file(echo_path, echo));
    list["graphs"].push_back({{"name", fmt::format("{}", i)},
                              {"model", graph_path.string()},
                              {"echo", echo_path.string()},
                              {"steps", jobs[i].request.steps},
                              {"inputs", jobs[i].inputs}});
  }
  return write_file(folder / "job.json", list.dump());
}

/// What `node` prints for a script with one argument.
Result<std::string> run_node(const fs::path& script, const fs::path& argument) {
  const auto said = run_child({"node", script.string(), argument.string()});
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
Result<PeerTimes> read_times(const Json& told, const std::vector<Job>& jobs) {
  PeerTimes times;
  times.version = told.at("onnxruntime").get<std::string>();
  times.node = told.at("node").get<std::string>();
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const Json& graph = told.at("graphs").at(i);
    times.graphs.push_back({.steps = jobs[i].request.steps,
                            .run_s = graph.at("run_s"),
                            .echo_s = graph.at("echo_s"),
                            .step_s = graph.at("step_s"),
                            .best_step_s = graph.at("best_step_s")});
    const auto answer = graph.at("answer").get<Floats>();
    if (answer.size() != jobs[i].expected.size())
      return fail(ErrorCode::mismatch, "it gives another number of numbers than we do", "ONNX Runtime");
    for (std::size_t v = 0; v < answer.size(); ++v)
      times.largest_difference =
          std::max(times.largest_difference, std::abs(double{answer[v]} - double{jobs[i].expected[v]}));
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

}  // namespace

Result<PeerTimes> measure_onnxruntime(const PeerRequest& request) {
  MIEN_TRY_ASSIGN(const model::ModelFile model, model::read_model(request.model));
  const auto script = find_resource("script/onnxruntime/time.mjs");
  if (!script || !find_resource("script/onnxruntime/node_modules/onnxruntime-node"))
    return fail(ErrorCode::not_found, "onnxruntime-node is not installed", "ONNX Runtime", kInstall);
  MIEN_TRY_ASSIGN(const std::vector<Job> jobs, jobs_of(model));
  MIEN_TRY_ASSIGN(const PrivateFolder folder, PrivateFolder::make());
  MIEN_TRY(write_jobs(model, jobs, request, folder.path()));
  MIEN_TRY_ASSIGN(const std::string out, run_node(*script, folder.path() / "job.json"));
  try {
    MIEN_TRY_ASSIGN(PeerTimes times, read_times(Json::parse(out), jobs));
    times.kind = model.architecture.kind == model::NetworkKind::causal ? "causal" : "window";
    return times;
  } catch (const Json::exception& error) {
    return fail(ErrorCode::internal, error.what(), script->string());
  }
}

}  // namespace mien::app
