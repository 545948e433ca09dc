#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/profile.h"

namespace mien::face {

/// A weight that is beyond a rule by no more than this obeys it.
inline constexpr float kRuleTolerance = 1e-6F;

/// Two shapes of which a face shows one: muscles that pull against each other.
struct ExclusivePair {
  std::size_t a = 0, b = 0;  ///< Indices in kShapeNames, not equal.
  /// As far as kRuleTolerance.
  [[nodiscard]] bool obeyed(const BlendshapeWeights& weights) const noexcept;
};

/// Shapes that are as a rule alike.
struct TogetherGroup {
  std::vector<std::size_t> shapes;  ///< Two at least, each once.
  float within = 0;  ///< Each lies within this of their mean, 0 to 1. 0: all take the mean (REFA, 1.3).
  [[nodiscard]] bool obeyed(const BlendshapeWeights& weights) const noexcept;
};

/// A shape that another allows: a <= f(b), such as a corrective.
struct Condition {
  struct Point {
    double b = 0, a = 0;  ///< Weights, 0 to 1.
  };
  std::size_t a = 0, b = 0;  ///< Indices in kShapeNames, not equal.
  std::vector<Point>
      at_most;  ///< f, piecewise linear by ascending b; level before the first and after the last.

  /// f(b).
  [[nodiscard]] double most(double b_weight) const noexcept;
  [[nodiscard]] bool obeyed(const BlendshapeWeights& weights) const noexcept;
};

/// What faces keep and no tracker knows: rules between shapes, read from a file (rigs/constraints/ict.toml;
/// format: docs/reference/constraints.md). In the live chain they are obeyed (project), in WeightSolver they
/// are costs and bounds. Immutable; thread-safe.
class RigConstraints {
 public:
  static constexpr std::size_t kMostRules = 512;

  RigConstraints() = default;
  static constexpr int kPasses = 8;

  /// Errors: malformed (TOML, unknown keys or shapes, a shape twice in a rule, points that do not ascend,
  /// conditions in a circle, rules that do not settle: of 1,000 random faces one is still moved by the last
  /// of kPasses passes), out_of_range (numbers, more than kMostRules); each with the line. `where` names the
  /// source.
  [[nodiscard]] static Result<RigConstraints> parse(std::string_view toml, const std::string& where);

  [[nodiscard]] const std::vector<ExclusivePair>& exclusive() const { return exclusive_; }
  [[nodiscard]] const std::vector<TogetherGroup>& together() const { return together_; }
  [[nodiscard]] const std::vector<Condition>& conditions() const { return conditions_; }

  /// Moves the weights (finite, 0 to 1) until they obey: of an exclusive pair the smaller becomes 0, of two
  /// equal ones b; a group is brought within its band of the mean; of a condition a is lowered. In this
  /// order, until nothing moves, kPasses passes at most; a rule that is broken even then gives up its shapes,
  /// which become 0. Weights that obey stay to the bit. No allocation.
  void project(BlendshapeWeights& weights) const noexcept;
  [[nodiscard]] bool obeyed(const BlendshapeWeights& weights) const noexcept;

 private:
  /// True where it moved something.
  bool pass(BlendshapeWeights& weights) const noexcept;

  std::vector<ExclusivePair> exclusive_;
  std::vector<TogetherGroup> together_;
  std::vector<Condition> conditions_;
};

/// rigs/constraints/ict.toml as it was when Mien was built: what holds of faces in general. Jaw and mouth go
/// one way at a time, lids do not widen while they close, both lids blink together as a rule, the lips close
/// only what the jaw opens.
[[nodiscard]] const RigConstraints& natural_constraints();

}  // namespace mien::face
