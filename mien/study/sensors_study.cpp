#include "mien/study/sensors_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "mien/eyewear/block_median.h"
#include "mien/eyewear/linearise.h"
#include "mien/eyewear/marker_model.h"
#include "mien/eyewear/outliers.h"
#include "mien/face/motion.h"
#include "mien/study/marker_poses.h"
#include "mien/study/performers.h"
#include "mien/virtual/expression.h"
#include "mien/virtual/eyewear_faults.h"
#include "mien/virtual/eyewear_simulator.h"
#include "mien/virtual/eyewear_wearer.h"
#include "mien/virtual/marker_capture.h"
#include "mien/virtual/mimic.h"

namespace mien::study {
namespace {

using eyewear::MarkerModel;
using face::BlendshapeWeights;

constexpr double kMeasuredBeforeS = 300;  // Marker motion that the components are of.
constexpr double kRestS = 60;             // Between training and tests.
constexpr double kMmPerM = 1000;

struct Test {
  TestSet set = TestSet::neutral;
  BlendshapeWeights target;
};

BlendshapeWeights weights_of(const virt::Pose& pose) {
  BlendshapeWeights weights;
  for (const virt::PosePart& part : pose) weights[part.shape] = part.weight;
  return weights;
}

/// Expressions that one side alone makes; the paper shows some and lists none.
std::array<virt::Pose, 6> asymmetric_poses() {
  return {virt::pose_of({{"mouthSmile_L", 0.85F}, {"cheekSquint_L", 0.5F}, {"mouthDimple_L", 0.2F}}),
          virt::pose_of({{"browOuterUp_R", 0.8F}, {"browInnerUp_R", 0.5F}, {"browDown_L", 0.6F}}),
          virt::pose_of({{"eyeBlink_L", 1.0F}, {"cheekSquint_L", 0.6F}, {"mouthSmile_L", 0.3F}}),
          virt::pose_of({{"mouthLeft", 0.8F}, {"mouthPucker", 0.3F}}),
          virt::pose_of({{"jawRight", 0.7F}, {"jawOpen", 0.25F}, {"mouthRight", 0.3F}}),
          virt::pose_of({{"noseSneer_R", 0.8F}, {"mouthUpperUp_R", 0.7F}, {"cheekSquint_R", 0.4F}})};
}

std::vector<Test> make_tests(const MarkerPoses& poses, Random random) {
  std::vector<Test> tests = {{TestSet::neutral, {}}};
  for (int i = 0; i < 6; ++i) tests.push_back({TestSet::components, poses.draw(random)});
  for (const virt::Emotion emotion : {virt::Emotion::joy, virt::Emotion::disgust, virt::Emotion::anger,
                                      virt::Emotion::surprise, virt::Emotion::fear, virt::Emotion::sadness})
    tests.push_back({TestSet::universal, weights_of(virt::emotion_expression(emotion).pose)});
  for (const virt::Pose& pose : asymmetric_poses()) tests.push_back({TestSet::asymmetric, weights_of(pose)});
  return tests;
}

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
                               const eyewear::PlacedMarkers& markers) {
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
                  virt::MarkerCapture* capture) {
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
  Recorder(virt::EyewearSimulator& simulator, const eyewear::PlacedMarkers& markers)
      : simulator_(&simulator), markers_(&markers) {}

  virt::EyewearSimulator* simulator_;
  const eyewear::PlacedMarkers* markers_;
  std::vector<eyewear::Linearisation> lines_;
  std::vector<eyewear::BlockMedian> medians_;
};

/// Sums over one wearer's samples of one test.
struct Sums {
  std::size_t samples = 0;
  Eigen::ArrayXd distance_mm;  ///< A marker.
  Eigen::ArrayXd square_mm2;
};

Sums sum_errors(const Eigen::MatrixXd& estimate_m, const Eigen::MatrixXd& truth_m) {
  Sums sums;
  const Eigen::Index markers = truth_m.cols() / 3;
  sums.samples = static_cast<std::size_t>(truth_m.rows());
  sums.distance_mm = Eigen::ArrayXd::Zero(markers);
  sums.square_mm2 = Eigen::ArrayXd::Zero(markers);
  for (Eigen::Index i = 0; i < truth_m.rows(); ++i)
    for (Eigen::Index m = 0; m < markers; ++m) {
      const double mm = kMmPerM * (estimate_m.row(i) - truth_m.row(i)).segment<3>(3 * m).norm();
      sums.distance_mm[m] += mm;
      sums.square_mm2[m] += mm * mm;
    }
  return sums;
}

/// What one wearer's training and tests gave.
struct Outcome {
  SensorsTraining training;
  std::array<std::vector<Sums>, 3> methods;  ///< faithful, faithful16, mean_pose: a test each.
  std::vector<double> curve_s;
  std::vector<double> curve_mm;
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

/// How far all wearers are together, in tests; the training counts as much as all tests of a wearer.
struct Course {
  std::atomic<std::size_t> done = 0;
  std::atomic<bool> stop = false;
  /// False when it is to end.
  bool passed(std::size_t tests) {
    done += tests;
    return !stop;
  }
};

Result<Outcome> wear(const SensorsRequest& request, const sensor::Rig& rig, const eyewear::MarkerSet& markers,
                     const virt::EyewearFaults& faults, const MarkerPoses& poses,
                     const std::vector<Test>& tests, std::size_t index, Course& course) {
  const auto stopped = [] {
    return fail(ErrorCode::cancelled, "stopped before all wearers were measured", "study sensors");
  };
  const Random root = Random(request.seed).fork("sensors", index);
  MIEN_TRY_ASSIGN(const virt::EyewearWearer wearer,
                  virt::draw_eyewear_wearer(rig, faults, root.fork("wearer")));
  MIEN_TRY_ASSIGN(const eyewear::PlacedMarkers placed, eyewear::PlacedMarkers::place(wearer.face, markers));
  virt::EyewearSimulator simulator(wearer, faults, root.fork("glasses"));
  simulator.put_on();
  MIEN_TRY_ASSIGN(Recorder recorder, Recorder::make(simulator, rig.sensors.size(), placed));
  virt::MarkerCapture capture(faults, placed.neutral_m(), root.fork("capture"));

  // Training.
  std::vector<virt::PoseCue> cues;
  Random drawn = root.fork("targets");
  for (int p = 0; p < request.poses; ++p) cues.push_back({p * request.pose_s, poses.draw(drawn)});
  const double training_s = request.poses * request.pose_s;
  const Recorded training =
      recorder.record(virt::mimic(cues, training_s, {}, root.fork("training")),
                      draw_begins(request, recorder.window_s(), root.fork("samples")), 0, &capture);
  const eyewear::Kept kept = eyewear::reject_outliers(training.captured_m);
  const Eigen::MatrixXd learnt = take_rows(training.captured_m, kept.rows, nullptr);
  std::vector<std::uint16_t> frame_sensors;
  const std::vector<std::uint16_t> hooks = ear_hook_sensors(rig);
  for (std::uint16_t s = 0; s < rig.sensors.size(); ++s)
    if (std::ranges::find(hooks, s) == hooks.end()) frame_sensors.push_back(s);
  MIEN_TRY_ASSIGN(const MarkerModel all,
                  MarkerModel::fit(take_rows(training.distances_m, kept.rows, nullptr), learnt));
  MIEN_TRY_ASSIGN(const MarkerModel without_hooks,
                  MarkerModel::fit(take_rows(training.distances_m, kept.rows, &frame_sensors), learnt));

  if (!course.passed(tests.size())) return stopped();

  Outcome out;
  out.training = {request.samples, kept.rejected, all.share()};
  // Tests, one after the other, windows without a gap.
  std::vector<double> begins;
  for (double begin_s = 0; begin_s + recorder.window_s() <= request.test_s; begin_s += recorder.window_s())
    begins.push_back(begin_s);
  for (std::size_t t = 0; t < tests.size(); ++t) {
    const std::array<virt::PoseCue, 1> cue = {virt::PoseCue{0, tests[t].target}};
    const double offset_s = training_s + kRestS + static_cast<double>(t) * request.test_s;
    const Recorded test = recorder.record(virt::mimic(cue, request.test_s, {}, root.fork("test", t)), begins,
                                          offset_s, nullptr);
    std::vector<std::size_t> every(begins.size());
    for (std::size_t i = 0; i < every.size(); ++i) every[i] = i;
    const Eigen::MatrixXd estimated = estimate(all, test.distances_m);
    out.methods[0].push_back(sum_errors(estimated, test.truth_m));
    out.methods[1].push_back(sum_errors(
        estimate(without_hooks, take_rows(test.distances_m, every, &frame_sensors)), test.truth_m));
    out.methods[2].push_back(
        sum_errors(all.mean().transpose().replicate(test.truth_m.rows(), 1), test.truth_m));
    for (Eigen::Index i = 0; i < test.truth_m.rows(); ++i) {
      const Sums one = sum_errors(estimated.row(i), test.truth_m.row(i));
      out.curve_s.push_back(static_cast<double>(t) * request.test_s + begins[static_cast<std::size_t>(i)]);
      out.curve_mm.push_back(one.distance_mm.mean());
    }
    if (!course.passed(1)) return stopped();
  }
  return out;
}

MarkerError over(const Sums& sums, const std::vector<std::size_t>& markers) {
  MarkerError error;
  if (sums.samples == 0 || markers.empty()) return error;
  const auto samples = static_cast<double>(sums.samples);
  for (const std::size_t m : markers) {
    error.mean_mm += sums.distance_mm[static_cast<Eigen::Index>(m)] / samples;
    error.rmse_mm += std::sqrt(sums.square_mm2[static_cast<Eigen::Index>(m)] / samples);
  }
  error.mean_mm /= static_cast<double>(markers.size());
  error.rmse_mm /= static_cast<double>(markers.size());
  return error;
}

Sums& operator+=(Sums& sums, const Sums& more) {
  if (sums.samples == 0) return sums = more;
  sums.samples += more.samples;
  sums.distance_mm += more.distance_mm;
  sums.square_mm2 += more.square_mm2;
  return sums;
}

SensorsMethod summed(std::string name, std::size_t sensors, std::size_t method,
                     const std::vector<Outcome>& outcomes, const std::vector<Test>& tests,
                     const eyewear::MarkerSet& markers) {
  std::vector<std::size_t> every(markers.markers.size());
  for (std::size_t m = 0; m < every.size(); ++m) every[m] = m;
  const std::vector<std::size_t> eyes = markers.of(eyewear::MarkerRegion::eyes_nose);
  const std::vector<std::size_t> mouth = markers.of(eyewear::MarkerRegion::mouth);
  const auto row = [&](const Sums& sums) {
    return SensorsRow{over(sums, every), over(sums, eyes), over(sums, mouth)};
  };
  SensorsMethod out;
  out.name = std::move(name);
  out.sensors = sensors;
  Sums all;
  std::array<Sums, kTestSets> sets;
  std::vector<Sums> each(tests.size());
  for (const Outcome& outcome : outcomes) {
    Sums wearer;
    for (std::size_t t = 0; t < tests.size(); ++t) {
      const Sums& sums = outcome.methods[method][t];
      wearer += sums;
      each[t] += sums;
      sets[static_cast<std::size_t>(tests[t].set)] += sums;
    }
    out.wearers.push_back(row(wearer));
    all += wearer;
  }
  out.overall = row(all);
  for (std::size_t s = 0; s < kTestSets; ++s) out.sets[s] = row(sets[s]);
  for (const Sums& sums : each) out.tests.push_back(row(sums));
  for (const std::size_t m : every) out.markers.push_back(over(all, {m}));
  return out;
}

}  // namespace

std::string_view test_set_name(TestSet set) {
  constexpr std::array<std::string_view, kTestSets> kNames = {"neutral", "A", "B", "C"};
  return kNames[static_cast<std::size_t>(set)];
}

std::vector<std::uint16_t> ear_hook_sensors(const sensor::Rig& rig) {
  std::vector<std::uint16_t> sensors;
  for (std::uint16_t s = 0; s < rig.sensors.size(); ++s)
    if (rig.sensors[s].site == "jaw_joint" || rig.sensors[s].site == "lower_jaw") sensors.push_back(s);
  return sensors;
}

Result<SensorsStudy> study_sensors(const SensorsRequest& request, const sensor::Rig& rig,
                                   const eyewear::MarkerSet& markers, const Progress& progress) {
  if (request.wearers < 1 || request.poses < 1 || !(request.pose_s > 0) || !(request.test_s >= 1) ||
      request.samples < rig.sensors.size() + 2)
    return fail(ErrorCode::bad_usage,
                "the study needs a wearer, a pose, a second of each test, and more samples than sensors",
                "study sensors");
  MIEN_TRY_ASSIGN(const virt::EyewearFaults faults, virt::parse_eyewear_faults(rig.faults_toml, rig.name));
  const Random root = Random(request.seed).fork("sensors");
  MIEN_TRY_ASSIGN(const MarkerPoses poses,
                  MarkerPoses::measure(markers, kMeasuredBeforeS, root.fork("before")));
  const std::vector<Test> tests = make_tests(poses, root.fork("tests"));
  std::vector<Outcome> outcomes(static_cast<std::size_t>(request.wearers));
  Course course;
  const std::size_t whole = 2 * tests.size() * outcomes.size();
  const Progress by_test = [&](double, std::string_view) {
    const std::size_t done = course.done;
    if (!progress(static_cast<double>(done) / static_cast<double>(whole),
                  fmt::format("{} wearers, {} tests each", outcomes.size(), tests.size())))
      course.stop = true;
    return !course.stop;
  };
  MIEN_TRY(
      for_each_performer(outcomes.size(), request.threads, by_test, [&](std::size_t index) -> Result<void> {
        MIEN_TRY_ASSIGN(outcomes[index], wear(request, rig, markers, faults, poses, tests, index, course));
        return {};
      }));
  SensorsStudy study;
  for (const eyewear::Marker& marker : markers.markers) study.markers.push_back(marker.name);
  for (const Outcome& outcome : outcomes) study.training.push_back(outcome.training);
  const std::size_t sensors = rig.sensors.size();
  study.faithful = summed("faithful", sensors, 0, outcomes, tests, markers);
  study.faithful16 =
      summed("faithful16", sensors - ear_hook_sensors(rig).size(), 1, outcomes, tests, markers);
  study.mean_pose = summed("mean_pose", 0, 2, outcomes, tests, markers);
  study.curve_s = outcomes.front().curve_s;
  study.curve_mm = outcomes.front().curve_mm;
  return study;
}

}  // namespace mien::study
