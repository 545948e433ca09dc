#include "lab/eyewear/minute_study.h"

#include <algorithm>
#include <array>
#include <functional>
#include <string_view>

#include "lab/eyewear/marker_capture.h"
#include "mien/eyewear/light_drift.h"
#include "mien/eyewear/marker_model.h"
#include "mien/mocap/outliers.h"
#include "mien/performer/mimic.h"
#include "mien/synthetic/eyewear/worn_glasses.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/eyewear/marker_poses.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

using eyewear::GridLight;
using eyewear::LightFrame;
using eyewear::Normalisation;
using face::BlendshapeWeights;

constexpr double kRemountM = 0.002;

/// How a wearer's glasses are treated after the first minute.
struct Condition {
  std::string_view name;
  double light = 1;        ///< Times as much of other light.
  double moved_m = 0;      ///< Taken off, and put on again this far off.
  bool renewed = true;     ///< Then five seconds of neutral.
  bool recentred = false;  ///< What a sensor reads at rest is followed as it drifts (eyewear::LightDrift).
};
constexpr std::array kConditions = {
    Condition{.name = "as they were"},
    Condition{.name = "remounted", .moved_m = kRemountM, .renewed = false},
    Condition{.name = "remounted_5s", .moved_m = kRemountM},
    Condition{.name = "dark", .light = 0},
    Condition{.name = "bright", .light = 3},
    Condition{.name = "recentred", .recentred = true},
    Condition{.name = "remounted_recentred", .moved_m = kRemountM, .renewed = false, .recentred = true}};

constexpr std::array<std::string_view, 4> kMethods = {"neutral", "linear", "learned", "learned16"};

/// What all wearers share.
struct MinuteCourse {
  const SensorsRequest& request;
  const sensor::Rig& rig;
  const builtin_face::MarkerSet& markers;
  const eyewear::MarkerNetworkFile& model;
  const MinuteScene& scene;
  virt::EyewearFaults faults;
  std::vector<SensorsTest> tests;         ///< One a motion where the scene has some.
  std::vector<std::string> sensors;       ///< Names of the photo-reflective ones.
  std::vector<std::uint8_t> on_the_hook;  ///< A flag each of these.
};

/// One wearer's sums: kTests a method, and a condition.
struct MinuteOutcome {
  std::array<std::vector<MarkerSums>, kMethods.size()> methods;
  std::array<std::vector<MarkerSums>, kConditions.size()> conditions;
};

Eigen::VectorXd as_vector(const LightFrame& light) {
  return Eigen::Map<const Eigen::VectorXf>(light.values.data(), std::ssize(light.values)).cast<double>();
}

/// The published model, fitted to frames of the first minute.
class LinearFit {
 public:
  LinearFit(const virt::EyewearFaults& faults, const builtin_face::PlacedMarkers& placed,
            const Random& random)
      : placed_(placed), capture_(faults, placed.neutral_m(), random) {}

  void see(double time_s, const GridLight& light, const BlendshapeWeights& weights) {
    lights_.push_back(light);
    captured_m_.push_back(capture_.capture(time_s, placed_.at(weights)));
  }

  Result<eyewear::MarkerModel> fit(const Normalisation& normalisation) const {
    Eigen::MatrixXd sensors(std::ssize(lights_), std::ssize(normalisation.sensors));
    Eigen::MatrixXd markers(std::ssize(captured_m_), captured_m_.front().size());
    LightFrame light;
    for (Eigen::Index i = 0; i < sensors.rows(); ++i) {
      eyewear::read_features(normalisation, lights_[static_cast<std::size_t>(i)], light);
      sensors.row(i) = as_vector(light).transpose();
      markers.row(i) = captured_m_[static_cast<std::size_t>(i)].transpose();
    }
    const mocap::Kept kept = mocap::reject_outliers(markers);
    const std::vector<Eigen::Index> rows(kept.rows.begin(), kept.rows.end());
    return eyewear::MarkerModel::fit(sensors(rows, Eigen::all), markers(rows, Eigen::all));
  }

 private:
  const builtin_face::PlacedMarkers& placed_;
  MarkerCapture capture_;
  std::vector<GridLight> lights_;
  std::vector<Eigen::VectorXd> captured_m_;
};

