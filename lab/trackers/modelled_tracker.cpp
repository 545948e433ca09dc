#include "lab/trackers/modelled_tracker.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "lab/trackers/openseeface_log.h"
#include "mien/core/minimum_jerk.h"
#include "mien/core/smoothstep.h"
#include "mien/core/time.h"
#include "mien/core/units.h"
#include "mien/face/livelink_csv.h"
#include "mien/face/shape_region.h"

// Which camera trackers are modelled, and where every number comes from.
#include <fmt/format.h>

#include <initializer_list>
#include <utility>

#include "lab/trackers/modelled_tracker.h"
#include "lab/trackers/openseeface_log.h"
#include "mien/virtual/phone/phone_faults.h"
namespace mien::lab {
namespace {

/// A slow noise is worth what it was for about so long.
constexpr double kSlowNoise_s = 10;
/// A hand comes and goes in so long.
constexpr double kHandMoves_s = 0.15;
/// Moments each way of one that is smoothed, half a sigma apart: three sigmas.
constexpr int kMomentsEachWay = 6;
/// A body's heading is what its head's is over about so long.
constexpr double kHeading_s = 1.5;
/// A hand that holds a camera sways about so slowly.
constexpr double kSway_s = 0.5, kSwayLag_s = 0.25;
// The mouth opens for a mouthful from 0.35 on (mien/performer/eating.h: 0.35 to 0.8); chewing opens it by
// 0.42 at most, seldom above 0.3. The head leans back by 8 to 25 degrees to drink.
constexpr float kMouthful = 0.33F;
constexpr double kHandBefore_s = 0.5, kHandAfter_s = 0.3;
constexpr double kDrinks_rad = -5 * kRadPerDeg;

/// Where the eyes look there is nothing to rest at.
bool rests_somewhere(std::size_t shape) {
  return !face::kShapeNames[shape].starts_with("eyeLook");
}

bool under_a_hand(std::size_t shape) {
  return face::kShapeRegions[shape] == face::ShapeRegion::mouth ||
         face::kShapeRegions[shape] == face::ShapeRegion::jaw;
}

/// An Ornstein-Uhlenbeck process of this standard deviation.
class WanderingNoise {
 public:
  WanderingNoise(double sigma, double time_s, Random& random)
      : sigma_(sigma), time_s_(time_s), value_(sigma * random.normal()) {}
  double next(double step_s, Random& random) {
    const double kept = std::exp(-step_s / time_s_);
    value_ = kept * value_ + sigma_ * std::sqrt(1 - kept * kept) * random.normal();
    return value_;
  }

 private:
  double sigma_, time_s_;
  double value_;
};

/// The turn of the head as the camera sees it.
struct TurnSeen {
  double yaw_deg = 0, pitch_deg = 0;  // Magnitudes.
  double blur_deg = 0;
};

/// How a hand that holds a camera turns about one axis: a wandering noise through a low pass, so that it has
/// a speed whatever the camera's rate.
class HandSway {
 public:
  HandSway(double sigma_rad, Random& random)
      // The low pass takes of the variance what its time is of both times.
      : noise_(sigma_rad * std::sqrt((kSway_s + kSwayLag_s) / kSway_s), kSway_s, random) {}
  double next(double step_s, Random& random) {
    turn_rad_ += (1 - std::exp(-step_s / kSwayLag_s)) * (noise_.next(step_s, random) - turn_rad_);
    return turn_rad_;
  }

 private:
  WanderingNoise noise_;
  double turn_rad_ = 0;
};

/// The camera's own turn: that of a stand, or of a hand.
class CameraPose {
 public:
  CameraPose(const TrackerScene& scene, double sway_rad, Random random)
      : held_(scene.held_in_hand),
        random_(random),
        sway_{HandSway(sway_rad, random_), HandSway(sway_rad, random_)} {}

  TurnSeen look_at(const Quat& q_world_head, double step_s, double exposure_s) {
    Quat q_camera_head = q_world_head;
    if (held_) {
      const double yaw_rad = face::livelink_from_head(q_world_head).x();
      heading_rad_ =
          begun_ ? heading_rad_ + std::min(1.0, step_s / kHeading_s) * (yaw_rad - heading_rad_) : yaw_rad;
      const Quat q_world_camera = face::head_from_livelink(
          {heading_rad_ + sway_[0].next(step_s, random_), sway_[1].next(step_s, random_), 0});
      q_camera_head = q_world_camera.conjugate() * q_world_head;
    }
    const Vec3 angles = face::livelink_from_head(q_camera_head);
    TurnSeen out{.yaw_deg = kDegPerRad * std::abs(angles.x()),
                 .pitch_deg = kDegPerRad * std::abs(angles.y())};
    if (begun_) out.blur_deg = kDegPerRad * q_camera_head.angularDistance(last_) / step_s * exposure_s;
    last_ = q_camera_head;
    begun_ = true;
    return out;
  }

