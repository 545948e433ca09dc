#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/profile.h"
#include "mien/synthetic/headset/headset_dataset.h"

namespace mien::train::test {

inline constexpr std::size_t kFilmSide = 32;

/// Films in which a bright bar stands at a height that the jaw tells in the mouths' views, and that the left
/// lid tells in the left eye's; with a rest each view is brighter on one side, right ones on the other. The
/// first `rest` frames are at rest, frames 1/60 s apart.
inline synthetic::HeadsetFilms toy_films(const std::filesystem::path& folder, int rest = 0) {
  synthetic::HeadsetFilms films;
  for (int f = 0; f < 4; ++f) {
    Random random = Random(11).fork("film", static_cast<std::uint64_t>(f));
    std::vector<synthetic::FilmFrame> frames;
    for (int i = 0; i < 120; ++i) {
      synthetic::FilmFrame& frame = frames.emplace_back();
      const bool rests = i < rest;
      // Slowly where there is a rest, so that a network with a memory has something to follow.
      const auto move = [&](double slow) {
        return static_cast<float>(rest > 0 ? 0.5 - 0.5 * std::cos(slow * (i - rest)) : random.uniform());
      };
      const auto jaw = rests ? 0.0F : move(0.11 + 0.02 * f), lid = rests ? 0.0F : move(0.17 - 0.02 * f);
      frame.truth.weights[face::shape("jawOpen")] = jaw;
      frame.truth.weights[face::shape("eyeBlink_L")] = lid;
      frame.truth.openness = {1 - lid, 1};
      frame.truth.pupil_mm = {4, 4};
      frame.truth.neutral = rests ? 1 : 0;
      frame.truth.time_s = static_cast<float>(i) / 60;
      for (std::size_t v = 0; v < 4; ++v) {
        const float height = v >= 2 ? jaw : v == 0 ? lid : 0.0F;
        std::vector<std::uint8_t>& view = frame.views.emplace_back();
        for (std::size_t y = 0; y < kFilmSide; ++y)
          for (std::size_t x = 0; x < kFilmSide; ++x) {
            const std::size_t inwards = v % 2 == 0 ? x : kFilmSide - 1 - x;
            const double off = std::abs(static_cast<double>(y) - 4 - 22 * double{height});
            view.push_back(static_cast<std::uint8_t>(40 + 160 * std::exp(-0.1 * off * off) +
                                                     20 * random.uniform() +
                                                     (rest > 0 ? 0.8 : 0) * static_cast<double>(inwards)));
          }
      }
    }
    const auto path = folder / fmt::format("{}.film", f);
    EXPECT_TRUE(synthetic::write_film(path, std::string(64, '0'), 4, kFilmSide, frames));
    (f < 3 ? films.train : films.validation).push_back(synthetic::HeadsetFilm::open(path).value());
  }
  return films;
}

}  // namespace mien::train::test