using SeeFeatures = std::function<void(std::size_t test, const LightFrame&, const Eigen::VectorXd& truth_m)>;

sensor::Rig recentring(sensor::Rig rig, bool recentre) {
  for (sensor::Mount& mount : rig.sensors) mount.recentre = recentre;
  return rig;
}

/// The tests one after the other.
void make_tests(const MinuteCourse& course, const Condition& condition, const Random& root,
                const builtin_face::PlacedMarkers& placed, const Normalisation& normalisation,
                synthetic::WornGlasses& session, const SeeFeatures& see) {
  LightFrame light;
  eyewear::LightDrift drift(recentring(course.rig, condition.recentred));
  for (std::size_t t = 0; t < course.tests.size(); ++t) {
    const auto look = [&](const GridLight& grid, const BlendshapeWeights& weights) {
      eyewear::read_features(normalisation, grid, light);
      drift.apply(1 / kFrameRateHz, light);
      see(t, light, placed.at(weights));
    };
    if (!course.scene.motions.empty()) {
      const face::Motion& motion = course.scene.motions[t];
      session.play(motion, motion.duration_s(), look);
      continue;
    }
    const std::array<performer::PoseCue, 1> cue = {performer::PoseCue{0, course.tests[t].target}};
    session.play(performer::mimic(cue, course.request.test_s, {}, root.fork("test", t)),
                 course.request.test_s, look);
  }
}

virt::EyewearFaults with_light(virt::EyewearFaults faults, double times) {
  for (double& share : faults.ambient) share *= times;
  return faults;
}

Result<void> wear_for_minute(const MinuteCourse& course, const virt::EyewearWearer& wearer,
                             const builtin_face::PlacedMarkers& placed, const Random& root, std::size_t which,
                             MinuteOutcome& out) {
  const Condition& condition = kConditions[which];
  virt::EyewearSimulator simulator(wearer, with_light(course.faults, condition.light), root.fork("glasses"));
  simulator.put_on();
  synthetic::WornGlasses session(simulator, course.rig);
  LinearFit linear(course.faults, placed, root.fork("capture"));
  double time_s = 0;
  Normalisation normalisation = session.first_minute(
      root.fork("minute"), [&](const GridLight& light, const BlendshapeWeights& weights) {
        if (which == 0) linear.see(time_s += 1 / kFrameRateHz, light, weights);
      });
  session.rest(kRestS);
  if (condition.moved_m > 0) {
    Random drawn = root.fork("remount");
    virt::EyewearSeat seat = simulator.seat();
    seat.shift_m += condition.moved_m * drawn.direction();
    simulator.sit(seat);
    if (condition.renewed) normalisation = session.hold_neutral(normalisation, root.fork("neutral"));
  }

  MIEN_TRY_ASSIGN(const auto all, eyewear::NetworkRegressor::create(course.model, course.sensors));
  MIEN_TRY_ASSIGN(const auto frame_only, eyewear::NetworkRegressor::create(course.model, course.sensors));
  const Eigen::VectorXd neutral_m = placed.at({});
  Eigen::VectorXd displacement_m;
  std::vector<MarkerSums>& sums = out.conditions[which];
  sums.resize(course.tests.size());
  if (which != 0) {
    make_tests(course, condition, root, placed, normalisation, session,
               [&](std::size_t t, const LightFrame& light, const Eigen::VectorXd& truth_m) {
                 all->step(light, displacement_m);
                 sums[t].add(Eigen::VectorXd(neutral_m + displacement_m), truth_m);
               });
    return {};
  }
  MIEN_TRY_ASSIGN(const eyewear::MarkerModel fitted, linear.fit(normalisation));
  for (std::vector<MarkerSums>& method : out.methods) method.resize(course.tests.size());
  make_tests(course, condition, root, placed, normalisation, session,
             [&](std::size_t t, const LightFrame& light, const Eigen::VectorXd& truth_m) {
               out.methods[0][t].add(neutral_m, truth_m);
               out.methods[1][t].add(fitted.markers(as_vector(light)), truth_m);
               all->step(light, displacement_m);
               out.methods[2][t].add(Eigen::VectorXd(neutral_m + displacement_m), truth_m);
               LightFrame without = light;
               for (std::size_t s = 0; s < without.present.size(); ++s)
                 if (course.on_the_hook[s] != 0) without.present[s] = 0;
               frame_only->step(without, displacement_m);
               out.methods[3][t].add(Eigen::VectorXd(neutral_m + displacement_m), truth_m);
             });
  sums = out.methods[2];
  return {};
}

}  // namespace

