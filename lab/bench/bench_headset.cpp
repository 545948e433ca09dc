#include "lab/bench/benchmarks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/json_output.h"
#include "lab/bench/clock.h"
#include "lab/bench/onnx_peer.h"
#include "lab/bench/rival_graphs.h"
#include "lab/commands/output.h"
#include "lab/peak.h"
#include "mien/core/error.h"
#include "mien/core/files.h"
#include "mien/core/progress.h"
#include "mien/core/random.h"
#include "mien/core/sha256.h"
#include "mien/face/face.h"
#include "mien/headset/feature_record.h"
#include "mien/headset/feature_reducer.h"
#include "mien/headset/headset_model.h"
#include "mien/headset/headset_tracker.h"
#include "mien/headset/picture_decoder.h"
#include "mien/model/backbone.h"
#include "mien/onnx/export_model.h"
#include "mien/render/image.h"
#include "mien/render/infrared_scene.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/payload.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/headset/headset_simulator.h"

namespace mien::lab {
namespace {

/// Room for one grey picture of each camera of a simulator, which it shoots into.
struct CameraPictures {
  explicit CameraPictures(const virt::HeadsetSimulator& simulator) {
    for (std::size_t c = 0; c < simulator.cameras(); ++c)
      pixels.emplace_back(static_cast<std::size_t>(simulator.size(c).width) *
                          static_cast<std::size_t>(simulator.size(c).height));
    for (auto& picture : pixels) out.emplace_back(picture);
  }
  std::vector<std::vector<std::uint8_t>> pixels;
  std::vector<std::span<std::uint8_t>> out;  ///< Of `pixels`.
};

/// What `mien bench headset` is asked.
struct HeadsetBench {
  int frames = 600;
  std::uint64_t seed = 1;  ///< Of the networks' weights and of the pictures.
  bool no_peers = false;   ///< ONNX Runtime is not run.
  Output to;
};

/// What a headset's frame costs one thread, from four pictures of 240 x 240 as boards send them to weights:
/// sixty frames a second, with cold caches.
struct CameraFrameFigures {
  Spread whole;         ///< Decoding, features, and the tracker's frame.
  double decode_s = 0;  ///< Of a picture, hot; the smallest of rounds' medians, as all below.
  double encode_s = 0;  ///< Four pictures to features, decoding included.
  double frame_s = 0;   ///< The tracker's part: features to weights.
};

using Bytes = std::vector<std::byte>;

/// Moments of a moving face, pictures of all cameras each.
constexpr int kMoments = 12;
constexpr int kJpegQuality = 80;

Result<std::vector<std::vector<Bytes>>> render_pictures(const sensor::Rig& rig, std::uint64_t seed) {
  MIEN_TRY_ASSIGN(const virt::HeadsetFaults faults, virt::parse_headset_faults(rig.faults_toml, rig.name));
  MIEN_TRY_ASSIGN(const virt::HeadsetWearer wearer, virt::draw_headset_wearer(rig, faults, Random(seed)));
  virt::HeadsetSimulator simulator(wearer, faults, Random(seed));
  CameraPictures views(simulator);
  std::vector<std::vector<Bytes>> moments;
  for (int m = 0; m < kMoments; ++m) {
    virt::HeadsetPose pose;
    pose.weights[face::shape("jawOpen")] = 0.06F * static_cast<float>(m);
    simulator.shoot(m / kFrameRateHz, pose, pose, views.out);
    auto& pictures = moments.emplace_back();
    for (std::size_t c = 0; c < views.pixels.size(); ++c) {
      MIEN_TRY_ASSIGN(Bytes jpeg,
                      render::encode_jpeg(simulator.size(c).width, simulator.size(c).height,
                                          render::JpegPixels::grey, kJpegQuality, views.pixels[c]));
      pictures.push_back(std::move(jpeg));
    }
  }
  return moments;
}

/// A headset that is worn: what a session does with its pictures.
class Worn {
 public:
  static Result<Worn> create(const sensor::Rig& rig, std::shared_ptr<const headset::HeadsetModel> model) {
    MIEN_TRY_ASSIGN(headset::FeatureReducer reducer, headset::FeatureReducer::create(rig, model));
    MIEN_TRY_ASSIGN(auto tracker, headset::HeadsetTracker::create(rig, std::move(model)));
    return Worn(std::move(reducer), std::move(tracker), rig.sensors.size());
  }

