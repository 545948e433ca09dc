#include "lab/bench/bench_camera_frames.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "lab/bench/clock.h"
#include "mien/core/files.h"
#include "mien/face/face.h"
#include "mien/headset/feature_record.h"
#include "mien/headset/feature_reducer.h"
#include "mien/headset/headset_tracker.h"
#include "mien/headset/picture_decoder.h"
#include "mien/render/jpeg.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/payload.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/headset/headset_simulator.h"

namespace mien::lab {
namespace {

using Bytes = std::vector<std::byte>;

/// Moments of a moving face, pictures of all cameras each.
constexpr int kMoments = 12;
constexpr int kJpegQuality = 80;
constexpr auto kInterval = std::chrono::nanoseconds(16'666'667);

Result<std::vector<std::vector<Bytes>>> render_pictures(const sensor::Rig& rig, std::uint64_t seed) {
  MIEN_TRY_ASSIGN(const virt::HeadsetFaults faults, virt::parse_headset_faults(rig.faults_toml, rig.name));
  MIEN_TRY_ASSIGN(const virt::HeadsetWearer wearer, virt::draw_headset_wearer(rig, faults, Random(seed)));
  virt::HeadsetSimulator simulator(wearer, faults, Random(seed));
  std::vector<std::vector<std::uint8_t>> pixels;
  std::vector<std::span<std::uint8_t>> out;
  for (std::size_t c = 0; c < simulator.cameras(); ++c)
    pixels.emplace_back(static_cast<std::size_t>(simulator.size(c).width) *
                        static_cast<std::size_t>(simulator.size(c).height));
  for (auto& picture : pixels) out.emplace_back(picture);
  std::vector<std::vector<Bytes>> moments;
  for (int m = 0; m < kMoments; ++m) {
    virt::HeadsetPose pose;
    pose.weights[face::shape("jawOpen")] = 0.06F * static_cast<float>(m);
    simulator.shoot(m / kFrameRateHz, pose, pose, out);
    auto& pictures = moments.emplace_back();
    for (std::size_t c = 0; c < pixels.size(); ++c) {
      MIEN_TRY_ASSIGN(Bytes jpeg, render::encode_jpeg(simulator.size(c).width, simulator.size(c).height,
                                                      render::JpegPixels::grey, kJpegQuality, pixels[c]));
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

}  // namespace

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

  OtherProgram other;
  std::vector<double> took;
  auto next = Clock::now();
  for (int f = 0; f < frames; ++f) {
    other.read();
    // A frame that the machine kept from us does not make the next one hurry.
    next = std::max(next + kInterval, Clock::now());
    std::this_thread::sleep_until(next);
    const auto from = Clock::now();
    worn.encode(next_moment());
    worn.answer();
    took.push_back(seconds_since(from));
    if (!progress(static_cast<double>(f + 1) / frames, "pictures to weights at 60 a second, caches cold"))
      return fail(ErrorCode::cancelled, "stopped before it was done", "bench headset");
  }
  figures.whole = spread_of(std::move(took));
  return figures;
}

}  // namespace mien::lab