 private:
  bool held_;
  Random random_;
  std::array<HandSway, 2> sway_;
  bool begun_ = false;
  double heading_rad_ = 0;
  Quat last_ = Quat::Identity();
};

/// What one hand does to the tracker.
struct HandEffect {
  HandBefore when;
  bool loses = false;
  double cover = 1;  // How much of mouth and jaw is made up.
  face::BlendshapeWeights wrong;
};

double hand_share(const HandBefore& hand, double time_s) {
  return minimum_jerk((time_s - hand.begin_s) / kHandMoves_s) *
         minimum_jerk((hand.end_s - time_s) / kHandMoves_s);
}

class CameraTracker {
 public:
  CameraTracker(const ModelledTracker& tracker, const TrackerScene& scene, const Random& random)
      : tracker_(tracker),
        scene_(scene),
        curve_(*scene.motion),
        camera_(scene, tracker.hand_sway_deg * kRadPerDeg, random.fork("sway")),
        noise_(random.fork("noise")),
        drops_(random.fork("drops")),
        losses_(random.fork("losses")),
        dark_(random.fork("dark")) {
    Random lag = random.fork("lag"), own = random.fork("own"), slow = random.fork("slow");
    lag_s_ = 1e-3 * lag.uniform(tracker.lag_ms[0], tracker.lag_ms[1]);
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const double rest = std::min(1.0, std::abs(own.normal(0, tracker.resting_offset)));
      rest_[k] = rests_somewhere(k) ? rest : 0;
      gain_[k] = std::max(0.0, own.normal(1, tracker.gain_error));
      if (tracker.hardly[k]) gain_[k] *= tracker.hardly_gain;
      wandering_.emplace_back(tracker.slow_noise, kSlowNoise_s, slow);
      filters_[k] = OneEuro(tracker.filter);
    }
    slow_ = slow;
    for (std::size_t h = 0; h < scene.hands.size(); ++h) {
      Random hand = random.fork("hand", h);
      HandEffect& effect = hands_.emplace_back();
      effect.when = scene.hands[h];
      effect.loses = hand.chance(tracker.hand_lost);
      effect.cover = hand.uniform(0.5, 1);
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        if (under_a_hand(k)) effect.wrong[k] = static_cast<float>(hand.uniform(0, tracker.hand_wrong));
    }
    phase_ = drops_.uniform();
  }

  [[nodiscard]] TrackerCurves film() {
    TrackerCurves out{.name = tracker_.name, .rows = {}, .told = tracker_.told, .warnings = {}};
    const double rate_hz = scene_.dark ? tracker_.dark_rate_hz : tracker_.rate_hz;
    const double end_s = curve_.duration_s();
    for (std::size_t n = 0;; ++n) {
      const double time_s = (static_cast<double>(n) + phase_) / rate_hz;
      if (time_s > end_s) break;
      TrackerRow row{.time_s = time_s, .weights = filmed(time_s, 1 / rate_hz)};
      if (!drops_.chance(tracker_.frames_dropped)) out.rows.push_back(row);
    }
    return out;
  }

 private:
  /// What it tells at a frame's time; none where it sees no face.
  std::optional<face::BlendshapeWeights> filmed(double time_s, double step_s) {
    const double shown_s = time_s - lag_s_;
    const double exposure_s = scene_.dark ? tracker_.dark_exposure_s : tracker_.exposure_s;
    const TurnSeen turn = camera_.look_at(curve_.at(shown_s).head, step_s, exposure_s);
    const bool lost = lose(time_s, step_s, shown_s, turn);
    // Drawn for lost frames too, so that a loss does not change what comes after it.
    std::array<double, face::kShapeCount> error{};
    const double white = white_sigma(turn);
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      error[k] = wandering_[k].next(step_s, slow_) + white * noise_.normal();
    if (lost) {
      if (tracker_.one_euro)
        for (OneEuro& filter : filters_) filter.reset();
      return std::nullopt;
    }
    face::BlendshapeWeights seen = smoothed(shown_s);
    for (const HandEffect& hand : hands_) {
      const auto share = static_cast<float>(hand.cover * hand_share(hand.when, shown_s));
      if (share <= 0) continue;
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        if (under_a_hand(k)) seen[k] += share * (hand.wrong[k] - seen[k]);
    }
    if (tracker_.kind == TrackerKind::openseeface_webcam) return by_features(seen, error);
    face::BlendshapeWeights told;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      double weight = rest_[k] + (1 - rest_[k]) * gain_[k] * double{seen[k]} + error[k];
      if (tracker_.one_euro) weight = filters_[k].filter(DeviceTime(from_seconds(time_s)), weight);
      told[k] = static_cast<float>(std::clamp(weight, 0.0, 1.0));
    }
    return told;
  }

