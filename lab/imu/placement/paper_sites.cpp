#include "lab/imu/placement/paper_sites.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <utility>

#include "mien/core/minimum_jerk.h"
#include "mien/core/units.h"
#include "mien/virtual/imu/skin_site.h"
#include "mien/virtual/performance.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

constexpr double kFeltRateHz = 240;

struct FullShape {
  std::size_t shape;
  float weight;  // At the movement's height.
};
using AreaMovement = std::vector<FullShape>;

/// What the muscles of an area do, one movement after the other.
std::vector<AreaMovement> movements_of(std::string_view area) {
  using face::shape;
  if (area == kPaperAreas[0])  // Brows raised.
    return {{{shape("browInnerUp_L"), 0.8F},
             {shape("browInnerUp_R"), 0.8F},
             {shape("browOuterUp_L"), 0.8F},
             {shape("browOuterUp_R"), 0.8F}}};
  if (area == kPaperAreas[1])  // A smile that reaches the cheeks.
    return {{{shape("mouthSmile_L"), 0.8F},
             {shape("mouthSmile_R"), 0.8F},
             {shape("cheekSquint_L"), 0.5F},
             {shape("cheekSquint_R"), 0.5F}}};
  return {{{shape("jawOpen"), 0.5F}},  // The jaw opens; corners pressed to the teeth; the chin raised.
          {{shape("mouthDimple_L"), 0.8F}, {shape("mouthDimple_R"), 0.8F}},
          {{shape("mouthShrugLower"), 0.8F}}};
}

std::string without_side(const std::string& name) {
  return name.ends_with("_L") || name.ends_with("_R") ? name.substr(0, name.size() - 2) : name;
}

struct FeltSums {
  double acceleration = 0, accelerometer = 0, rotation_square = 0, count = 0;

  void add(const FeltSums& other) {
    acceleration += other.acceleration;
    accelerometer += other.accelerometer;
    rotation_square += other.rotation_square;
    count += other.count;
  }
};

double variance_of(std::span<const Vec3> values) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& v : values) mean += v / static_cast<double>(values.size());
  double sum = 0;
  for (const Vec3& v : values) sum += (v - mean).squaredNorm();
  return sum / static_cast<double>(values.size());
}

/// One movement under one sensor.
FeltSums feel_movement(const virt::SkinSite& site, const AreaMovement& movement,
                       const std::array<float, face::kShapeCount>& gain, double rise_s) {
  const double whole_s = 2.5 * rise_s;
  const auto pose_at = [&](double time_s) {
    const double up = minimum_jerk(time_s / rise_s) - minimum_jerk((time_s - 1.5 * rise_s) / rise_s);
    face::BlendshapeWeights weights;
    for (const FullShape& full : movement)
      weights[full.shape] = static_cast<float>(up) * std::clamp(full.weight * gain[full.shape], 0.0F, 1.0F);
    return weights;
  };
  const double step_s = 1 / kFeltRateHz;
  const Vec3 gravity(0, kStandardGravity_m_s2, 0);
  std::vector<Vec3> acceleration, read;
  FeltSums sums{.count = 1};
  Vec3 before = site.position(pose_at(-step_s)), now = site.position(pose_at(0));
  const auto frames = static_cast<std::size_t>(std::ceil(whole_s * kFeltRateHz));
  for (std::size_t f = 0; f <= frames; ++f) {
    const double time_s = static_cast<double>(f) * step_s;
    const Vec3 next = site.position(pose_at(time_s + step_s));
    acceleration.emplace_back((next - 2 * now + before) / (step_s * step_s));
    const Quat rotation = site.rotation(pose_at(time_s));
    read.emplace_back(rotation.conjugate() * (acceleration.back() + gravity));
    sums.rotation_square += log_rotation(rotation).squaredNorm() / static_cast<double>(frames + 1);
    before = now;
    now = next;
  }
  sums.acceleration = variance_of(acceleration);
  sums.accelerometer = variance_of(read);
  return sums;
}