Result<MinuteStudy> study_minute(const SensorsRequest& request, const sensor::Rig& rig,
                                 const builtin_face::MarkerSet& markers,
                                 const eyewear::MarkerNetworkFile& model, const MinuteScene& scene,
                                 const Progress& progress) {
  if (request.wearers < 1 || !(request.test_s >= 1))
    return fail(ErrorCode::bad_usage, "the study needs a wearer and a second of each test", "study sensors");
  if (!std::ranges::equal(model.markers, markers.markers, {}, {}, &builtin_face::Marker::name))
    return fail(ErrorCode::mismatch, "the model answers with other markers than the study has", markers.name,
                "train a model with these markers");
  for (const face::Motion& motion : scene.motions)
    if (motion.frames.empty())
      return fail(ErrorCode::bad_usage, "a motion without frames tests nothing", motion.name);
  MinuteCourse course{request, rig, markers, model, scene, {}, {}, {}, {}};
  MIEN_TRY_ASSIGN(course.faults, virt::parse_eyewear_faults(rig.faults_toml, rig.name));
  const Random root = Random(request.seed).fork("sensors");
  MIEN_TRY_ASSIGN(const virt::MarkerPoses poses,
                  virt::MarkerPoses::measure(markers, virt::kMeasuredBeforeS, root.fork("before")));
  course.tests = scene.motions.empty() ? make_sensors_tests(poses, root.fork("tests"))
                                       : std::vector<SensorsTest>(scene.motions.size());
  const std::vector<std::uint16_t> hooks = ear_hook_sensors(rig);
  course.sensors = eyewear::photo_sensor_names(rig);
  for (const std::uint16_t s : eyewear::photo_sensors(rig))
    course.on_the_hook.push_back(std::ranges::find(hooks, s) != hooks.end() ? 1 : 0);

  const auto wearers = static_cast<std::size_t>(request.wearers);
  std::vector<MinuteOutcome> outcomes(wearers);
  MIEN_TRY(virt::for_each_performer(
      wearers * kConditions.size(), request.threads, progress, [&](std::size_t job) -> Result<void> {
        const std::size_t index = job / kConditions.size();
        const Random own = Random(request.seed).fork("sensors", index);
        MIEN_TRY_ASSIGN(const virt::EyewearWearer wearer,
                        scene.face ? virt::seat_eyewear(*scene.face, rig, course.faults, own.fork("wearer"))
                                   : virt::draw_eyewear_wearer(rig, course.faults, own.fork("wearer")));
        MIEN_TRY_ASSIGN(const builtin_face::PlacedMarkers placed,
                        builtin_face::PlacedMarkers::place(wearer.face, markers));
        return wear_for_minute(course, wearer, placed, own, job % kConditions.size(), outcomes[index]);
      }));

  MinuteStudy study;
  const std::size_t sensors = course.sensors.size();
  const std::array<std::size_t, kMethods.size()> used = {0, sensors, sensors, sensors - hooks.size()};
  const auto gather = [&](auto&& of) {
    std::vector<std::vector<MarkerSums>> sums;
    for (const MinuteOutcome& outcome : outcomes) sums.push_back(of(outcome));
    return sums;
  };
  for (std::size_t m = 0; m < kMethods.size(); ++m)
    study.methods.push_back(sum_up(std::string(kMethods[m]), used[m],
                                   gather([m](const MinuteOutcome& o) { return o.methods[m]; }), course.tests,
                                   markers));
  for (std::size_t c = 1; c < kConditions.size(); ++c)
    study.conditions.push_back(sum_up(std::string(kConditions[c].name), sensors,
                                      gather([c](const MinuteOutcome& o) { return o.conditions[c]; }),
                                      course.tests, markers));
  return study;
}

}  // namespace mien::lab