  /// Whether the face is lost in this frame, and for how long.
  bool lose(double time_s, double step_s, double shown_s, const TurnSeen& turn) {
    const bool by_chance = losses_.chance(tracker_.losses_per_hour / 3600 * step_s);
    const double chance_s = losses_.uniform(0.5, 4);
    if (by_chance) lost_until_s_ = std::max(lost_until_s_, time_s + chance_s);
    // As often as makes the share of the time that it is lost what it should be.
    const double begins_hz =
        tracker_.dark_lost < 1 ? tracker_.dark_lost / (1 - tracker_.dark_lost) / tracker_.dark_lost_s : 1e3;
    const bool by_dark = dark_.chance(std::min(1.0, begins_hz * step_s));
    const double dark_s = dark_.exponential(tracker_.dark_lost_s);
    if (scene_.dark && by_dark && time_s >= lost_until_s_) lost_until_s_ = time_s + dark_s;
    const bool turned = turn.yaw_deg > tracker_.turned_lost_deg || turn.pitch_deg > tracker_.pitch_lost_deg;
    const bool hidden = std::ranges::any_of(hands_, [shown_s](const HandEffect& hand) {
      return hand.loses && shown_s > hand.when.begin_s && shown_s < hand.when.end_s;
    });
    if (turned || hidden || turn.blur_deg > tracker_.blur_lost_deg)
      lost_until_s_ = std::max(lost_until_s_, time_s + tracker_.found_after_s);
    return time_s < lost_until_s_;
  }

  [[nodiscard]] double white_sigma(const TurnSeen& turn) const {
    const double turned =
        smoothstep(tracker_.turned_worse_deg, tracker_.turned_lost_deg, turn.yaw_deg) * tracker_.turned_noise;
    const double blurred =
        smoothstep(tracker_.blur_worse_deg, tracker_.blur_lost_deg, turn.blur_deg) * tracker_.blur_noise;
    return std::hypot(tracker_.white_noise * (scene_.dark ? tracker_.dark_noise : 1), turned, blurred);
  }