PaperAgreement agreement_of(const std::vector<PaperSiteFelt>& sites,
                            const std::function<double(const PaperSiteFelt&)>& felt) {
  PaperAgreement agreement;
  std::vector<double> all_paper, all_ours;
  for (std::size_t area = 0; area < kPaperAreas.size(); ++area) {
    std::vector<double> paper, ours;
    for (const PaperSiteFelt& site : sites) {
      if (site.site.area != kPaperAreas[area]) continue;
      paper.push_back(site.site.variation);
      ours.push_back(felt(site));
    }
    agreement.areas[area] = rank_correlation(paper, ours);
    for (std::vector<double>* values : {&paper, &ours}) {
      double mean = 0;
      for (const double v : *values) mean += v / static_cast<double>(values->size());
      for (const double v : *values) (values == &paper ? all_paper : all_ours).push_back(v / mean);
    }
  }
  agreement.all = rank_correlation(all_paper, all_ours);
  return agreement;
}

std::vector<double> ranks_of(const std::vector<double>& values) {
  std::vector<double> ranks;
  for (const double v : values) {
    const auto below = std::ranges::count_if(values, [v](double other) { return other < v; });
    const auto alike = std::ranges::count(values, v);
    ranks.push_back(static_cast<double>(below) + 0.5 * static_cast<double>(alike - 1));
  }
  return ranks;
}

}  // namespace

double rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> one = ranks_of(a), two = ranks_of(b);
  const double mean = 0.5 * (static_cast<double>(a.size()) - 1);
  double both = 0, first = 0, second = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    both += (one[i] - mean) * (two[i] - mean);
    first += (one[i] - mean) * (one[i] - mean);
    second += (two[i] - mean) * (two[i] - mean);
  }
  return first > 0 && second > 0 ? both / std::sqrt(first * second) : 0;
}

const PaperSite* paper_site_of(const SensorCandidate& candidate) {
  const std::string name = without_side(candidate.name);
  const auto found = std::ranges::find(kPaperSites, name, &PaperSite::name);
  return found == kPaperSites.end() ? nullptr : &*found;
}

Result<PaperSitesStudy> study_paper_sites(const PaperSitesRequest& request, const sensor::Rig& rig,
                                          const Progress& progress) {
  const std::vector<std::uint16_t> face_sensors = rig.face_sensors();
  std::vector<std::pair<std::uint16_t, std::size_t>> felt_at;  // Sensor and the table's site.
  for (const std::uint16_t s : face_sensors) {
    const std::string name = without_side(rig.sensors[s].name);
    const auto found = std::ranges::find(kPaperSites, name, &PaperSite::name);
    if (found != kPaperSites.end())
      felt_at.emplace_back(s, static_cast<std::size_t>(found - kPaperSites.begin()));
  }
  if (felt_at.empty())
    return fail(ErrorCode::bad_usage, "the rig has no candidate of the published table", rig.name,
                "use rigs/candidates.toml");
  std::vector<std::array<FeltSums, kPaperSites.size()>> felt(request.performers);
  MIEN_TRY(
      virt::for_each_performer(felt.size(), request.threads, progress, [&](std::size_t p) -> Result<void> {
        const Random root = Random(request.seed).fork("paper sites", p);
        const double share = std::fmod(static_cast<double>(p) * (std::numbers::phi - 1), 1.0);
        const virt::VirtualPerson person = virt::draw_person(root);
        MIEN_TRY_ASSIGN(std::vector<virt::SkinSite> sites, virt::skin_sites(person.face, rig));
        sites = virt::draw_kinematics(sites, virt::KinematicsSpread().times(share), root.fork("kinematics"));
        for (const auto& [sensor, site] : felt_at)
          for (const AreaMovement& movement : movements_of(kPaperSites[site].area))
            felt[p][site].add(feel_movement(sites[sensor], movement, person.style.gain, request.rise_s));
        return {};
      }));
  PaperSitesStudy study;
  for (std::size_t i = 0; i < kPaperSites.size(); ++i) {
    FeltSums sums;
    for (const auto& one : felt) sums.add(one[i]);
    if (!(sums.count > 0)) continue;
    study.sites.push_back({.site = kPaperSites[i],
                           .acceleration = sums.acceleration / sums.count,
                           .accelerometer = sums.accelerometer / sums.count,
                           .rotation_deg = kDegPerRad * std::sqrt(sums.rotation_square / sums.count)});
  }
  study.acceleration = agreement_of(study.sites, [](const PaperSiteFelt& s) { return s.acceleration; });
  study.accelerometer = agreement_of(study.sites, [](const PaperSiteFelt& s) { return s.accelerometer; });
  study.rotation = agreement_of(study.sites, [](const PaperSiteFelt& s) { return s.rotation_deg; });
  return study;
}

}  // namespace mien::lab
