#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace mien::solve {

/// How true the confidence of many frames and shapes is.
class Reliability {
 public:
  static constexpr std::size_t kBins = 10;
  struct Bin {
    double frames = 0, confidence = 0, within = 0;  ///< Sums.
  };

  /// `within`: whether it came true, counted so many times. `confidence` 0 to 1.
  void add(float confidence, bool within, double times = 1);
  void add(const Reliability& other);
  /// Expected calibration error: the mean distance between confidence and what came true, over bins of a
  /// tenth, each by its frames. 0 for no frames.
  [[nodiscard]] double expected_error() const;
  [[nodiscard]] const std::array<Bin, kBins>& bins() const { return bins_; }

 private:
  std::array<Bin, kBins> bins_{};
};

/// Area under the receiver operating characteristic: how probably a frame that came true has the higher
/// confidence of it and one that did not, equal ones a half. Confidences are told apart by thousandths.
class RocArea {
 public:
  RocArea() : bins_(kBins) {}
  /// `confidence` 0 to 1.
  void add(float confidence, bool within);
  void add(const RocArea& other);
  /// 0.5 where all came true, or none.
  [[nodiscard]] double area() const;

 private:
  static constexpr std::size_t kBins = 1000;
  struct Bin {
    double within = 0, beyond = 0;
  };
  std::vector<Bin> bins_;
};

}  // namespace mien::solve
