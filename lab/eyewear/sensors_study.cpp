#include "lab/eyewear/sensors_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "lab/eyewear/marker_capture.h"
#include "lab/performance_count.h"
#include "mien/core/units.h"
#include "mien/eyewear/ambient.h"
#include "mien/eyewear/linearise.h"
#include "mien/eyewear/marker_model.h"
#include "mien/face/motion.h"
#include "mien/mocap/outliers.h"
#include "mien/performer/expression.h"
#include "mien/performer/mimic.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_simulator.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/eyewear/marker_poses.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

using face::BlendshapeWeights;

BlendshapeWeights weights_of(const performer::Pose& pose) {
  BlendshapeWeights weights;
  for (const performer::PosePart& part : pose) weights[part.shape] = part.weight;
  return weights;
}

/// Expressions that one side alone makes; the paper shows some and lists none.
std::array<performer::Pose, 6> asymmetric_poses() {
  return {performer::pose_of({{"mouthSmile_L", 0.85F}, {"cheekSquint_L", 0.5F}, {"mouthDimple_L", 0.2F}}),
          performer::pose_of({{"browOuterUp_R", 0.8F}, {"browInnerUp_R", 0.5F}, {"browDown_L", 0.6F}}),
          performer::pose_of({{"eyeBlink_L", 1.0F}, {"cheekSquint_L", 0.6F}, {"mouthSmile_L", 0.3F}}),
          performer::pose_of({{"mouthLeft", 0.8F}, {"mouthPucker", 0.3F}}),
          performer::pose_of({{"jawRight", 0.7F}, {"jawOpen", 0.25F}, {"mouthRight", 0.3F}}),
          performer::pose_of({{"noseSneer_R", 0.8F}, {"mouthUpperUp_R", 0.7F}, {"cheekSquint_R", 0.4F}})};
}

using eyewear::MarkerModel;

/// One window of ten on-off pairs, as a host sees it, and what was there.
struct Recorded {
  Eigen::MatrixXd distances_m;  ///< Samples x sensors, linearised.
  Eigen::MatrixXd truth_m;      ///< Samples x 3V, true.
  Eigen::MatrixXd captured_m;   ///< The same as motion capture has it; empty where nobody asks.
};

/// The glasses on a wearer, and how their light is told in metres.
class Recorder {
 public:
  static Result<Recorder> make(virt::EyewearSimulator& simulator, std::size_t sensors,
                               const builtin_face::PlacedMarkers& markers) {
    Recorder recorder(simulator, markers);
    for (std::size_t s = 0; s < sensors; ++s) {
      MIEN_TRY_ASSIGN(recorder.lines_.emplace_back(), eyewear::Linearisation::fit(simulator.bench(s)));
    }
    recorder.medians_.resize(sensors);
    return recorder;
  }

  [[nodiscard]] double window_s() const {
    return static_cast<double>(eyewear::kMedianSamples) * simulator_->pair_period_s();
  }

  /// Windows that begin at these times of the motion, which itself began at `offset_s` of the wearer's day.
  Recorded record(const face::Motion& motion, std::span<const double> begins_s, double offset_s,
                  MarkerCapture* capture) {
    const face::MotionCurve curve(motion);
    const auto rows = static_cast<Eigen::Index>(begins_s.size());
    Recorded out;
    out.distances_m.resize(rows, static_cast<Eigen::Index>(lines_.size()));
    out.truth_m.resize(rows, 3 * static_cast<Eigen::Index>(markers_->count()));
    if (capture != nullptr) out.captured_m.resize(rows, out.truth_m.cols());
    for (Eigen::Index i = 0; i < rows; ++i) {
      const double begin_s = begins_s[static_cast<std::size_t>(i)];
      const BlendshapeWeights from = curve.at(begin_s).weights;
      const BlendshapeWeights to = curve.at(begin_s + window_s()).weights;
      for (const sensor::Sample& sample :
           simulator_->play(offset_s + begin_s, static_cast<int>(eyewear::kMedianSamples), from, to))
        if (const auto light = medians_[sample.sensor].add(sample.values[0] - sample.values[1]))
          out.distances_m(i, sample.sensor) = lines_[sample.sensor].distance_m(double{*light});
      const Eigen::VectorXd truth_m = markers_->at(curve.at(begin_s + 0.5 * window_s()).weights);
      out.truth_m.row(i) = truth_m.transpose();
      if (capture != nullptr)
        out.captured_m.row(i) = capture->capture(offset_s + begin_s, truth_m).transpose();
    }
    return out;
  }

