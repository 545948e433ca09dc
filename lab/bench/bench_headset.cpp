#include "lab/bench/bench_headset.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/json_output.h"
#include "lab/bench/bench_camera_frames.h"
#include "lab/bench/bench_pictures.h"
#include "lab/bench/clock.h"
#include "lab/bench/onnx_peer.h"
#include "lab/bench/paced.h"
#include "mien/core/random.h"
#include "mien/core/sha256.h"
#include "mien/headset/headset_model.h"
#include "mien/model/backbone.h"
#include "mien/model/peak.h"
#include "mien/onnx/export_model.h"
#include "mien/onnx/rival_graphs.h"

namespace mien::lab {
namespace {

using Floats = std::vector<float>;
using Weights = std::vector<model::Tensor>;
using model::Precision;

constexpr Precision kPrecisions[] = {Precision::fp32, Precision::bf16, Precision::int8};
/// Views that share a network: two eyes, or a mouth's two.
constexpr std::size_t kViews = 2;
constexpr auto kViewsInterval = std::chrono::nanoseconds(16'666'667);

/// Weights as a fresh training run has them, which keep the numbers' size from layer to layer.
Weights random_weights(const model::BackboneShape& shape, Random& random) {
  Weights weights;
  for (const model::TensorSpec& spec : model::tensor_specs(shape)) {
    std::size_t count = 1, inputs = 1;
    for (const std::size_t n : spec.shape) count *= n;
    for (std::size_t i = 1; i < spec.shape.size(); ++i) inputs *= spec.shape[i];
    const double spread = spec.shape.size() > 1 ? std::sqrt(2 / static_cast<double>(inputs)) : 0.05;
    model::Tensor& tensor = weights.emplace_back(model::Tensor{spec.name, spec.shape, Floats(count)});
    for (float& v : tensor.values) v = static_cast<float>(spread * random.normal());
  }
  return weights;
}

/// A site of the face, the network that looks at it, and its pictures.
struct Site {
  const char* name;
  Weights weights;
  Floats pictures;
};

struct Headset {
  explicit Headset(std::uint64_t seed) {
    Random random(seed);
    for (const char* name : {"eye", "mouth"}) {
      Site& site = sites.emplace_back(Site{name, random_weights(shape, random), Floats(numbers())});
      for (float& v : site.pictures) v = static_cast<float>(random.uniform());
    }
  }
  [[nodiscard]] std::size_t numbers() const { return kViews * shape.size * shape.size; }
  [[nodiscard]] double flop() const {
    return static_cast<double>(kViews * sites.size()) * model::flop_count(shape);
  }

  model::BackboneShape shape;
  std::vector<Site> sites;
};

/// All views of a headset through its networks.
class Encoder {
 public:
  static Result<Encoder> create(const Headset& headset, Precision precision) {
    Encoder encoder;
    for (const Site& site : headset.sites) {
      MIEN_TRY_ASSIGN(model::Backbone backbone,
                      model::Backbone::create(headset.shape, site.weights, precision));
      encoder.parts_.push_back(
          {site.pictures, std::move(backbone), std::nullopt, Floats(kViews * headset.shape.features)});
      Part& part = encoder.parts_.back();
      part.workspace.emplace(part.backbone, kViews);
    }
    return encoder;
  }

  void run() {
    for (Part& part : parts_) part.backbone.apply(part.pictures, *part.workspace, part.features);
  }
  [[nodiscard]] const Floats& features(std::size_t site) const { return parts_[site].features; }
  [[nodiscard]] std::string hash() const {
    Sha256 hash;
    for (const Part& part : parts_) hash.add(std::as_bytes(std::span(part.features)));
    return hash.hex();
  }
  [[nodiscard]] std::size_t weight_bytes() const {
    std::size_t bytes = 0;
    for (const Part& part : parts_) bytes += part.backbone.weight_bytes();
    return bytes;
  }

