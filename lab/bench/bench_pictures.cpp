#include "lab/bench/bench_pictures.h"

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "lab/bench/clock.h"
#include "mien/core/files.h"
#include "mien/face/face.h"
#include "mien/render/infrared_scene.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/headset/headset_simulator.h"

namespace mien::lab {
namespace {

constexpr int kSide = 96;
constexpr int kPictureRounds = 5, kMoments = 8;

double pictures_per_s(const virt::HeadsetWearer& wearer, const virt::HeadsetFaults& faults,
                      std::uint64_t seed) {
  virt::HeadsetSimulator simulator(wearer, faults, Random(seed), kSide);
  std::vector<std::vector<std::uint8_t>> pictures;
  std::vector<std::span<std::uint8_t>> out;
  for (std::size_t c = 0; c < simulator.cameras(); ++c)
    pictures.emplace_back(static_cast<std::size_t>(simulator.size(c).width) *
                          static_cast<std::size_t>(simulator.size(c).height));
  for (auto& picture : pictures) out.emplace_back(picture);
  double best_s = std::numeric_limits<double>::max(), time_s = 0;
  const auto open = [](int moment) {
    virt::HeadsetPose pose;
    pose.weights[face::shape("jawOpen")] = 0.05F * static_cast<float>(moment % kMoments);
    return pose;
  };
  for (int round = 0; round < kPictureRounds; ++round) {
    const auto from = Clock::now();
    for (int m = 0; m < kMoments; ++m, time_s += 1.0 / 30) simulator.shoot(time_s, open(m), open(m + 1), out);
    best_s = std::min(best_s, seconds_since(from));
  }
  return kMoments * static_cast<double>(simulator.cameras()) / best_s;
}

double vs_single_rays(const virt::HeadsetWearer& wearer) {
  std::vector<Vec3f> places_m;
  std::vector<render::Lens> lenses;
  for (const virt::FittedCamera& camera : wearer.cameras) {
    places_m.push_back(camera.position_m);
    lenses.push_back(render::make_lens(camera.position_m, camera.look_at_m, camera.up,
                                       camera.field_of_view_rad, camera.radial_k1, kSide, kSide));
  }
  render::InfraredScene scene(wearer.face, wearer.looks, places_m);
  scene.pose(wearer.face.neutral_m, wearer.face.neutral_m, wearer.things_m);
  scene.light(wearer.lamps, 0, lenses);
  render::InfraredScene::Canvas canvas;
  std::vector<float> picture(std::size_t{kSide} * kSide);
  double drawn_s = std::numeric_limits<double>::max(), traced_s = drawn_s;
  for (int round = 0; round < kPictureRounds; ++round) {
    auto from = Clock::now();
    for (const render::Lens& lens : lenses) scene.draw(lens, 0, canvas, picture);
    drawn_s = std::min(drawn_s, seconds_since(from));
    from = Clock::now();
    for (const render::Lens& lens : lenses) scene.draw_by_rays(lens, picture);
    traced_s = std::min(traced_s, seconds_since(from));
  }
  return traced_s / drawn_s;
}

}  // namespace

Result<PictureFigures> measure_pictures(std::uint64_t seed) {
  MIEN_TRY_ASSIGN(const auto path, find_resource("rigs/headset.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(path));
  MIEN_TRY_ASSIGN(const virt::HeadsetFaults faults, virt::parse_headset_faults(rig.faults_toml, rig.name));
  MIEN_TRY_ASSIGN(const virt::HeadsetWearer wearer,
                  virt::draw_headset_wearer(rig, faults, Random(seed).fork("bench")));
  return PictureFigures{.pictures_per_s = pictures_per_s(wearer, faults, seed),
                        .vs_single_rays = vs_single_rays(wearer)};
}

}  // namespace mien::lab
