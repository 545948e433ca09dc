#include "mien/solve/trace_features.h"

#include <memory>
#include <string_view>
#include <utility>

#include "mien/modalities/modalities.h"
#include "mien/sensor/rig_part.h"
#include "mien/session/performed_prologue.h"
#include "mien/session/replay.h"
#include "mien/session/session.h"

namespace mien::solve {
namespace {

/// The kind of sensors that the features are of.
constexpr std::string_view kImu = "imu";

/// A session of the IMUs alone, whose tracker has no network: features are all that is wanted.
Result<std::unique_ptr<session::Session>> feature_session(const sensor::Rig& rig,
                                                          const imu::PipelineSettings& settings) {
  session::Session::Parts parts;
  parts.rig = rig;
  parts.trackers.push_back(std::make_unique<imu::ImuTracker>(sensor::part_of(rig, kImu), nullptr, settings));
  MIEN_TRY_ASSIGN(parts.protocols, modalities::make_protocols());
  return session::Session::create(std::move(parts));
}

/// A session that the take's log calibrates as it calibrated the take's own. What a guided calibration asks
/// for depends on all trackers and on what their models can learn, so it is a whole session with the default
/// models, where these are installed; a performance says itself when its steps are.
Result<std::unique_ptr<session::Session>> session_of(const take::Take& take) {
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  if (!traced_sensor_names(take.rig()).empty() && !session::performed_prologue(events))
    if (const auto model = modalities::live_model(take.rig(), ""))
      if (auto session = modalities::make_session(take.rig(), *model)) return session;
  return feature_session(take.rig(), imu::ImuTracker::live_settings());
}

/// Gathers the features of each frame of a replay.
session::Seen gather(const session::Session& session, std::vector<model::FeatureFrame>& frames) {
  return [&](const take::Tick&, const face::OutputFrame&) {
    frames.push_back(*session.features());
    return true;
  };
}

}  // namespace

Result<std::vector<model::FeatureFrame>> trace_features(const sensor::Rig& rig,
                                                        std::span<const take::Event> events,
                                                        std::span<const take::LogEntry> entries,
                                                        std::span<const take::Tick> ticks,
                                                        const imu::PipelineSettings& settings) {
  MIEN_TRY_ASSIGN(const auto session, feature_session(rig, settings));
  std::vector<model::FeatureFrame> frames;
  frames.reserve(ticks.size());
  session::replay(events, entries, ticks, *session, gather(*session, frames));
  return frames;
}

Result<std::vector<model::FeatureFrame>> take_features(const take::Take& take) {
  MIEN_TRY_ASSIGN(const auto session, session_of(take));
  std::vector<model::FeatureFrame> frames;
  MIEN_TRY(session::replay(take, *session, gather(*session, frames)));
  return frames;
}

std::vector<std::string> traced_sensor_names(const sensor::Rig& rig) {
  return sensor::part_of(rig, kImu).face_sensor_names();
}

}  // namespace mien::solve