 private:
  struct Part {
    std::span<const float> pictures;
    model::Backbone backbone;
    std::optional<model::Backbone::Workspace> workspace;
    Floats features;
  };
  std::vector<Part> parts_;
};

struct MeasuredEncoder {
  Precision precision = Precision::fp32;
  double hot_s = 0;
  Spread hot, paced;
  std::size_t weight_bytes = 0;
  std::string hash;
};

struct EncoderFigures {
  double peak_gflops = 0, flop = 0;
  std::vector<MeasuredEncoder> precisions;
  struct Peers {
    double same_s = 0;    ///< ONNX Runtime on the same four views.
    double rivals_s = 0;  ///< On networks of the sizes that other programs run for two eyes and a mouth.
  };
  std::optional<Peers> peers;
  std::string why_not;       ///< Else.
  PictureFigures pictures;   ///< Of the simulator.
  CameraFrameFigures whole;  ///< Pictures to weights.

  /// That of sessions.
  [[nodiscard]] const MeasuredEncoder& of_session() const {
    return *std::ranges::find(precisions, headset::kHeadsetPrecision, &MeasuredEncoder::precision);
  }
  /// How much longer those of others take than the encoder of four views and the frame made of them: networks
  /// beside networks, of pictures that are decoded and cut out.
  [[nodiscard]] double vs_rivals() const { return peers->rivals_s / (of_session().hot_s + whole.frame_s); }
};

Spread measure_each(Encoder& encoder) {
  std::vector<double> took(1000);
  for (double& one : took) {
    const auto from = Clock::now();
    encoder.run();
    one = seconds_since(from);
  }
  return spread_of(std::move(took));
}

/// Sixty a second, with cold caches.
Result<Spread> measure_paced(Encoder& encoder, std::size_t frames, const std::string& what,
                             const Progress& progress) {
  OtherProgram other;
  std::vector<double> took(frames);
  auto next = Clock::now();
  for (std::size_t f = 0; f < frames; ++f) {
    other.read();
    // A frame that the machine kept from us does not make the next one hurry.
    next = std::max(next + kViewsInterval, Clock::now());
    std::this_thread::sleep_until(next);
    const auto from = Clock::now();
    encoder.run();
    took[f] = seconds_since(from);
    if (!progress(static_cast<double>(f + 1) / static_cast<double>(frames),
                  what + " at 60 a second, caches cold"))
      return fail(ErrorCode::cancelled, "stopped before it was done", "bench headset");
  }
  return spread_of(std::move(took));
}

/// Each site's two views in one call, and one by one: ONNX Runtime may have whichever is quicker. Then
/// others' networks.
Result<EncoderFigures::Peers> measure_peers(const Headset& headset, const Encoder& fp32, std::uint64_t seed) {
  const std::size_t size = headset.shape.size;
  std::vector<PeerGraph> graphs;
  for (std::size_t site = 0; site < headset.sites.size(); ++site) {
    MIEN_TRY_ASSIGN(const std::vector<std::byte> onnx,
                    onnx::onnx_of(headset.shape, headset.sites[site].weights));
    for (const std::size_t views : {kViews, std::size_t{1}}) {
      PeerGraph& graph = graphs.emplace_back(PeerGraph{.onnx = onnx, .inputs = {}, .expected = {}});
      const auto pictures = std::span(headset.sites[site].pictures).first(views * size * size);
      graph.inputs["pictures"] = {{"dims", {views, std::size_t{1}, size, size}}, {"data", pictures}};
      const auto features = std::span(fp32.features(site)).first(views * headset.shape.features);
      graph.expected.assign(features.begin(), features.end());
    }
  }
  const std::size_t ours = graphs.size();
  Random random(seed);
  for (const onnx::RivalGraph& rival : {onnx::rival_eye_graph(seed), onnx::rival_mouth_graph(seed)}) {
    PeerGraph& graph = graphs.emplace_back(PeerGraph{.onnx = rival.onnx, .inputs = {}, .expected = {}});
    Floats pictures(
        std::accumulate(rival.input.begin(), rival.input.end(), std::size_t{1}, std::multiplies()));
    for (float& v : pictures) v = static_cast<float>(random.uniform());
    graph.inputs["pictures"] = {{"dims", rival.input}, {"data", pictures}};
  }
  MIEN_TRY_ASSIGN(const PeerTimes times, measure_graphs(graphs, PeerEffort{}));
  EncoderFigures::Peers peers;
  for (std::size_t i = 0; i < ours; i += 2)
    peers.same_s += std::min(times.graphs[i].best_step_s, kViews * times.graphs[i + 1].best_step_s);
  for (std::size_t i = ours; i < graphs.size(); ++i) peers.rivals_s += times.graphs[i].best_step_s;
  return peers;
}

Result<EncoderFigures> measure(const HeadsetBench& options) {
  constexpr std::size_t kTries = 120;
  const Progress progress = app::terminal_progress("bench headset");
  const Headset headset(options.seed);
  std::vector<Encoder> encoders;
  EncoderFigures f{.peak_gflops = model::peak_gflops(), .flop = headset.flop()};
  for (const Precision precision : kPrecisions) {
    MIEN_TRY_ASSIGN(Encoder encoder, Encoder::create(headset, precision));
    encoders.push_back(std::move(encoder));
    f.precisions.push_back({.precision = precision,
                            .hot_s = measure_hot(1, kTries, [&] { encoders.back().run(); }),
                            .weight_bytes = encoders.back().weight_bytes(),
                            .hash = encoders.back().hash()});
  }
  if (options.no_peers) {
    f.why_not = "not asked for";
  } else if (const auto peers = measure_peers(headset, encoders.front(), options.seed); peers) {
    f.peers = *peers;
  } else {
    f.why_not = peers.error().message();
  }
  for (std::size_t i = 0; i < encoders.size(); ++i) {
    MeasuredEncoder& m = f.precisions[i];
    // Before the peer and behind it: a neighbour's work is to slow neither alone.
    m.hot_s = std::min(m.hot_s, measure_hot(1, kTries, [&] { encoders[i].run(); }));
    m.hot = measure_each(encoders[i]);
    MIEN_TRY_ASSIGN(m.paced, measure_paced(encoders[i], static_cast<std::size_t>(options.frames),
                                           std::string(model::precision_name(m.precision)), progress));
  }
  MIEN_TRY_ASSIGN(f.whole, measure_camera_frames(options.seed, options.frames, progress));
  MIEN_TRY_ASSIGN(f.pictures, measure_pictures(options.seed));
  app::clear_progress();
  return f;
}

app::Json as_json(const HeadsetBench& options, const Headset& headset, const EncoderFigures& f) {
  app::Json precisions = app::Json::array();
  for (const MeasuredEncoder& m : f.precisions)
    precisions.push_back(
        {{"precision", model::precision_name(m.precision)},
         {"p50_ms", 1e3 * m.paced.p50_s},
         {"p99_ms", 1e3 * m.paced.p99_s},
         {"hot_ms", 1e3 * m.hot_s},
         {"hot_p50_ms", 1e3 * m.hot.p50_s},
         {"hot_p99_ms", 1e3 * m.hot.p99_s},
         {"gflops", 1e-9 * f.flop / m.hot_s},
         {"vs_onnxruntime", f.peers ? app::Json(f.peers->same_s / m.hot_s) : app::Json(nullptr)},
         {"weight_bytes", m.weight_bytes},
         {"kernels", model::kernel_name(m.precision)},
         {"hash", m.hash}});
  app::Json json = {
      {"peak_gflops", f.peak_gflops},
      {"encoder",
       {{"views", kViews * headset.sites.size()},
        {"size", headset.shape.size},
        {"widths", headset.shape.widths},
        {"flop", f.flop},
        {"onnxruntime_ms", f.peers ? app::Json(1e3 * f.peers->same_s) : app::Json(nullptr)},
        {"precisions", precisions}}},
      {"precision", model::precision_name(f.of_session().precision)},
      {"vs_onnxruntime", f.peers ? app::Json(f.peers->same_s / f.of_session().hot_s) : app::Json(nullptr)},
      {"hash", f.of_session().hash},
      {"p50_ms", 1e3 * f.whole.whole.p50_s},
      {"p99_ms", 1e3 * f.whole.whole.p99_s},
      {"decode_ms", 1e3 * f.whole.decode_s},
      {"encode_ms", 1e3 * f.whole.encode_s},
      {"frame_ms", 1e3 * f.whole.frame_s},
      {"rivals_ms", f.peers ? app::Json(1e3 * f.peers->rivals_s) : app::Json(nullptr)},
      {"vs_rivals", f.peers ? app::Json(f.vs_rivals()) : app::Json(nullptr)},
      {"pictures_per_s", f.pictures.pictures_per_s},
      {"vs_single_rays", f.pictures.vs_single_rays},
      {"frames", options.frames},
      {"seed", options.seed}};
  if (!f.peers) json["onnxruntime"] = f.why_not;
  return json;
}

void print_headset(const Headset& headset, const EncoderFigures& f) {
  fmt::print(
      "{} views of {} x {} through two networks of {:.2f} MFLOP a view; this core's fp32 peak is {:.0f} "
      "GFLOP/s\n",
      kViews * headset.sites.size(), headset.shape.size, headset.shape.size,
      1e-6 * model::flop_count(headset.shape), f.peak_gflops);
  fmt::print("{:<6} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>14}   kernels, hash\n", "", "hot ms", "p50", "p99",
             "cold p50", "p99", "GFLOP/s", "times as quick");
  for (const MeasuredEncoder& m : f.precisions)
    fmt::print("{:<6} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.0f} {:>14}   {}, {}\n",
               model::precision_name(m.precision), 1e3 * m.hot_s, 1e3 * m.hot.p50_s, 1e3 * m.hot.p99_s,
               1e3 * m.paced.p50_s, 1e3 * m.paced.p99_s, 1e-9 * f.flop / m.hot_s,
               f.peers ? fmt::format("{:.2f}", f.peers->same_s / m.hot_s) : "?",
               model::kernel_name(m.precision), m.hash.substr(0, 16));
  if (f.peers)
    fmt::print(
        "ONNX Runtime, fp32, one thread: {:.3f} ms; networks of others' sizes for two eyes and a mouth "
        "{:.2f} ms, {:.1f} times as long as a session's, in {}\n",
        1e3 * f.peers->same_s, 1e3 * f.peers->rivals_s, f.vs_rivals(),
        model::precision_name(f.of_session().precision));
  else
    fmt::print("ONNX Runtime: {}\n", f.why_not);
  fmt::print(
      "four pictures of 240 x 240 to weights, 60 a second, caches cold: {:.3f} ms p50, {:.3f} p99; hot: "
      "{:.3f} ms "
      "to decode one, {:.3f} for the features of four, {:.3f} for the frame\n",
      1e3 * f.whole.whole.p50_s, 1e3 * f.whole.whole.p99_s, 1e3 * f.whole.decode_s, 1e3 * f.whole.encode_s,
      1e3 * f.whole.frame_s);
  fmt::print("virtual headset: {:.0f} pictures of 96 x 96 a second, {:.1f} times as quick as ray by ray\n",
             f.pictures.pictures_per_s, f.pictures.vs_single_rays);
}

}  // namespace

Result<void> run_headset_bench(const HeadsetBench& options) {
  MIEN_TRY_ASSIGN(const EncoderFigures figures, measure(options));
  const Headset headset(options.seed);
  if (options.json)
    app::print_json(as_json(options, headset, figures));
  else
    print_headset(headset, figures);
  return {};
}

}  // namespace mien::lab
