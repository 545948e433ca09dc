#include "mien/virtual/headset/headset_simulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/headset/headset_camera.h"
#include "tests/project_path.h"

namespace mien::virt::headset_simulator_test {
namespace {

using face::shape;

constexpr int kSide = 64;

const sensor::Rig& rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/headset.toml")).value();
  return rig;
}

HeadsetFaults faults() {
  return parse_headset_faults(rig().faults_toml, "rig").value();
}

const HeadsetWearer& wearer() {
  static const HeadsetWearer wearer = draw_headset_wearer(rig(), faults(), Random(3)).value();
  return wearer;
}

/// The pictures of one moment, and their truth.
struct Shot {
  std::vector<std::vector<std::uint8_t>> pictures;
  HeadsetTruth truth;
};

Shot shoot(HeadsetSimulator& simulator, double time_s, const HeadsetPose& first, const HeadsetPose& last) {
  Shot shot;
  std::vector<std::span<std::uint8_t>> out;
  for (std::size_t c = 0; c < simulator.cameras(); ++c)
    shot.pictures.emplace_back(static_cast<std::size_t>(simulator.size(c).width) *
                               static_cast<std::size_t>(simulator.size(c).height));
  for (auto& picture : shot.pictures) out.emplace_back(picture);
  shot.truth = simulator.shoot(time_s, first, last, out);
  return shot;
}

HeadsetPose pose(std::initializer_list<std::size_t> shapes, float weight) {
  HeadsetPose made;
  for (const std::size_t k : shapes) made.weights[k] = weight;
  return made;
}

double difference(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(int{a[i]} - int{b[i]});
  return sum / static_cast<double>(a.size());
}

TEST(HeadsetSimulator, TheSameStreamGivesTheSamePictures) {
  const auto film = [&] {
    HeadsetSimulator simulator(wearer(), faults(), Random(5), kSide);
    simulator.put_on();
    std::vector<Shot> shots;
    for (int i = 0; i < 3; ++i)
      shots.push_back(shoot(simulator, i / 30.0, pose({shape("jawOpen")}, 0.1F * static_cast<float>(i)),
                            pose({shape("jawOpen")}, 0.1F * static_cast<float>(i) + 0.02F)));
    return shots;
  };
  const std::vector<Shot> one = film(), two = film();
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].pictures, two[i].pictures) << i;
    EXPECT_EQ(one[i].truth.pupil_mm, two[i].truth.pupil_mm);
  }
  EXPECT_NE(one[0].pictures, one[1].pictures);
}

TEST(HeadsetSimulator, PicturesAreOfTheCamerasOwnSizeOrTheNetworks) {
  HeadsetSimulator whole(wearer(), faults(), Random(5));
  EXPECT_EQ(whole.cameras(), 4u);
  EXPECT_EQ(whole.size(0), (PictureSize{240, 240}));
  HeadsetSimulator view(wearer(), faults(), Random(5), kSide);
  EXPECT_EQ(view.size(3), (PictureSize{kSide, kSide}));
  const Shot large = shoot(whole, 0, {}, {}), small = shoot(view, 0, {}, {});
  // The crop's mean brightness is about that of the same part of the whole.
  const auto& crop = rig().sensors[0].camera->crop;
  double sum = 0, count = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 240; ++x)
      if (x >= 240 * crop[0] && x < 240 * (crop[0] + crop[2]) && y >= 240 * crop[1] &&
          y < 240 * (crop[1] + crop[3])) {
        sum += large.pictures[0][static_cast<std::size_t>(y * 240 + x)];
        ++count;
      }
  const double seen =
      std::accumulate(small.pictures[0].begin(), small.pictures[0].end(), 0.0) / (kSide * kSide);
  EXPECT_NEAR(seen / (sum / count), 1, 0.25);  // Each is exposed for itself.
}