 private:
  Recorder(virt::EyewearSimulator& simulator, const builtin_face::PlacedMarkers& markers)
      : simulator_(&simulator), markers_(&markers) {}

  virt::EyewearSimulator* simulator_;
  const builtin_face::PlacedMarkers* markers_;
  std::vector<eyewear::Linearisation> lines_;
  std::vector<eyewear::BlockMedian> medians_;
};

/// What one wearer's training and tests gave.
struct SensorsOutcome {
  SensorsTraining training;
  std::array<std::vector<MarkerSums>, 3> methods;  ///< faithful, faithful16, mean_pose: a test each.
};

Eigen::MatrixXd take_rows(const Eigen::MatrixXd& from, const std::vector<std::size_t>& rows,
                          const std::vector<std::uint16_t>* columns) {
  const Eigen::Index width = columns != nullptr ? std::ssize(*columns) : from.cols();
  Eigen::MatrixXd out(std::ssize(rows), width);
  for (Eigen::Index i = 0; i < out.rows(); ++i)
    for (Eigen::Index c = 0; c < width; ++c)
      out(i, c) = from(static_cast<Eigen::Index>(rows[static_cast<std::size_t>(i)]),
                       columns != nullptr ? (*columns)[static_cast<std::size_t>(c)] : c);
  return out;
}

Eigen::MatrixXd estimate(const MarkerModel& model, const Eigen::MatrixXd& sensors) {
  Eigen::MatrixXd out(sensors.rows(), model.mean().size());
  for (Eigen::Index i = 0; i < out.rows(); ++i)
    out.row(i) = model.markers(sensors.row(i).transpose()).transpose();
  return out;
}

/// Begins of the windows that training samples are: drawn evenly over the session, by time.
std::vector<double> draw_begins(const SensorsRequest& request, double window_s, Random random) {
  std::vector<double> begins(request.samples);
  const double last_s = std::max(0.0, request.poses * request.pose_s - window_s);
  for (double& begin_s : begins) begin_s = random.uniform(0, last_s);
  std::ranges::sort(begins);
  return begins;
}

Result<SensorsOutcome> wear_for_study(const SensorsRequest& request, const sensor::Rig& rig,
                                      const builtin_face::MarkerSet& markers,
                                      const virt::EyewearFaults& faults, const virt::MarkerPoses& poses,
                                      const std::vector<SensorsTest>& tests, std::size_t index,
                                      PerformanceCount& tests_done) {
  const Random root = Random(request.seed).fork("sensors", index);
  MIEN_TRY_ASSIGN(const virt::EyewearWearer wearer,
                  virt::draw_eyewear_wearer(rig, faults, root.fork("wearer")));
  MIEN_TRY_ASSIGN(const builtin_face::PlacedMarkers placed,
                  builtin_face::PlacedMarkers::place(wearer.face, markers));
  virt::EyewearSimulator simulator(wearer, faults, root.fork("glasses"));
  simulator.put_on();
  MIEN_TRY_ASSIGN(Recorder recorder, Recorder::make(simulator, rig.sensors.size(), placed));
  MarkerCapture capture(faults, placed.neutral_m(), root.fork("capture"));

  // Training.
  std::vector<performer::PoseCue> cues;
  Random drawn = root.fork("targets");
  for (int p = 0; p < request.poses; ++p) cues.push_back({p * request.pose_s, poses.draw(drawn)});
  const double training_s = request.poses * request.pose_s;
  const Recorded training =
      recorder.record(performer::mimic(cues, training_s, {}, root.fork("training")),
                      draw_begins(request, recorder.window_s(), root.fork("samples")), 0, &capture);
  const mocap::Kept kept = mocap::reject_outliers(training.captured_m);
  const Eigen::MatrixXd learnt = take_rows(training.captured_m, kept.rows, nullptr);
  std::vector<std::uint16_t> frame_sensors;
  const std::vector<std::uint16_t> hooks = ear_hook_sensors(rig);
  for (std::uint16_t s = 0; s < rig.sensors.size(); ++s)
    if (std::ranges::find(hooks, s) == hooks.end()) frame_sensors.push_back(s);
  MIEN_TRY_ASSIGN(const MarkerModel all,
                  MarkerModel::fit(take_rows(training.distances_m, kept.rows, nullptr), learnt));
  MIEN_TRY_ASSIGN(const MarkerModel without_hooks,
                  MarkerModel::fit(take_rows(training.distances_m, kept.rows, &frame_sensors), learnt));

  tests_done.count(tests.size());
  MIEN_TRY(tests_done.go_on());

  SensorsOutcome out;
  out.training = {request.samples, kept.rejected, all.share()};
  // Tests, one after the other, windows without a gap.
  std::vector<double> begins;
  for (double begin_s = 0; begin_s + recorder.window_s() <= request.test_s; begin_s += recorder.window_s())
    begins.push_back(begin_s);
  for (std::size_t t = 0; t < tests.size(); ++t) {
    const std::array<performer::PoseCue, 1> cue = {performer::PoseCue{0, tests[t].target}};
    const double offset_s = training_s + kRestS + static_cast<double>(t) * request.test_s;
    const Recorded test = recorder.record(performer::mimic(cue, request.test_s, {}, root.fork("test", t)),
                                          begins, offset_s, nullptr);
    std::vector<std::size_t> every(begins.size());
    for (std::size_t i = 0; i < every.size(); ++i) every[i] = i;
    out.methods[0].emplace_back().add(estimate(all, test.distances_m), test.truth_m);
    out.methods[1].emplace_back().add(
        estimate(without_hooks, take_rows(test.distances_m, every, &frame_sensors)), test.truth_m);
    const Eigen::MatrixXd mean_m = all.mean().transpose().replicate(test.truth_m.rows(), 1);
    out.methods[2].emplace_back().add(mean_m, test.truth_m);
    tests_done.count();
    MIEN_TRY(tests_done.go_on());
  }
  return out;
}

}  // namespace

