#include "lab/headset/seen_film.h"

#include "mien/headset/feature_record.h"
#include "mien/headset/network_view.h"
#include "mien/headset/picture_statistics.h"
#include "mien/model/views_network.h"
#include "mien/performer/gaze_points.h"
#include "mien/synthetic/headset/headset_dataset.h"

namespace mien::lab {
namespace {

/// Shorter than a session asks for (session::Guide), since each frame is rendered; who performs it reads
/// nothing.
constexpr double kEach_s = 1.5, kRestsFrom_s = 0.7;
static_assert(kEach_s * 5 == kTaughtGaze_s);

}  // namespace

Result<SeenFilm> look_at(const std::vector<synthetic::FilmFrame>& frames, const sensor::Rig& rig,
                         const headset::HeadsetModel& model) {
  const model::ViewsNetwork& network = model.network();
  const auto side = static_cast<int>(network.architecture().side);
  model::ViewsNetwork::Workspace memory(network);
  MIEN_TRY_ASSIGN(const std::vector<headset::HeadsetCamera> cameras,
                  synthetic::film_cameras(rig, network.architecture().side));
  SeenFilm seen;
  std::vector<float> view(network.architecture().side * network.architecture().side),
      features(network.architecture().features);
  for (const synthetic::FilmFrame& frame : frames) {
    seen.truth.push_back(frame.truth);
    auto& records = seen.records.emplace_back(rig.sensors.size());
    for (const headset::HeadsetCamera& camera : cameras) {
      const headset::GreyPicture picture{.width = side, .height = side, .pixels = frame.views[camera.sensor]};
      auto shown = headset::NetworkView::create(camera.view);
      shown->make(picture, view);
      network.find_one(camera.place, view, memory, features);
      const headset::FeatureRecord record{.statistics = headset::statistics_of(picture),
                                          .jpeg_bytes = 1,
                                          .sensor = camera.sensor,
                                          .features = {}};
      auto& bytes = records[camera.sensor];
      bytes.resize(headset::feature_record_bytes(features.size()));
      if (!headset::write_feature_record(record, features, bytes))
        return fail(ErrorCode::internal, "features that no record takes", camera.name);
    }
  }
  return seen;
}

void deliver(const std::vector<std::vector<std::byte>>& records, DeviceTime now, const sensor::Rig& rig,
             const CameraArrives& arrives, sensor::TimeLines& lines, tracker::Tracker& tracker) {
  for (std::size_t c = 0; c < rig.sensors.size(); ++c) {
    if (arrives && !arrives(c)) continue;
    sensor::Sample sample;
    sample.sensor = static_cast<std::uint16_t>(c);
    sample.kind = sensor::SampleKind::picture;
    sample.time = now + from_seconds(5e-4 * rig.sensors[c].camera->exposure_ms);
    const HostTime arrival(sample.time.time_since_epoch());
    lines.add(arrival, sample);
    tracker.add_with_payload(arrival, sample, records[c]);
  }
}

face::Motion gaze_targets_motion(const Random& random) {
  face::Motion motion;
  motion.name = "gaze targets";
  for (const face::BlendshapeWeights& weights :
       performer::look_at_targets(face::gaze_targets(), kEach_s, random)) {
    face::MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = to_seconds(frame_offset(static_cast<std::int64_t>(motion.frames.size()) - 1));
    frame.weights = weights;
  }
  return motion;
}

void guide_gaze_targets(DeviceTime begin, tracker::Tracker& tracker) {
  for (const face::GazeTarget& target : face::gaze_targets()) {
    const DeviceTime end = begin + from_seconds(kEach_s);
    tracker.guide_gaze(target, begin + from_seconds(kRestsFrom_s), end);
    begin = end;
  }
}

}  // namespace mien::lab