  void encode(const std::vector<Bytes>& pictures) {
    for (std::size_t c = 0; c < pictures.size(); ++c)
      lengths_[c] =
          reducer_.reduce_picture(static_cast<std::uint16_t>(c), pictures[c], records_[c]).value_or(0);
  }
  void answer() {
    const DeviceTime now(frame_offset(number_++));
    for (std::size_t c = 0; c < records_.size(); ++c) {
      sensor::Sample sample;
      sample.sensor = static_cast<std::uint16_t>(c);
      sample.kind = sensor::SampleKind::picture;
      sample.time = now;
      const HostTime arrival(now.time_since_epoch());
      lines_.add(arrival, sample);
      tracker_->add_with_payload(arrival, sample, std::span(records_[c]).first(lengths_[c]));
    }
    tracker_->tick(now, lines_, frame_);
  }

 private:
  Worn(headset::FeatureReducer reducer, std::unique_ptr<headset::HeadsetTracker> tracker, std::size_t cameras)
      : reducer_(std::move(reducer)),
        tracker_(std::move(tracker)),
        lines_(cameras, std::uint16_t{0}),
        records_(cameras, Bytes(sensor::kMaxPayload)),
        lengths_(cameras) {}

  headset::FeatureReducer reducer_;
  std::unique_ptr<headset::HeadsetTracker> tracker_;
  sensor::TimeLines lines_;
  std::vector<Bytes> records_;
  std::vector<std::size_t> lengths_;
  std::int64_t number_ = 0;
  face::OutputFrame frame_;
};

/// By the default model and rig. Errors: those of model, rig and wearer; cancelled.
Result<CameraFrameFigures> measure_camera_frames(std::uint64_t seed, int frames, const Progress& progress) {
  constexpr std::size_t kTries = 60;
  MIEN_TRY_ASSIGN(const std::filesystem::path rig_path, find_resource("rigs/headset.toml"));
  MIEN_TRY_ASSIGN(const std::filesystem::path model_path, find_resource("models/headset.safetensors"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(rig_path));
  MIEN_TRY_ASSIGN(const headset::ViewsFile file, headset::read_views_file(model_path));
  MIEN_TRY_ASSIGN(const auto model, headset::HeadsetModel::create(file));
  MIEN_TRY_ASSIGN(const std::vector<std::vector<Bytes>> moments, render_pictures(rig, seed));
  MIEN_TRY_ASSIGN(Worn worn, Worn::create(rig, model));
  MIEN_TRY_ASSIGN(headset::PictureDecoder decoder, headset::PictureDecoder::create());
  std::size_t number = 0;
  const auto next_moment = [&]() -> const std::vector<Bytes>& { return moments[number++ % moments.size()]; };

  CameraFrameFigures figures;
  bool decodes = true;
  const auto [width, height] = rig.sensors.front().camera->size;
  figures.decode_s = measure_hot(1, kTries, [&] {
    decodes = decodes && decoder.decode(next_moment().front(), width, height).has_value();
  });
  if (!decodes)
    return fail(ErrorCode::internal, "a picture of the simulator does not decode", "bench headset");
  figures.encode_s = measure_hot(1, kTries, [&] { worn.encode(next_moment()); });
  // Of other pictures each time: those that stand still are taken for lost.
  std::vector<double> answers(kTries);
  for (double& one : answers) {
    worn.encode(next_moment());
    const auto from = Clock::now();
    worn.answer();
    one = seconds_since(from);
  }
  figures.frame_s = spread_of(std::move(answers)).p50_s;

  MIEN_TRY_ASSIGN(std::vector<double> took,
                  measure_sixty_hz(static_cast<std::size_t>(frames), "bench headset", "pictures to weights",
                                   progress, [&](std::size_t) {
                                     worn.encode(next_moment());
                                     worn.answer();
                                   }));
  figures.whole = spread_of(std::move(took));
  return figures;
}

/// How quickly a virtual headset's pictures are made, on one thread: views of 96 x 96 pixels at four samples
/// a pixel.
struct PictureFigures {
  double pictures_per_s = 0;  ///< Of a moving face, everything included: pose, light, views, lens and sensor.
  /// How many times as quick a view is drawn as by a ray through each sample, one after the other; light and
  /// shading alike.
  double vs_single_rays = 0;
};

constexpr int kSide = 96;
constexpr int kPictureRounds = 5, kDrawnMoments = 8;

double pictures_per_s(const virt::HeadsetWearer& wearer, const virt::HeadsetFaults& faults,
                      std::uint64_t seed) {
  virt::HeadsetSimulator simulator(wearer, faults, Random(seed), kSide);
  CameraPictures views(simulator);
  double best_s = std::numeric_limits<double>::max(), time_s = 0;
  const auto open = [](int moment) {
    virt::HeadsetPose pose;
    pose.weights[face::shape("jawOpen")] = 0.05F * static_cast<float>(moment % kDrawnMoments);
    return pose;
  };
  for (int round = 0; round < kPictureRounds; ++round) {
    const auto from = Clock::now();
    for (int m = 0; m < kDrawnMoments; ++m, time_s += 1.0 / 30)
      simulator.shoot(time_s, open(m), open(m + 1), views.out);
    best_s = std::min(best_s, seconds_since(from));
  }
  return kDrawnMoments * static_cast<double>(simulator.cameras()) / best_s;
}

double vs_single_rays(const virt::HeadsetWearer& wearer) {
  std::vector<Vec3f> places_m;
  std::vector<render::Lens> lenses;
  for (const virt::FittedCamera& camera : wearer.cameras) {
    places_m.push_back(camera.position_m);
    lenses.push_back(render::make_lens(camera.position_m, camera.look_at_m, camera.up,
                                       camera.field_of_view_rad, camera.radial_k1, kSide, kSide));
  }
  render::InfraredScene scene(wearer.face, wearer.looks, places_m);
  scene.pose(wearer.face.neutral_m, wearer.face.neutral_m, wearer.things_m);
  scene.light(wearer.lamps, 0, lenses);
  render::InfraredScene::Canvas canvas;
  std::vector<float> picture(std::size_t{kSide} * kSide);
  double drawn_s = std::numeric_limits<double>::max(), traced_s = drawn_s;
  for (int round = 0; round < kPictureRounds; ++round) {
    auto from = Clock::now();
    for (const render::Lens& lens : lenses) scene.draw(lens, 0, canvas, picture);
    drawn_s = std::min(drawn_s, seconds_since(from));
    from = Clock::now();
    for (const render::Lens& lens : lenses) scene.draw_by_rays(lens, picture);
    traced_s = std::min(traced_s, seconds_since(from));
  }
  return traced_s / drawn_s;
}

/// Errors: those of the default headset rig and its wearer.
Result<PictureFigures> measure_pictures(std::uint64_t seed) {
  MIEN_TRY_ASSIGN(const auto path, find_resource("rigs/headset.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(path));
  MIEN_TRY_ASSIGN(const virt::HeadsetFaults faults, virt::parse_headset_faults(rig.faults_toml, rig.name));
  MIEN_TRY_ASSIGN(const virt::HeadsetWearer wearer,
                  virt::draw_headset_wearer(rig, faults, Random(seed).fork("bench")));
  return PictureFigures{.pictures_per_s = pictures_per_s(wearer, faults, seed),
                        .vs_single_rays = vs_single_rays(wearer)};
}

using Floats = std::vector<float>;
using Weights = std::vector<model::Tensor>;
using model::Precision;

constexpr Precision kPrecisions[] = {Precision::fp32, Precision::bf16, Precision::int8};
/// Views that share a network: two eyes, or a mouth's two.
constexpr std::size_t kViews = 2;

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
  for (const RivalGraph& rival : {rival_eye_graph(seed), rival_mouth_graph(seed)}) {
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
  EncoderFigures f{.peak_gflops = peak_gflops(), .flop = headset.flop()};
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
    MIEN_TRY_ASSIGN(std::vector<double> took,
                    measure_sixty_hz(static_cast<std::size_t>(options.frames), "bench headset",
                                     std::string(model::precision_name(m.precision)), progress,
                                     [&](std::size_t) { encoders[i].run(); }));
    m.paced = spread_of(std::move(took));
  }
  MIEN_TRY_ASSIGN(f.whole, measure_camera_frames(options.seed, options.frames, progress));
  MIEN_TRY_ASSIGN(f.pictures, measure_pictures(options.seed));
  app::clear_progress();
  return f;
}

Columns<MeasuredEncoder> encoder_columns(const EncoderFigures& f) {
  using Measured = MeasuredEncoder;
  const auto ms = [](Spread Measured::*spread, double Spread::*at) {
    return [=](const Measured& m) { return 1e3 * (m.*spread.*at); };
  };
  return {{"precision", "", "{}", [](const Measured& m) { return model::precision_name(m.precision); }},
          {"p50_ms", "cold p50, ms", "{:.3f}", ms(&Measured::paced, &Spread::p50_s)},
          {"p99_ms", "p99", "{:.3f}", ms(&Measured::paced, &Spread::p99_s)},
          {"hot_ms", "hot, ms", "{:.3f}", [](const Measured& m) { return 1e3 * m.hot_s; }},
          {"hot_p50_ms", "p50", "{:.3f}", ms(&Measured::hot, &Spread::p50_s)},
          {"hot_p99_ms", "p99", "{:.3f}", ms(&Measured::hot, &Spread::p99_s)},
          {"gflops", "GFLOP/s", "{:.0f}", [&f](const Measured& m) { return 1e-9 * f.flop / m.hot_s; }},
          {"vs_onnxruntime", "times as quick", "{:.2f}",
           [&f](const Measured& m) { return f.peers ? app::Json(f.peers->same_s / m.hot_s) : app::Json(); }},
          {"weight_bytes", "", "", &Measured::weight_bytes},
          {"kernels", "kernels", "{}", [](const Measured& m) { return model::kernel_name(m.precision); }},
          {"hash", "hash", "{:.16}", &Measured::hash}};
}

app::Json as_json(const HeadsetBench& options, const Headset& headset, const EncoderFigures& f) {
  app::Json json = {
      {"peak_gflops", f.peak_gflops},
      {"encoder",
       {{"views", kViews * headset.sites.size()},
        {"size", headset.shape.size},
        {"widths", headset.shape.widths},
        {"flop", f.flop},
        {"onnxruntime_ms", f.peers ? app::Json(1e3 * f.peers->same_s) : app::Json(nullptr)},
        {"precisions", json_of(f.precisions, encoder_columns(f))}}},
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

measure::Report report_of(const Headset& headset, const EncoderFigures& f) {
  measure::Report report("A headset's pictures on their way to weights");
  report.table(table_of(
      fmt::format("{} views of {} x {} through two networks of {:.2f} MFLOP a view; this core's fp32 peak is "
                  "{:.0f} GFLOP/s",
                  kViews * headset.sites.size(), headset.shape.size, headset.shape.size,
                  1e-6 * model::flop_count(headset.shape), f.peak_gflops),
      f.precisions, encoder_columns(f)));
  report.text(f.peers
                  ? fmt::format("ONNX Runtime, fp32, one thread: {:.3f} ms; networks of others' sizes for "
                                "two eyes and a mouth {:.2f} ms, {:.1f} times as long as a session's, in {}",
                                1e3 * f.peers->same_s, 1e3 * f.peers->rivals_s, f.vs_rivals(),
                                model::precision_name(f.of_session().precision))
                  : "ONNX Runtime: " + f.why_not);
  report.text(fmt::format(
      "four pictures of 240 x 240 to weights, 60 a second, caches cold: {:.3f} ms p50, {:.3f} p99; hot: "
      "{:.3f} ms to decode one, {:.3f} for the features of four, {:.3f} for the frame",
      1e3 * f.whole.whole.p50_s, 1e3 * f.whole.whole.p99_s, 1e3 * f.whole.decode_s, 1e3 * f.whole.encode_s,
      1e3 * f.whole.frame_s));
  report.text(
      fmt::format("virtual headset: {:.0f} pictures of 96 x 96 a second, {:.1f} times as quick as ray "
                  "by ray",
                  f.pictures.pictures_per_s, f.pictures.vs_single_rays));
  return report;
}

/// Measures what a headset's four views cost on their way through the networks of pictures, in each
/// precision: paced with cold caches and in a hot loop, beside ONNX Runtime and what the core can do at most,
/// in the same run. Prints it. Errors: cancelled.
Result<void> run_headset_bench(const HeadsetBench& options) {
  MIEN_TRY_ASSIGN(const EncoderFigures figures, measure(options));
  const Headset headset(options.seed);
  return put_out(options.to, report_of(headset, figures), as_json(options, headset, figures));
}

}  // namespace

void add_headset_bench(app::Commands& commands, app::Command bench) {
  auto headset = std::make_shared<HeadsetBench>();
  const app::Command cameras =
      commands.add_under(bench, "headset",
                         "A headset's four views of 96 x 96 pixels through the networks of pictures, with "
                         "random weights, in each "
                         "precision: paced at 60 a second with cold caches and in a hot loop, beside ONNX "
                         "Runtime and the core's "
                         "measured peak",
                         "mien bench headset --json", [headset] { return run_headset_bench(*headset); });
  cameras.add_option("--frames", headset->frames, "Paced frames of a 60th of a second, in each precision")
      .in_range(1, 1'000'000)
      .show_default();
  cameras.add_option("--seed", headset->seed, "Of the weights and the pictures").show_default();
  cameras.add_flag("--no-peers", headset->no_peers, "Do not run ONNX Runtime beside it");
  app::add_json_flag(cameras, headset->to.json);
}

}  // namespace mien::lab