std::string_view sensors_test_set_name(SensorsTestSet set) {
  constexpr std::array<std::string_view, kTestSets> kNames = {"neutral", "A", "B", "C"};
  return kNames[static_cast<std::size_t>(set)];
}

std::vector<SensorsTest> make_sensors_tests(const virt::MarkerPoses& poses, Random random) {
  std::vector<SensorsTest> tests = {{SensorsTestSet::neutral, {}}};
  for (int i = 0; i < 6; ++i) tests.push_back({SensorsTestSet::components, poses.draw(random)});
  for (const performer::Emotion emotion :
       {performer::Emotion::joy, performer::Emotion::disgust, performer::Emotion::anger,
        performer::Emotion::surprise, performer::Emotion::fear, performer::Emotion::sadness})
    tests.push_back({SensorsTestSet::universal, weights_of(performer::emotion_expression(emotion).pose)});
  for (const performer::Pose& pose : asymmetric_poses())
    tests.push_back({SensorsTestSet::asymmetric, weights_of(pose)});
  return tests;
}

void MarkerSums::add(const Eigen::VectorXd& estimate_m, const Eigen::VectorXd& truth_m) {
  const Eigen::Index markers = truth_m.size() / 3;
  if (samples_ == 0) {
    distance_mm_ = Eigen::ArrayXd::Zero(markers);
    square_mm2_ = Eigen::ArrayXd::Zero(markers);
  }
  ++samples_;
  for (Eigen::Index m = 0; m < markers; ++m) {
    const double mm = kMmPerM * (estimate_m - truth_m).segment<3>(3 * m).norm();
    distance_mm_[m] += mm;
    square_mm2_[m] += mm * mm;
  }
}

void MarkerSums::add(const Eigen::MatrixXd& estimate_m, const Eigen::MatrixXd& truth_m) {
  for (Eigen::Index i = 0; i < truth_m.rows(); ++i)
    add(Eigen::VectorXd(estimate_m.row(i)), Eigen::VectorXd(truth_m.row(i)));
}

MarkerSums& MarkerSums::operator+=(const MarkerSums& more) {
  if (samples_ == 0) return *this = more;
  if (more.samples_ == 0) return *this;
  samples_ += more.samples_;
  distance_mm_ += more.distance_mm_;
  square_mm2_ += more.square_mm2_;
  return *this;
}

MarkerError MarkerSums::over(const std::vector<std::size_t>& markers) const {
  MarkerError error;
  if (samples_ == 0 || markers.empty()) return error;
  const auto samples = static_cast<double>(samples_);
  for (const std::size_t m : markers) {
    error.mean_mm += distance_mm_[static_cast<Eigen::Index>(m)] / samples;
    error.rmse_mm += std::sqrt(square_mm2_[static_cast<Eigen::Index>(m)] / samples);
  }
  error.mean_mm /= static_cast<double>(markers.size());
  error.rmse_mm /= static_cast<double>(markers.size());
  return error;
}