  [[nodiscard]] face::BlendshapeWeights smoothed(double shown_s) const {
    if (!(tracker_.smoothing_ms > 0)) return curve_.at(shown_s).weights;
    std::array<double, face::kShapeCount> sum{};
    double all = 0;
    for (int i = -kMomentsEachWay; i <= kMomentsEachWay; ++i) {
      const double share = std::exp(-0.125 * i * i);
      const face::BlendshapeWeights weights = curve_.at(shown_s + 0.5e-3 * i * tracker_.smoothing_ms).weights;
      for (std::size_t k = 0; k < face::kShapeCount; ++k) sum[k] += share * double{weights[k]};
      all += share;
    }
    face::BlendshapeWeights out;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) out[k] = static_cast<float>(sum[k] / all);
    return out;
  }

  /// As OpenSeeFace would: distances between points, then the shapes of these. Errors are the features'.
  face::BlendshapeWeights by_features(const face::BlendshapeWeights& w,
                                      const std::array<double, face::kShapeCount>& error) {
    using enum OpenSeeFeature;
    OpenSeeFace now;
    const auto at = [&](std::size_t k) { return double{w[k]}; };
    std::size_t next = 0;
    const auto put = [&](float& feature, double value, double least, double most) {
      const double told = std::clamp(gain_[next] * value + error[next], least, most);
      ++next;
      feature = static_cast<float>(told);
    };
    // How much wider or more open each shape makes a mouth is assumed; so is that brows go up as one.
    const double stretch = 0.5 * (at(face::shape("mouthStretch_L")) + at(face::shape("mouthStretch_R")));
    const double smile = 0.5 * (at(face::shape("mouthSmile_L")) + at(face::shape("mouthSmile_R")));
    const double apart = 0.125 * (at(face::shape("mouthLowerDown_L")) + at(face::shape("mouthLowerDown_R")) +
                                  at(face::shape("mouthUpperUp_L")) + at(face::shape("mouthUpperUp_R")));
    float left_shut = 0, right_shut = 0;
    put(left_shut, at(face::shape("eyeBlink_L")), 0, 1);
    put(right_shut, at(face::shape("eyeBlink_R")), 0, 1);
    now.left_open = 1 - left_shut;
    now.right_open = 1 - right_shut;
    put(now[eyebrow_updown_l],
        0.5 * (at(face::shape("browInnerUp_L")) + at(face::shape("browOuterUp_L"))) -
            at(face::shape("browDown_L")),
        -1, 1);
    put(now[eyebrow_updown_r],
        0.5 * (at(face::shape("browInnerUp_R")) + at(face::shape("browOuterUp_R"))) -
            at(face::shape("browDown_R")),
        -1, 1);
    put(now[mouth_corner_updown_l], at(face::shape("mouthFrown_L")) - at(face::shape("mouthSmile_L")), -1, 1);
    put(now[mouth_corner_updown_r], at(face::shape("mouthFrown_R")) - at(face::shape("mouthSmile_R")), -1, 1);
    put(now[mouth_open], at(face::shape("jawOpen")) - at(face::shape("mouthClose")) + apart, -1, 1);
    put(now[mouth_wide],
        stretch + 0.3 * smile - at(face::shape("mouthPucker")) - 0.5 * at(face::shape("mouthFunnel")), -1, 1);
    const auto old = static_cast<float>(tracker_.previous_share);
    if (before_) {
      now.left_open += old * (before_->left_open - now.left_open);
      now.right_open += old * (before_->right_open - now.right_open);
      for (std::size_t i = 0; i < kOpenSeeFeatureCount; ++i)
        now.features[i] += old * (before_->features[i] - now.features[i]);
    }
    before_ = now;
    return weights_of(now);
  }

  const ModelledTracker& tracker_;
  const TrackerScene& scene_;
  face::MotionCurve curve_;
  CameraPose camera_;
  Random noise_, drops_, losses_, dark_, slow_ = Random(0);
  double lag_s_ = 0;
  double phase_ = 0;  // Of the first frame, in frames.
  std::array<double, face::kShapeCount> rest_{}, gain_{};
  std::vector<WanderingNoise> wandering_;
  std::array<OneEuro, face::kShapeCount> filters_;
  std::vector<HandEffect> hands_;
  double lost_until_s_ = -1;
  std::optional<OpenSeeFace> before_;
};

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

std::vector<HandBefore> draw_hands(double seconds, Random random) {
  std::vector<HandBefore> out;
  for (double now_s = random.uniform(0.5, 2);;) {
    const double length_s = random.uniform(1, 3);
    if (now_s + length_s > seconds) return out;
    out.push_back({now_s, now_s + length_s});
    now_s += length_s + random.uniform(2, 4);
  }
}

std::vector<HandBefore> eating_hands(const face::Motion& motion) {
  std::vector<HandBefore> out;
  for (const face::MotionFrame& frame : motion.frames) {
    const bool mouthful = frame.weights[face::shape("jawOpen")] > kMouthful;
    const bool drinks = face::livelink_from_head(frame.head).y() < kDrinks_rad;
    if (!mouthful && !drinks) continue;
    const double begin_s = frame.time_s - (mouthful ? kHandBefore_s : 0), end_s = frame.time_s + kHandAfter_s;
    if (!out.empty() && begin_s <= out.back().end_s)
      out.back().end_s = std::max(out.back().end_s, end_s);
    else
      out.push_back({begin_s, end_s});
  }
  return out;
}

TrackerCurves model_tracker(const ModelledTracker& tracker, const TrackerScene& scene, const Random& random) {
  return CameraTracker(tracker, scene, random).film();
}

const std::vector<ModelledTracker>& modelled_trackers() {
  static const std::vector<ModelledTracker> all = {truedepth_phone(), mediapipe_webcam(),
                                                   openseeface_webcam()};
  return all;
}

const ModelledTracker& modelled_tracker(TrackerKind kind) {
  return modelled_trackers()[static_cast<std::size_t>(kind)];
}

}  // namespace mien::lab
