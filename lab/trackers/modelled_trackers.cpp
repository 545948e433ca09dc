// Which camera trackers are modelled, and where every number comes from.
#include <fmt/format.h>

#include <initializer_list>
#include <utility>

#include "lab/trackers/modelled_tracker.h"
#include "lab/trackers/openseeface_log.h"
#include "mien/virtual/phone/phone_faults.h"

namespace mien::lab {
namespace {

/// Notes where the numbers come from as they are set.
class NumberNotes {
 public:
  explicit NumberNotes(ModelledTracker& tracker) : tracker_(tracker) {}

  void set(double& number, double value, const char* what, const char* unit, std::string source) {
    number = value;
    note(what, fmt::format("{:.3g}{}", value, unit), std::move(source));
  }
  void note(std::string what, std::string value, std::string source) {
    tracker_.numbers.push_back({std::move(what), std::move(value), std::move(source)});
  }

 private:
  ModelledTracker& tracker_;
};

ToldShapes named_shapes(std::initializer_list<std::size_t> shapes) {
  ToldShapes out;
  for (const std::size_t k : shapes) out.set(k);
  return out;
}

ModelledTracker truedepth_phone() {
  const virt::PhoneFaults phone = virt::usual_phone();
  ModelledTracker t{.kind = TrackerKind::truedepth_phone, .name = "phone (ARKit)", .told = {}};
  t.told.set();
  NumberNotes is(t);
  const std::string ours = "mien/virtual/phone/phone_faults.h: ";
  is.set(t.rate_hz, phone.rate_hz, "frames a second", "",
         "recordings of Live Link Face have 60 rows a second");
  is.set(t.exposure_s, 1.0 / 60, "exposure", " s", "assumed: indoors, as long as a frame");
  is.set(t.dark_rate_hz, phone.rate_hz, "frames a second in the dark", "",
         "assumed: its infrared light does not need the room's");
  is.set(t.dark_exposure_s, 1.0 / 60, "exposure in the dark", " s", "assumed: likewise");
  is.set(t.frames_dropped, phone.frames_dropped, "share of frames dropped", "",
         ours + "six of 186 frames of a captured stream are missing");
  t.lag_ms = phone.lag_ms;
  is.note("lag", fmt::format("{:g} to {:g} ms", t.lag_ms[0], t.lag_ms[1]),
          "assumed: one to two frames; times are the frame's, so the network counts on neither side");
  is.set(t.smoothing_ms, phone.smoothing_ms, "smoothing, sigma", " ms", "assumed");
  is.set(t.resting_offset, phone.resting_offset, "weight of a face at rest, sigma", "",
         ours + "measured on two recorded people");
  is.set(t.gain_error, phone.gain_error, "gain of a shape, sigma about 1", "", "assumed");
  is.set(t.slow_noise, phone.noise, "slow noise, sigma", "", ours + "measured on a recorded person at rest");
  is.set(t.white_noise, 0.0017, "noise of a frame, sigma", "",
         ours + "a weight's standard deviation in a recorded person's quietest seconds");
  is.set(t.turned_worse_deg, 40, "yaw from which it gets worse", " degrees", "assumed");
  is.set(t.turned_lost_deg, 60, "yaw at which the face is lost", " degrees",
         "assumed: that it is lost from the side is reported (worthdoingbadly.com/memoji2), no angle is");
  is.set(t.pitch_lost_deg, 45, "pitch at which the face is lost", " degrees", "assumed");
  is.set(t.turned_noise, 0.05, "noise at that yaw, sigma", "", "assumed");
  is.set(t.hand_lost, 0.3, "share of hands that lose the face", "",
         "assumed: the first paper calls vision ineffective while an apple is eaten (CAPUS, Applications, "
         "figure 8), "
         "and counts nothing");
  is.set(t.hand_wrong, 0.3, "how far mouth and jaw go wrong", "", "assumed: likewise");
  is.set(t.dark_lost, 0, "share of time lost in the dark", "",
         "assumed: infrared dots light the face; with them covered by day a developer saw no difference "
         "(developer.apple.com/forums/thread/765494), so the dark may harm it after all");
  is.set(t.dark_noise, 1, "factor of noise in the dark", "", "assumed: likewise");
  is.set(t.blur_worse_deg, 2, "blur from which it gets worse", " degrees", "assumed");
  is.set(t.blur_lost_deg, 8, "blur at which the face is lost", " degrees", "assumed");
  is.set(t.blur_noise, 0.1, "noise at that blur, sigma", "", "assumed");
  is.set(t.losses_per_hour, phone.face_loss_per_hour, "other losses an hour", "",
         "assumed: others' takes lack the face for up to 4 s");
  is.set(t.found_after_s, 0.2, "time to find the face again", " s", "assumed");
  is.set(t.hand_sway_deg, 4, "sway of a hand that holds it, root mean square", " degrees", "assumed");
  return t;
}

/// What webcams have in common.
void add_webcam(ModelledTracker& t, NumberNotes& is) {
  is.set(t.exposure_s, 1.0 / 30, "exposure", " s", "assumed: indoors, as long as a frame");
  is.set(t.dark_rate_hz, 15, "frames a second in the dark", "",
         "assumed: webcams expose longer where it is dark, and halve their rate");
  is.set(t.dark_exposure_s, 1.0 / 15, "exposure in the dark", " s", "assumed: likewise");
  is.set(t.frames_dropped, 0.01, "share of frames dropped", "", "assumed");
  t.lag_ms = {40, 80};
  is.note(
      "lag", "40 to 80 ms",
      "assumed: half an exposure, the read-out and a USB camera's buffer; both programs stamp a frame when "
      "they read it");
  is.set(t.slow_noise, 0.02, "slow noise, sigma", "", "assumed: twice the phone's");
  is.set(t.pitch_lost_deg, 50, "pitch at which the face is lost", " degrees", "assumed");
  is.set(t.blur_worse_deg, 2, "blur from which it gets worse", " degrees", "assumed: as the phone");
  is.set(t.blur_lost_deg, 10, "blur at which the face is lost", " degrees", "assumed");
  is.set(t.blur_noise, 0.15, "noise at that blur, sigma", "", "assumed");
  is.set(t.losses_per_hour, 6, "other losses an hour", "", "assumed: as the phone");
  is.set(t.hand_sway_deg, 4, "sway of a hand that holds it, root mean square", " degrees",
         "assumed: as the phone; a webcam that stands on a desk sees nobody who walks");
}

ModelledTracker mediapipe_webcam() {
  ModelledTracker t{.kind = TrackerKind::mediapipe_webcam, .name = "webcam (MediaPipe)", .told = {}};
  t.told.set();
  NumberNotes is(t);
  is.set(t.rate_hz, 30, "frames a second", "", "assumed: what webcams give indoors");
  add_webcam(t, is);
  t.one_euro = true;
  is.set(t.filter.min_cutoff_hz, 0.05, "One Euro filter, cutoff at rest", " Hz",
         "mediapipe, face_landmarks_detector_graph.cc, of landmarks in live streams of one face");
  is.set(t.filter.derivative_cutoff_hz, 1, "One Euro filter, cutoff of the speed", " Hz", "likewise");
  is.set(
      t.filter.beta, 8, "One Euro filter, beta of weights", "",
      "assumed: the graph has 80 for landmarks in sizes of the face; a weight moves them by a tenth of it");
  is.set(t.resting_offset, 0.05, "weight of a face at rest, sigma", "",
         "assumed: a little more than the phone");
  is.set(t.gain_error, 0.2, "gain of a shape, sigma about 1", "", "assumed: twice the phone's");
  is.set(t.white_noise, 0.02, "noise of a frame, sigma", "", "assumed");
  t.hardly = named_shapes({face::shape("cheekPuff_L"), face::shape("cheekPuff_R"), face::shape("eyeWide_L"),
                           face::shape("eyeWide_R"), face::shape("noseSneer_L"), face::shape("noseSneer_R"),
                           face::shape("jawForward"), face::shape("jawLeft"), face::shape("jawRight"),
                           face::shape("mouthDimple_L"), face::shape("mouthDimple_R")});
  is.note("shapes that are hardly signalled",
          "cheekPuff; eyeWide, noseSneer; jawForward, jawLeft, jawRight, "
          "mouthDimple",
          "mediapipe issues 4436 and 4450; a third-party trainer's notes");
  is.set(t.hardly_gain, 0.05, "gain of these", "", "mediapipe issue 4450: they do not go above 0.05");
  is.set(t.turned_worse_deg, 35, "yaw from which it gets worse", " degrees", "assumed");
  is.set(t.turned_lost_deg, 65, "yaw at which the face is lost", " degrees", "assumed");
  is.set(t.turned_noise, 0.1, "noise at that yaw, sigma", "", "assumed");
  is.set(t.hand_lost, 0.3, "share of hands that lose the face", "", "assumed: as the phone");
  is.set(t.hand_wrong, 0.4, "how far mouth and jaw go wrong", "",
         "assumed: that the jaw's line jumps when it is hidden is reported (mediapipe issue 2223), no amount "
         "is");
  is.set(t.dark_lost, 0.3, "share of time lost in the dark", "", "assumed");
  is.set(t.dark_lost_s, 1.5, "mean length of such a loss", " s", "assumed");
  is.set(t.dark_noise, 3, "factor of noise in the dark", "", "assumed");
  is.set(t.found_after_s, 0.07, "time to find the face again", " s",
         "assumed: the detector runs on the next frame (mediapipe, face_landmarker_graph.cc), plus one");
  return t;
}

ModelledTracker openseeface_webcam() {
  ModelledTracker t{.kind = TrackerKind::openseeface_webcam, .name = "webcam (OpenSeeFace)", .told = {}};
  t.told = openseeface_told();
  NumberNotes is(t);
  is.note("shapes", "sixteen, by docs/reference/tracker_curves.md",
          "ours: it tells features, no blendshapes");
  is.set(t.rate_hz, 30, "frames a second", "",
         "OpenSeeFace's README: 30 to 60, above 30 rarely necessary (facetracker.py asks a camera for 24)");
  add_webcam(t, is);
  is.set(t.previous_share, 0.2, "share of the frame before in each feature", "",
         "OpenSeeFace, tracker.py, class Feature: alpha 0.2");
  is.set(t.gain_error, 0.25, "gain of a feature, sigma about 1", "",
         "assumed: features are scaled by the extremes seen so far (tracker.py), which are anyone's");
  is.set(t.white_noise, 0.04, "noise of a frame, sigma", "", "assumed");
  is.set(t.turned_worse_deg, 45, "yaw from which it gets worse", " degrees",
         "assumed: its README claims a very wide range of head poses, no angle");
  is.set(t.turned_lost_deg, 80, "yaw at which the face is lost", " degrees", "assumed: likewise");
  is.set(t.turned_noise, 0.15, "noise at that yaw, sigma", "", "assumed");
  is.set(t.hand_lost, 0.15, "share of hands that lose the face", "",
         "assumed: its README calls it quite robust against partial occlusion");
  is.set(t.hand_wrong, 0.4, "how far mouth and jaw go wrong", "", "assumed");
  is.set(t.dark_lost, 0.1, "share of time lost in the dark", "",
         "assumed: its README says that it performs well in low light");
  is.set(t.dark_lost_s, 1.5, "mean length of such a loss", " s", "assumed");
  is.set(t.dark_noise, 2, "factor of noise in the dark", "", "assumed: likewise");
  is.set(t.found_after_s, 0.1, "time to find the face again", " s",
         "facetracker.py: faces are sought every third frame (--scan-every 3)");
  return t;
}

}  // namespace

const std::vector<ModelledTracker>& modelled_trackers() {
  static const std::vector<ModelledTracker> all = {truedepth_phone(), mediapipe_webcam(),
                                                   openseeface_webcam()};
  return all;
}

const ModelledTracker& modelled_tracker(TrackerKind kind) {
  return modelled_trackers()[static_cast<std::size_t>(kind)];
}

}  // namespace mien::lab