SensorsMethod sum_up(std::string name, std::size_t sensors,
                     const std::vector<std::vector<MarkerSums>>& wearers,
                     const std::vector<SensorsTest>& tests, const builtin_face::MarkerSet& markers) {
  std::vector<std::size_t> every(markers.markers.size());
  for (std::size_t m = 0; m < every.size(); ++m) every[m] = m;
  const std::vector<std::size_t> eyes = markers.of(builtin_face::MarkerRegion::eyes_nose);
  const std::vector<std::size_t> mouth = markers.of(builtin_face::MarkerRegion::mouth);
  const auto row = [&](const MarkerSums& sums) {
    return SensorsRow{sums.over(every), sums.over(eyes), sums.over(mouth)};
  };
  SensorsMethod out;
  out.name = std::move(name);
  out.sensors = sensors;
  MarkerSums all;
  std::array<MarkerSums, kTestSets> sets;
  std::vector<MarkerSums> each(tests.size());
  for (const std::vector<MarkerSums>& of_tests : wearers) {
    MarkerSums wearer;
    for (std::size_t t = 0; t < tests.size(); ++t) {
      wearer += of_tests[t];
      each[t] += of_tests[t];
      sets[static_cast<std::size_t>(tests[t].set)] += of_tests[t];
    }
    out.wearers.push_back(row(wearer));
    all += wearer;
  }
  out.overall = row(all);
  for (std::size_t s = 0; s < kTestSets; ++s) out.sets[s] = row(sets[s]);
  for (const MarkerSums& sums : each) out.tests.push_back(row(sums));
  for (const std::size_t m : every) out.markers.push_back(all.over({m}));
  return out;
}

std::vector<std::uint16_t> ear_hook_sensors(const sensor::Rig& rig) {
  std::vector<std::uint16_t> sensors;
  for (std::uint16_t s = 0; s < rig.sensors.size(); ++s)
    if (rig.sensors[s].site == "jaw_joint" || rig.sensors[s].site == "lower_jaw") sensors.push_back(s);
  return sensors;
}

Result<SensorsStudy> study_sensors(const SensorsRequest& request, const sensor::Rig& rig,
                                   const builtin_face::MarkerSet& markers, const Progress& progress) {
  if (request.wearers < 1 || request.poses < 1 || !(request.pose_s > 0) || !(request.test_s >= 1) ||
      request.samples < rig.sensors.size() + 2)
    return fail(ErrorCode::bad_usage,
                "the study needs a wearer, a pose, a second of each test, and more samples than sensors",
                "study sensors");
  MIEN_TRY_ASSIGN(const virt::EyewearFaults faults, virt::parse_eyewear_faults(rig.faults_toml, rig.name));
  const Random root = Random(request.seed).fork("sensors");
  MIEN_TRY_ASSIGN(const virt::MarkerPoses poses,
                  virt::MarkerPoses::measure(markers, virt::kMeasuredBeforeS, root.fork("before")));
  const std::vector<SensorsTest> tests = make_sensors_tests(poses, root.fork("tests"));
  std::vector<SensorsOutcome> outcomes(static_cast<std::size_t>(request.wearers));
  // Fitting a wearer's model takes as long as all of the tests.
  PerformanceCount tests_done(progress, 2 * tests.size() * outcomes.size());
  const Progress by_test = tests_done.progress();
  MIEN_TRY(virt::for_each_performer(
      outcomes.size(), request.threads, by_test, [&](std::size_t index) -> Result<void> {
        MIEN_TRY_ASSIGN(outcomes[index],
                        wear_for_study(request, rig, markers, faults, poses, tests, index, tests_done));
        return {};
      }));
  SensorsStudy study;
  for (const builtin_face::Marker& marker : markers.markers) study.markers.push_back(marker.name);
  for (const SensorsOutcome& outcome : outcomes) study.training.push_back(outcome.training);
  const std::size_t sensors = rig.sensors.size();
  const auto method = [&](std::string name, std::size_t of_sensors, std::size_t which) {
    std::vector<std::vector<MarkerSums>> sums;
    for (const SensorsOutcome& outcome : outcomes) sums.push_back(outcome.methods[which]);
    return sum_up(std::move(name), of_sensors, sums, tests, markers);
  };
  study.faithful = method("faithful", sensors, 0);
  study.faithful16 = method("faithful16", sensors - ear_hook_sensors(rig).size(), 1);
  study.mean_pose = method("mean_pose", 0, 2);
  return study;
}

}  // namespace mien::lab
