#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lab/trackers/tracker_curves.h"
#include "mien/core/one_euro.h"
#include "mien/core/random.h"
#include "mien/face/motion.h"

// Camera trackers before virtual performers. They are *modelled, not measured*: from what is published of
// each, and where nothing is, from assumptions that are called so.
namespace mien::lab {

/// Camera trackers that are modelled.
enum class TrackerKind : std::uint8_t {
  truedepth_phone,    ///< ARKit's face tracking on a phone with a depth camera, as Live Link Face tells it.
  mediapipe_webcam,   ///< MediaPipe's FaceLandmarker with its blendshapes.
  openseeface_webcam  ///< OpenSeeFace's features as shapes (openseeface_log.h).
};
inline constexpr std::size_t kTrackerKindCount = 3;

/// Where one number of a modelled tracker comes from.
struct ModelledNumber {
  std::string what;    ///< "rate", ...
  std::string value;   ///< With its unit.
  std::string source;  ///< Begins with "assumed" where nothing is published that we know of.

  [[nodiscard]] bool assumed() const { return source.starts_with("assumed"); }
};

/// A camera tracker, and how it fails.
struct ModelledTracker {
  TrackerKind kind = TrackerKind::truedepth_phone;
  std::string name;
  ToldShapes told = {};

  // The camera.
  double rate_hz = 60;
  double exposure_s = 1.0 / 60;  ///< How long a picture is exposed: what turns meanwhile is blurred.
  double dark_rate_hz = 60;      ///< The same in the dark.
  double dark_exposure_s = 1.0 / 60;
  double frames_dropped = 0;  ///< Share, 0 to 1.
  std::array<double, 2>
      lag_ms{};  ///< The face that is told is so much older than its time, uniform, drawn once.

  // What smooths: at most one of these.
  double smoothing_ms = 0;      ///< Sigma of a Gaussian over time, without lag.
  bool one_euro = false;        ///< By `filter`.
  OneEuroSettings filter = {};  ///< Of weights.
  double previous_share = 0;    ///< Of the frame before in each frame, 0 to 1 (of OpenSeeFace's features).

  // Its own error, a shape: w' = rest + (1 - rest) gain w + noise, held to 0 to 1.
  double resting_offset = 0;  ///< Sigma, upwards; none where the eyes look.
  double gain_error = 0;      ///< Sigma of the gain about 1.
  double white_noise = 0;     ///< Sigma, anew each frame.
  double slow_noise = 0;      ///< Sigma, worth what it was for about 10 s.
  ToldShapes hardly = {};     ///< Shapes that are hardly signalled, ...
  double hardly_gain = 1;     ///< ... with this gain.

  // A head that turns away from the camera: noise grows from the first angle on, beyond the second the face
  // is lost.
  double turned_worse_deg = 90, turned_lost_deg = 90;  ///< Yaw, each way.
  double pitch_lost_deg = 90;                          ///< Pitch, each way.
  double turned_noise = 0;                             ///< Sigma of the white noise at the second angle.

  // A hand before the mouth: of so many of the hands the face is lost, of the others mouth and jaw go wrong.
  double hand_lost = 0;   ///< Share, 0 to 1.
  double hand_wrong = 0;  ///< How far mouth and jaw go wrong, weights.

  // The dark.
  double dark_lost = 0;    ///< Share of the time in which the face is lost, 0 to 1, ...
  double dark_lost_s = 1;  ///< ... for so long each time, mean of an exponential.
  double dark_noise = 1;   ///< Factor of the white noise.

  // A head that turns quickly: blur is what it turns during an exposure.
  double blur_worse_deg = 90, blur_lost_deg = 90;
  double blur_noise = 0;  ///< Sigma of the white noise at the second blur.

  double losses_per_hour = 0;  ///< Losses for no such reason, half a second to four long.
  double found_after_s = 0;    ///< How long after a loss it takes to find the face again.
  double hand_sway_deg = 0;    ///< Root mean square turn of a camera that is held in the hand.

  std::vector<ModelledNumber> numbers = {};  ///< Where each of these comes from.
};

/// One a kind, in its order.
[[nodiscard]] const std::vector<ModelledTracker>& modelled_trackers();
[[nodiscard]] const ModelledTracker& modelled_tracker(TrackerKind kind);

/// A hand, or what it holds, before the mouth; s from the motion's beginning.
struct HandBefore {
  double begin_s = 0;
  double end_s = 0;
};

/// What a camera looks at.
struct TrackerScene {
  const face::Motion* motion = nullptr;  ///< With a head; valid during the call.
  std::vector<HandBefore> hands;         ///< Ascending, apart from each other.
  bool dark = false;
  /// Held in the hand before a walking person: it follows the body's heading and sways. Else it stands still
  /// before the upright face.
  bool held_in_hand = false;
};

/// Hands that come before the mouth: 1 to 3 s long, 2 to 4 s apart, drawn from the stream.
[[nodiscard]] std::vector<HandBefore> draw_hands(double seconds, Random random);
/// Hands of a meal as it is performed: from half a second before the mouth opens wide for a mouthful until it
/// is shut, and while the head leans back to drink.
[[nodiscard]] std::vector<HandBefore> eating_hands(const face::Motion& motion);

/// The curves that the tracker would tell of the scene: rows of its camera from the motion's beginning to its
/// end, on the motion's own time. Deterministic: each cause of error has a stream of its own, so that another
/// scene of the same performer meets the same tracker.
[[nodiscard]] TrackerCurves model_tracker(const ModelledTracker& tracker, const TrackerScene& scene,
                                          const Random& random);

}  // namespace mien::lab
