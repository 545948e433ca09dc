#include "mien/train/window_places.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace mien::train {

WindowPlaces::WindowPlaces(std::vector<std::size_t> frames, std::size_t window)
    : frames_(std::move(frames)), window_(window) {}

std::size_t WindowPlaces::count_in(std::size_t sequence) const {
  return frames_[sequence] >= window_ ? frames_[sequence] - window_ + 1 : 0;
}

std::size_t WindowPlaces::count() const {
  std::size_t places = 0;
  for (std::size_t i = 0; i < frames_.size(); ++i) places += count_in(i);
  return places;
}

WindowPlaces::Place WindowPlaces::draw(Random& random) const {
  std::uint64_t place = random.below(count());
  std::size_t sequence = 0;
  for (; place >= count_in(sequence); ++sequence) place -= count_in(sequence);
  return {sequence, static_cast<std::size_t>(place)};
}

std::vector<WindowPlaces::Place> WindowPlaces::even(std::size_t most) const {
  std::vector<Place> all;
  for (std::size_t i = 0; i < frames_.size(); ++i)
    for (std::size_t first = 0; first + window_ <= frames_[i]; first += window_) all.push_back({i, first});
  const std::size_t count = std::min(most, all.size());
  std::vector<Place> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(all[i * all.size() / count]);
  return chosen;
}

}  // namespace mien::train
