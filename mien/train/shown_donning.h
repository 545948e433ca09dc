#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "mien/core/random.h"
#include "mien/headset/moment_features.h"
#include "mien/model/views_network.h"
#include "mien/synthetic/headset/headset_film.h"
#include "mien/train/film_answers.h"
#include "mien/train/view_augmentation.h"
#include "mien/train/view_obstacle.h"

namespace mien::train {

/// How a donning of a headset's films is shown to its network of pictures.
struct Way {
  bool mirrored = false;
  std::array<ViewLook, model::kViews> looks;
  bool spoilt = false;
  std::array<std::optional<ViewObstacle>, model::kViews> obstacles;
};

/// Of ways 0, 1, ...: odd ones are mirrored, from 2 on other mountings and cameras show it, some with
/// something before a view. Its `frames` are at rest up to `rest`.
[[nodiscard]] Way draw_way(std::size_t number, std::size_t rest, std::size_t frames, Random& random);

/// What the network finds in a donning, and what it should be taken for.
struct Found {
  std::vector<float> features, wanted;
  std::vector<std::array<bool, 2>> visible;
};
[[nodiscard]] Found find_in_donning(const synthetic::HeadsetFilm& film,
                                    const synthetic::HeadsetFilm::Donning& donning, const FilmPlaces& places,
                                    const Way& way, const model::ViewsNetwork& network,
                                    model::ViewsNetwork::Workspace& memory, Random& random);

/// What is found of a donning's rest, in the mean over its first `rest_end` frames.
[[nodiscard]] headset::RestFeatures rest_of(std::span<const float> features, std::size_t rest_end,
                                            const FilmPlaces& places, const Way& way);

}  // namespace mien::train
