#include "mien/solve/trace_features.h"

#include <string_view>

#include "mien/modalities/modalities.h"
#include "mien/sensor/rig_part.h"
#include "mien/session/replay.h"

namespace mien::solve {
namespace {

/// The kind of sensors that the pipeline is of.
constexpr std::string_view kImu = "imu";

/// Hands samples to a pipeline.
class Feed final : public session::SampleConsumer {
 public:
  explicit Feed(imu::Pipeline& pipeline) : pipeline_(pipeline) {}
  void add(HostTime, const sensor::Sample& sample) override { pipeline_.add(sample); }
  void rebound(std::uint16_t sensor, const sensor::DeviceKey&, bool) override { pipeline_.forget(sensor); }

 private:
  imu::Pipeline& pipeline_;
};

/// `replay(receiver, consumer, ticked)` is one of session::replay_samples().
template <class Replay>
Result<std::vector<model::FeatureFrame>> trace(const sensor::Rig& rig, std::span<const take::Event> events,
                                               std::size_t ticks, const imu::PipelineSettings& settings,
                                               imu::Calibration* calibration, const Replay& replay) {
  MIEN_TRY_ASSIGN(auto protocols, modalities::make_protocols());
  MIEN_TRY_ASSIGN(const auto receiver, session::Receiver::create(rig, std::move(protocols)));
  imu::Pipeline pipeline(sensor::part_of(rig, kImu), settings);
  for (const take::Event& event : events)
    if (const auto phase = imu::phase_of(event.kind)) pipeline.mark(*phase, event.begin, event.end);
  Feed feed(pipeline);
  std::vector<model::FeatureFrame> frames;
  frames.reserve(ticks);
  const auto ticked = [&](const take::Tick& tick) {
    pipeline.tick(tick.frame, receiver->lines(), frames.emplace_back());
    return true;
  };
  MIEN_TRY(replay(*receiver, feed, ticked));
  if (calibration != nullptr) *calibration = pipeline.calibration();
  return frames;
}

}  // namespace

Result<std::vector<model::FeatureFrame>> trace_features(
    const sensor::Rig& rig, std::span<const take::Event> events, std::span<const take::LogEntry> entries,
    std::span<const take::Tick> ticks, const imu::PipelineSettings& settings, imu::Calibration* calibration) {
  return trace(rig, events, ticks.size(), settings, calibration,
               [&](session::Receiver& receiver, Feed& feed, const auto& ticked) -> Result<bool> {
                 return session::replay_samples(entries, ticks, receiver, feed, ticked);
               });
}

Result<std::vector<model::FeatureFrame>> take_features(const take::Take& take) {
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  if (ticks.empty())
    return fail(ErrorCode::not_found, "the take has no frames", take.path().string(),
                "record or perform it again");
  return trace(take.rig(), events, ticks.size(), {}, nullptr,
               [&](session::Receiver& receiver, Feed& feed, const auto& ticked) {
                 return session::replay_samples(take, ticks, receiver, feed, ticked);
               });
}

std::vector<std::string> traced_sensor_names(const sensor::Rig& rig) {
  return sensor::part_of(rig, kImu).face_sensor_names();
}

}  // namespace mien::solve