TEST(HeadsetSimulator, TruthIsWhatTheFaceDoes) {
  HeadsetSimulator simulator(wearer(), faults(), Random(5), kSide);
  const HeadsetTruth open = shoot(simulator, 0, {}, {}).truth;
  EXPECT_FLOAT_EQ(open.openness[0], 1);
  EXPECT_FLOAT_EQ(open.openness[1], 1);
  const HeadsetTruth wink =
      shoot(simulator, 0.1, pose({shape("eyeBlink_L")}, 1), pose({shape("eyeBlink_L")}, 1)).truth;
  EXPECT_LT(wink.openness[0], 0.08F);
  EXPECT_GT(wink.openness[1], 0.95F);
  const HeadsetTruth left =
      shoot(simulator, 0.2, pose({shape("eyeLookOut_L"), shape("eyeLookIn_R")}, 0.5F), {}).truth;
  for (const Eigen::Vector2f& gaze : left.gaze_rad)
    EXPECT_NEAR(gaze.x(), 0.5 * face::kEyeTurnRadPerUnit, 1e-6);
  const double most = wearer().pupil_mm * (1 + 3 * faults().pupil_breath);
  EXPECT_GT(open.pupil_mm[0], 1);
  EXPECT_LT(open.pupil_mm[0], most);
}

TEST(HeadsetSimulator, EveryFailureIsSeen) {
  for (std::size_t f = 1; f < kHeadsetFailures; ++f) {
    const auto failure = static_cast<HeadsetFailure>(f);
    SCOPED_TRACE(failure_name(failure));
    EXPECT_EQ(failure_named(failure_name(failure)), failure);
    HeadsetSimulator simulator(wearer(), faults(), Random(7), kSide, failure);
    simulator.fail(false);
    const Shot free = shoot(simulator, 0, {}, {});
    EXPECT_EQ(free.truth.is_visible, (std::array{true, true}));
    simulator.fail(true);
    // Exposure follows.
    Shot failed;
    for (int i = 1; i < 12; ++i) failed = shoot(simulator, 0.1 * i, {}, {});
    using enum HeadsetFailure;
    const auto [upper, lower] = failed.truth.is_visible;
    const bool before_mouth = failure == hand || failure == cup || failure == mask || failure == moustache;
    // A cup may leave most of the lips.
    if ((before_mouth && failure != cup) || failure == smear) {
      EXPECT_FALSE(lower);
    }
    if (before_mouth || failure == dark) {
      EXPECT_TRUE(upper);
    }
    if (failure == covered) {
      EXPECT_NE(upper, lower) << "one lens";
    }
    if (failure == smear) {
      EXPECT_FALSE(upper);
    }
    if (failure == dark) {
      EXPECT_TRUE(lower);
    }
    double most = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      const double changed = difference(free.pictures[c], failed.pictures[c]);
      most = std::max(most, changed);
      // Eye cameras do not see what happens to the mouth.
      if (c < 2 && before_mouth) {
        EXPECT_LT(changed, 12);
      }
    }
    EXPECT_GT(most, 6);
  }
  EXPECT_FALSE(failure_named("sneeze"));
}

TEST(HeadsetSimulator, AnotherSeatShowsTheFaceElsewhere) {
  HeadsetSimulator simulator(wearer(), HeadsetFaults{}, Random(5), kSide);
  const Shot fitted = shoot(simulator, 0, {}, {});
  simulator.sit({.shift_m = Vec3(0.004, 0, 0)});
  const Shot shifted = shoot(simulator, 0.1, {}, {});
  EXPECT_GT(difference(fitted.pictures[0], shifted.pictures[0]), 3);
  simulator.sit({});
  EXPECT_LT(difference(fitted.pictures[0], shoot(simulator, 0.2, {}, {}).pictures[0]), 1.5);
}

TEST(HeadsetSimulator, ExposureFollowsTheLight) {
  HeadsetFaults plain;
  HeadsetSimulator simulator(wearer(), plain, Random(5), kSide, HeadsetFailure::sun);
  simulator.fail(false);
  const auto bright = [&](double time_s) {
    const Shot shot = shoot(simulator, time_s, {}, {});
    return std::count_if(shot.pictures[1].begin(), shot.pictures[1].end(),
                         [](std::uint8_t p) { return p == 255; });
  };
  bright(0);
  simulator.fail(true);
  const auto blinded = bright(0.033);
  auto later = blinded;
  for (int i = 1; i < 16; ++i) later = bright(0.1 * i);
  EXPECT_GT(blinded, 100);
  EXPECT_LT(later, blinded / 2);
}

