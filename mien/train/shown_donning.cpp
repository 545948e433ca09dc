#include "mien/train/shown_donning.h"

#include <cstdint>

#include "mien/headset/network_view.h"
#include "mien/virtual/headset/watched_parts.h"

namespace mien::train {
namespace {

using model::kViews;

/// Of a donning that is spoilt: that something comes before cameras; of eyes and of mouth, that it does so
/// there; then of each view.
constexpr double kHidden = 0.6, kHalfHidden = 0.6, kViewHidden = 0.85;

}  // namespace

Way draw_way(std::size_t number, std::size_t rest, std::size_t frames, Random& random) {
  Way way{.mirrored = number % 2 == 1, .looks = {}, .spoilt = number >= 2, .obstacles = {}};
  if (!way.spoilt) return way;
  for (ViewLook& look : way.looks) look = draw_look(random);
  if (!random.chance(kHidden)) return way;
  const std::array<bool, 2> halves = {random.chance(kHalfHidden), random.chance(kHalfHidden)};
  const ViewObstacle all = draw_obstacle(frames - rest, random);
  for (std::size_t v = 0; v < kViews; ++v) {
    if (!halves[v / 2] || !random.chance(kViewHidden)) continue;
    ViewObstacle& obstacle = way.obstacles[v].emplace(draw_obstacle(frames - rest, random));
    // What stands before one view stands before its neighbours at the same time.
    obstacle.begin = rest + all.begin;
    obstacle.end = rest + all.end;
    obstacle.is_glare = all.is_glare;
  }
  return way;
}

Found find_in_donning(const synthetic::HeadsetFilm& film, const synthetic::HeadsetFilm::Donning& donning,
                      const FilmPlaces& places, const Way& way, const model::ViewsNetwork& network,
                      model::ViewsNetwork::Workspace& memory, Random& random) {
  const std::size_t count = network.architecture().features, pixels = film.side() * film.side();
  const auto side = static_cast<int>(film.side());
  Found found;
  std::vector<std::uint8_t> shown, scratch;
  std::vector<float> views(kViews * pixels);
  for (std::size_t frame = donning.begin; frame < donning.end; ++frame) {
    std::array<bool, kViews> present{};
    virt::SeenHalves halves;
    const synthetic::FilmTruth truth = film.truth(frame);
    for (std::size_t v = 0; v < kViews; ++v) {
      const FilmPlace& place = places[way.mirrored ? v ^ 1U : v];
      if (!place.is_there) continue;
      present[v] = true;
      double covered = 0;
      const std::span<const std::uint8_t> view = film.view(frame, place.camera);
      shown.assign(view.begin(), view.end());
      if (way.spoilt) {
        show_as(way.looks[v], shown, side, scratch);
        if (way.obstacles[v]) covered = show_obstacle(*way.obstacles[v], frame - donning.begin, shown, side);
        spoil_view(shown, side, random);
      }
      halves.add(v / 2, covered);
      auto stretched = headset::NetworkView::create(place.view);
      stretched->make({.width = side, .height = side, .pixels = shown},
                      std::span(views).subspan(v * pixels, pixels));
    }
    const std::size_t begin = found.features.size();
    found.features.resize(begin + kViews * count);
    network.find(views, present, memory, std::span(found.features).subspan(begin));
    const auto [upper, lower] = halves.seen();
    found.visible.push_back({truth.visible[0] > 0 && upper, truth.visible[1] > 0 && lower});
    const auto wanted = answer_of(truth);
    const auto asked = way.mirrored ? mirrored_answer(wanted) : wanted;
    found.wanted.insert(found.wanted.end(), asked.begin(), asked.end());
  }
  return found;
}

headset::RestFeatures rest_of(std::span<const float> features, std::size_t rest_end, const FilmPlaces& places,
                              const Way& way) {
  headset::RestFeatures rest;
  const std::size_t each = rest_end > 0 ? features.size() / rest_end : 0;
  rest.features.assign(each, 0.0F);
  for (std::size_t frame = 0; frame < rest_end; ++frame)
    for (std::size_t i = 0; i < each; ++i)
      rest.features[i] += features[frame * each + i] / static_cast<float>(rest_end);
  for (std::size_t v = 0; v < kViews; ++v)
    rest.present[v] = rest_end > 0 && places[way.mirrored ? v ^ 1U : v].is_there;
  return rest;
}

}  // namespace mien::train
