#include "mien/study/imu/phone_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "mien/builtin_face/load_face.h"
#include "mien/core/time.h"
#include "mien/measure/evaluation.h"
#include "mien/study/imu/filmed_wearer.h"
#include "mien/study/performance.h"
#include "mien/study/phone_truth.h"
#include "mien/study/shifted_person.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/tracker/learn_correction.h"

namespace mien::study {
namespace {

using Answers = std::vector<face::BlendshapeWeights>;

Result<FilmedWearer> film(const PhoneStudyRequest& request, const face::Motion& motion,
                          const std::string& face, const std::string& devices, std::uint64_t seed,
                          const std::optional<virt::PhoneFaults>& phone) {
  return film_wearer(
      {.motion = motion, .face = face, .rig = request.rig, .devices = devices, .seed = seed, .phone = phone});
}

face::Motion part_of(const face::Motion& motion, double from_s, double to_s) {
  face::Motion part{.name = motion.name, .frames = {}, .has_head = motion.has_head};
  part.head_without_face = motion.head_without_face;
  for (face::MotionFrame frame : motion.frames) {
    if (frame.time_s < from_s || frame.time_s > to_s) continue;
    frame.time_s -= from_s;
    part.frames.push_back(frame);
  }
  if (!part.frames.empty() && part.frames.front().time_s > 0) {
    const double first_s = part.frames.front().time_s;
    for (face::MotionFrame& frame : part.frames) frame.time_s -= first_s;
  }
  return part;
}

Result<PhoneSyncRow> sync_row(std::uint64_t seed, const FilmedWearer& filmed) {
  PhoneSyncRow row;
  row.seed = seed;
  const DeviceTime begin = filmed.features.front().time;
  MIEN_TRY_ASSIGN(const PhoneTrack track, phone_track(filmed.rig, filmed.session.samples, begin));
  const auto found = phone_truth(filmed.session.events, filmed.features, track);
  if (!found) {
    row.refused = found.error().what;
    return row;
  }
  const phone::TimeAlignment& at = found->alignment;
  // When the phone tells what was then, its time; by the clocks themselves.
  const auto told_s = [&](double sensors_s) {
    const double true_s = filmed.reference.true_s(begin + from_seconds(sensors_s));
    return to_seconds(filmed.phone.device(true_s + filmed.phone_lag_s) - track.begin);
  };
  row.error_s = at.offset_s - (at.middle_s - told_s(at.middle_s));
  const double half_s = 0.5 * at.overlap_s;
  const double length_s = told_s(at.middle_s + half_s) - told_s(at.middle_s - half_s);
  row.drift_error_ppm = at.drift_ppm - 1e6 * (at.overlap_s / length_s - 1);
  row.sigma_s = at.offset_sigma_s;
  row.drift_sigma_ppm = at.drift_sigma_ppm;
  row.agreement = at.agreement;
  return row;
}

/// A wearer, and the motion that is halved.
struct Wearer {
  std::string who, face;
  face::Motion motion;
};

class Trial {
 public:
  Trial(const PhoneStudyRequest& request, const Wearer& wearer, std::string devices)
      : request_(request), wearer_(wearer), devices_(std::move(devices)) {}

