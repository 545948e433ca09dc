// How does a model of one's own answer in a session? One that reads the jaw from how far the chin's skin has
// turned, behind Mien's clocks, fusion and calibration; beside it what a virtual performer really did.
// (Trained models need no code: they are files, which `mien train` writes; docs/reference/model_file.md.)

#include <fmt/format.h>

#include <algorithm>

#include "mien/core/files.h"
#include "mien/imu/imu_tracker.h"
#include "mien/modalities/modalities.h"
#include "mien/session/session.h"
#include "mien/virtual/stage.h"

namespace {
using namespace mien;

constexpr std::size_t kJaw = face::shape("jawOpen");

/// What the skin did at a frame in, an answer out: 60 times a second, with nothing of the future.
struct JawFromChin final : tracker::FrameModel {
  explicit JawFromChin(std::size_t place) : chin(place) {}
  void step(const model::FeatureFrame& features, face::OutputFrame& out) override {
    out = {.time = features.time, .head = features.head};
    out.provenance.fill(face::Provenance::neutral);
    const model::SensorFeature& skin = features.sensors[chin];
    if (!skin.has_rotation) return;  // Not received: neutral, and nothing to be sure of.
    // A small turn about X, rad, from the quaternion. Both numbers are fitted to this performer (r = 0.72),
    // whose lips turn the chin too: a model that is worth something listens to all sensors.
    out.weights[kJaw] = std::clamp(2.6F * (2 * skin.rotation[1] + 0.08F), 0.0F, 1.0F);
    out.confidence[kJaw] = 1;
    out.provenance[kJaw] = face::Provenance::measured;
  }
  void reset() override {}  // It remembers nothing.
  std::size_t chin;
};

Result<void> run() {
  virt::StageRequest request;  // Somebody reads aloud, after what calibrates a session.
  request.script = performer::default_script(performer::Block::reading, 6);
  MIEN_TRY_ASSIGN(request.rig, find_resource("rigs/default.toml"));
  MIEN_TRY_ASSIGN(const virt::Stage stage, virt::set_stage(request));
  MIEN_TRY_ASSIGN(const virt::VirtualSession performed, virt::play(stage));

  session::Session::Parts parts;
  parts.rig = stage.rig;
  const auto names = stage.rig.face_sensor_names();
  const auto chin = static_cast<std::size_t>(std::ranges::find(names, "mentalis") - names.begin());
  parts.trackers.push_back(std::make_unique<imu::ImuTracker>(stage.rig, std::make_unique<JawFromChin>(chin)));
  MIEN_TRY_ASSIGN(parts.protocols, modalities::make_protocols());
  MIEN_TRY_ASSIGN(const auto session, session::Session::create(std::move(parts)));

  auto truth = performed.truth.begin();
  for (const take::LogEntry& entry : performed.entries) {
    const auto fire = [&] {
      while (const auto due = session->due(entry.arrival)) {
        const face::OutputFrame& frame = session->tick(due->frame, due->fired);
        while (truth != performed.truth.end() && truth->time < frame.time) ++truth;
        if (truth == performed.truth.end() || !truth->evaluated || due->index % 6 != 0) continue;
        fmt::print("{:.1f} s  jawOpen {:.2f}, truly {:.2f}\n", to_seconds(frame.time.time_since_epoch()),
                   frame.weights[kJaw], truth->weights[kJaw]);
      }
    };
    fire();  // Before it and after it: what is due does not wait for a datagram.
    static_cast<void>(session->receive(entry.arrival, 0, entry.bytes));
    fire();
  }
  return {};
}
}  // namespace

int main() {
  const auto done = run();
  if (!done) fmt::print(stderr, "{}\n", done.error().message());
  return done ? 0 : 1;
}