TEST(HeadsetWearer, ACameraInsideTheHeadIsRefusedByItsName) {
  sensor::Rig wrong = rig();
  wrong.sensors[2].position_m = Vec3(0, -0.02, 0.05);
  const auto refused = draw_headset_wearer(wrong, {}, Random(1));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("mouth_L is inside the head"), std::string::npos)
      << refused.error().message();
  sensor::Rig none = rig();
  for (sensor::Mount& mount : none.sensors) mount.camera.reset();
  EXPECT_FALSE(draw_headset_wearer(none, {}, Random(1)));
}

TEST(HeadsetWearer, WhatLiesInsideEveryHeadDoesSoInThoseOfTheFamily) {
  int inside = 0;
  for (const double x_m : {-0.04, 0.0, 0.04})
    for (const double y_m : {-0.03, 0.0, 0.03, 0.06, 0.09})
      for (const double z_m : {0.03, 0.045, 0.06, 0.069}) {
        const Vec3 place_m(x_m, y_m, z_m);
        if (!headset::is_inside_every_head(place_m)) continue;
        ++inside;
        sensor::Rig wrong = rig();
        wrong.sensors[2].position_m = place_m;
        for (const std::uint64_t seed : {1U, 2U, 3U})
          EXPECT_FALSE(draw_headset_wearer(wrong, faults(), Random(seed))) << place_m.transpose();
      }
  EXPECT_GT(inside, 20);
}

TEST(HeadsetWearer, PeopleLookUnlike) {
  int glasses = 0, bearded = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const HeadsetWearer one = draw_headset_wearer(rig(), faults(), Random(seed)).value();
    EXPECT_EQ(one.cameras.size(), 4u);
    EXPECT_EQ(one.lamps.size(), 12u);
    glasses += one.looks.glasses.empty() ? 0 : 1;
    bearded += one.looks.beard.empty() ? 0 : 1;
  }
  EXPECT_GE(glasses, 1);
  EXPECT_LE(glasses, 14);
  EXPECT_GE(bearded, 6);
}

TEST(HeadsetSimulator, CropsThatAreNotSquareAreRefusedByTheirCamera) {
  EXPECT_TRUE(check_network_views(rig()));
  sensor::Rig wide = rig();
  wide.sensors[1].camera->size = {320, 240};
  const auto refused = check_network_views(wide);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("eye_R's crop"), std::string::npos) << refused.error().message();
}

TEST(CameraSensor, ABlurAsWideAsThePictureStaysInside) {
  HeadsetFaults blurred;
  blurred.blur_px = {10, 10};
  blurred.aperture_mm = {5, 5};
  blurred.focus_mm = {5, 5};
  for (const PictureSize size : {PictureSize{16, 16}, PictureSize{5, 40}, PictureSize{40, 5}}) {
    CameraSensor sensor(blurred, size, 0.06F, 0.003F, 1, Random(1));
    std::vector<float> light(static_cast<std::size_t>(size.width * size.height), 1.0F);
    std::vector<std::uint8_t> picture(light.size());
    sensor.expose(0, light, picture);
    // Even light stays even but for the corners' loss.
    EXPECT_LT(*std::ranges::max_element(light), 1.01F);
    EXPECT_GT(*std::ranges::min_element(light), 0.7F);
  }
}

TEST(HeadsetFaults, AreReadAndRefused) {
  const HeadsetFaults read = faults();
  EXPECT_EQ(read.seat_mm, 2);
  EXPECT_EQ(read.rolling_ms, 8);
  EXPECT_EQ(read.spectacles, 0.125);
  EXPECT_TRUE(parse_headset_faults("", "none"));
  for (const char* wrong :
       {"seat_mm = -1", "seat_mm = 100", "wind = 1", "gamma = 1", "gamma = [1, 0.5]",
        "jpeg_quality = [1, 70]", "spectacles = 2", "full_well = 0", "pupil_mm = [0, 4]"}) {
    const auto refused = parse_headset_faults(wrong, "rig");
    ASSERT_FALSE(refused) << wrong;
    EXPECT_NE(refused.error().message().find("rig"), std::string::npos);
  }
}

TEST(HeadsetFaults, BothRigsHaveTheSame) {
  const sensor::Rig diy = sensor::read_rig(project_path("rigs/headset_diy.toml")).value();
  EXPECT_EQ(parse_headset_faults(diy.faults_toml, "diy").value(), faults());
  EXPECT_TRUE(draw_headset_wearer(diy, faults(), Random(1)));
}

}  // namespace
}  // namespace mien::virt::headset_simulator_test
