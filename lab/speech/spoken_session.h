#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/face/face.h"
#include "mien/face/output_frame.h"
#include "mien/sensor/rig.h"
#include "mien/speech/speech_network.h"
#include "mien/synthetic/speech/spoken_passage.h"
#include "mien/virtual/session.h"

// Somebody speaks with sensors on the face and a microphone before it: what a session shows of that while
// sensors come and go.
namespace mien::lab {

/// What is worn.
struct SpokenScene {
  sensor::Rig rig;  ///< Sensors of one kind, "imu" or "eyewear".
  std::filesystem::path model;
  speech::SpeechNetworkFile network;
};
/// Errors: bad_usage (a rig of several kinds, or of another one).
[[nodiscard]] Result<void> check_scene(const SpokenScene& scene);

/// The performance as the rig's devices feel it, after a brief prologue; a motion without a head gets the
/// default one. Streams: "head", "prologue", "devices", of glasses "wearer", "glasses". Errors: the devices'.
[[nodiscard]] Result<virt::VirtualSession> feel(const sensor::Rig& rig, const face::Face& face,
                                                face::Motion motion, const Random& root);

struct SpokenSession {
  const SpokenScene& scene;
  const synthetic::SpokenPassage& passage;
  const virt::VirtualSession& felt;  ///< feel(), of the passage's face.
  /// By which the microphone hears later than the face moves; below 0: earlier.
  Duration lag{};
  /// Whether nothing comes from any sensor at that frame; empty: never.
  std::function<bool(DeviceTime)> is_lost = {};
};

/// What is heard of the microphone.
enum class Hearing : std::uint8_t {
  off,          ///< Nothing.
  as_it_comes,  ///< Its sound at the frame's own time, whatever lag is found.
  retimed,      ///< As sessions have it: at the time that belongs to the face.
};

/// What a session shows, one of all a tick.
struct ShownSession {
  std::vector<face::OutputFrame> frames;
  /// What shaping::Retiming had found by then: an offset, obeyed or not, and whether it believed in a lag.
  std::vector<Duration> offset;
  std::vector<bool> believed;
};
/// By shaping::CombinedTracker and shaping::Shaper with their defaults, of clean sound. Errors: the model's,
/// the network's.
[[nodiscard]] Result<ShownSession> show(const SpokenSession& session, Hearing hearing);

}  // namespace mien::lab
