#pragma once

#include <cstddef>
#include <vector>

#include "mien/core/random.h"

namespace mien::train {

/// Where windows of a fixed length can lie in sequences of frames.
class WindowPlaces {
 public:
  /// `frames`: of each sequence. `window` 1 or more.
  WindowPlaces(std::vector<std::size_t> frames, std::size_t window);

  struct Place {
    std::size_t sequence = 0;
    std::size_t first = 0;  ///< Frame.
  };
  /// How many there are.
  [[nodiscard]] std::size_t count() const;
  /// Every place is as likely as every other, so long sequences count for more. There is at least one.
  [[nodiscard]] Place draw(Random& random) const;
  /// At most `most`, evenly spread, none over another.
  [[nodiscard]] std::vector<Place> even(std::size_t most) const;

 private:
  [[nodiscard]] std::size_t count_in(std::size_t sequence) const;

  std::vector<std::size_t> frames_;
  std::size_t window_;
};

}  // namespace mien::train