  /// Performs the half that is tried. Call first.
  Result<void> prepare() {
    MIEN_TRY_ASSIGN(face_, builtin_face::load_face(wearer_.face));
    const double half_s = 0.5 * wearer_.motion.duration_s();
    MIEN_TRY_ASSIGN(tried_, film(request_, part_of(wearer_.motion, half_s, 2 * half_s + 1), wearer_.face,
                                 devices_, request_.seed + 1'000, std::nullopt));
    MIEN_TRY_ASSIGN(before_, answers(request_.model, std::nullopt));
    return {};
  }

  /// Learnt from the first `seconds`, s, of at most a half.
  Result<PhoneLearnRow> learn(double seconds, bool loses_sensors) {
    seconds = std::min(seconds, 0.5 * wearer_.motion.duration_s());
    PhoneLearnRow row;
    row.who = wearer_.who;
    row.devices = devices_;
    row.learnt_s = seconds;
    auto learnt = learnt_from(seconds, hard_phone(), row.taken);
    if (!learnt) {
      if (!is_bad_input(learnt.error().code)) return std::unexpected(std::move(learnt).error());
      row.refused = learnt.error().what;
      return row;
    }
    const measure::Meter meter(face_);
    MIEN_TRY_ASSIGN(const Answers after, answers(*learnt, std::nullopt));
    const measure::Metrics first = measured(meter, before_), last = measured(meter, after);
    row.all = {first.pve_mm.mean, last.pve_mm.mean, first.mse, last.mse};
    if (!loses_sensors) return row;
    const std::size_t sensors = tried_.rig.face_sensor_names().size();
    for (std::size_t lost = 0; lost < sensors; ++lost) {
      MIEN_TRY_ASSIGN(const Answers without, answers(request_.model, lost));
      MIEN_TRY_ASSIGN(const Answers with, answers(*learnt, lost));
      const double unlearnt = mse(without), corrected = mse(with);
      row.mse_lost_before += unlearnt / static_cast<double>(sensors);
      row.mse_lost_after += corrected / static_cast<double>(sensors);
      row.worst_lost = std::max(row.worst_lost, corrected / unlearnt);
    }
    bool taken = false;
    if (const auto perfect = learnt_from(seconds, virt::PhoneFaults{}, taken)) {
      MIEN_TRY_ASSIGN(const Answers best, answers(*perfect, std::nullopt));
      row.pve_perfect_mm = measured(meter, best).pve_mm.mean;
    }
    return row;
  }

 private:
  Result<model::ModelFile> learnt_from(double seconds, const virt::PhoneFaults& phone, bool& taken) {
    model::ModelFile file = request_.model;
    MIEN_TRY_ASSIGN(const FilmedWearer filmed, film(request_, part_of(wearer_.motion, 0, seconds),
                                                    wearer_.face, devices_, request_.seed, phone));
    MIEN_TRY_ASSIGN(const PhoneTruth truth, truth_of(filmed));
    MIEN_TRY_ASSIGN(const tracker::LearntCorrection learnt,
                    tracker::learn_correction(filmed.features, taught_by(truth),
                                              filmed.rig.face_sensor_names(), face_, file));
    taken = learnt.taken;
    return file;
  }

  Result<Answers> answers(const model::ModelFile& file, std::optional<std::size_t> lost) const {
    MIEN_TRY_ASSIGN(tracker::CausalTracker tracker,
                    tracker::CausalTracker::create(file, tried_.rig.face_sensor_names()));
    Answers out;
    face::OutputFrame frame;
    for (model::FeatureFrame feature : tried_.features) {
      if (lost) feature.sensors[*lost] = {};
      tracker.step(feature, frame);
      out.push_back(frame.weights);
    }
    return out;
  }
  [[nodiscard]] measure::Metrics measured(const measure::Meter& meter, const Answers& estimate) const {
    return measure::measure_track(meter, tried_.session.truth, estimate);
  }
  [[nodiscard]] double mse(const Answers& estimate) const {
    double sum = 0, count = 0;
    for (std::size_t f = 0; f < estimate.size(); ++f) {
      const take::TruthFrame& truth = tried_.session.truth[f];
      if (!truth.evaluated || !truth.has_face) continue;
      for (std::size_t k = 0; k < face::kShapeCount; ++k) {
        const double is = std::clamp(double{truth.weights[k]}, 0.0, 1.0);
        sum += std::pow(double{estimate[f][k]} - is, 2);
      }
      count += static_cast<double>(face::kShapeCount);
    }
    return count > 0 ? sum / count : 0;
  }

  const PhoneStudyRequest& request_;
  const Wearer& wearer_;
  std::string devices_;
  face::Face face_;
  FilmedWearer tried_;
  Answers before_;
};

/// Every other stranger is of the distribution that models are trained on, the others are shifted from it.
std::vector<Wearer> strangers(const PhoneStudyRequest& request) {
  std::vector<Wearer> all;
  for (std::size_t i = 0; i < request.strangers; ++i) {
    const Random root = Random(request.seed).fork("stranger", i);
    const std::string face = fmt::format("builtin:{}", 400 + request.seed * 100 + i);
    if (i % 2 == 0)
      all.push_back({fmt::format("stranger {}", i + 1), face,
                     draw_motion(request.stranger_s, draw_person(root).style, root)});
    else
      all.push_back({fmt::format("stranger {}, shifted", i + 1), face,
                     draw_shifted_person(i / 2, request.stranger_s, root).motion});
  }
  return all;
}

}  // namespace

virt::PhoneFaults hard_phone() {
  virt::PhoneFaults phone = virt::usual_phone();
  phone.frames_dropped = 0.1;
  phone.face_lost_between_s = {20, 24};
  return phone;
}

Result<PhoneStudy> study_phone(const PhoneStudyRequest& request, const Progress& progress) {
  PhoneStudy out;
  std::vector<Wearer> wearers = strangers(request);
  for (const face::Motion& motion : request.motions) wearers.push_back({motion.name, request.face, motion});
  const std::size_t curve = request.curve_s.empty() ? 0 : std::min<std::size_t>(2, request.strangers);
  const auto all = static_cast<double>(request.sync_seeds + 2 * wearers.size() + curve);
  double done = 0;
  const auto goes_on = [&](std::string_view what) { return progress(std::min(1.0, done / all), what); };
  const auto stopped = [] { return fail(ErrorCode::cancelled, "stopped", "study phone"); };
  for (std::size_t i = 0; i < request.sync_seeds; ++i, ++done) {
    if (!goes_on("time")) return stopped();
    const Random root = Random(request.seed).fork("sync", i);
    const face::Motion motion = draw_motion(request.sync_s, draw_person(root).style, root);
    const std::uint64_t seed = request.seed * 100 + i;
    const std::string face = fmt::format("builtin:{}", seed);
    MIEN_TRY_ASSIGN(const FilmedWearer filmed, film(request, motion, face, "device", seed, hard_phone()));
    MIEN_TRY_ASSIGN(out.sync.emplace_back(), sync_row(seed, filmed));
  }
  for (const Wearer& wearer : wearers)
    for (const char* devices : {"lab", "device"}) {
      if (!goes_on("learning")) return stopped();
      Trial trial(request, wearer, devices);
      MIEN_TRY(trial.prepare());
      MIEN_TRY_ASSIGN(out.learnt.emplace_back(), trial.learn(wearer.motion.duration_s(), true));
      ++done;
    }
  for (std::size_t i = 0; i < curve; ++i, ++done) {
    if (!goes_on("curve")) return stopped();
    // So that the longest stretch is half of it.
    Wearer wearer = wearers[i];
    const Random root = Random(request.seed).fork("curve", i);
    wearer.motion =
        draw_motion(2 * *std::ranges::max_element(request.curve_s), draw_person(root).style, root);
    Trial trial(request, wearer, "device");
    MIEN_TRY(trial.prepare());
    for (const double seconds : request.curve_s) {
      MIEN_TRY_ASSIGN(out.curve.emplace_back(), trial.learn(seconds, false));
    }
  }
  progress(1, "done");
  return out;
}

}  // namespace mien::study
