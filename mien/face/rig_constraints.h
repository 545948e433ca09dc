#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/profile.h"

namespace mien::face {

/// A projected face is beyond a rule by no more than this.
inline constexpr float kRuleTolerance = 1e-6F;

/// Two shapes of which a face shows one: muscles that pull against each other.
struct ExclusivePair {
  std::size_t a = 0, b = 0;  ///< Indices in kShapeNames, not equal.
  [[nodiscard]] bool obeyed(const BlendshapeWeights& weights) const noexcept;
};

/// Shapes that are as a rule alike.
struct TogetherGroup {
  std::vector<std::size_t> shapes;  ///< Two at least, each once.
  float within = 0;  ///< Each lies within this of their mean, 0 to 1. 0: all take the mean (REFA, 1.3).
  /// As far as half of kRuleTolerance: what is clipped is rounded.
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

/// The rules of one use. Thread-safe where it is not changed.
struct RuleSet {
  static constexpr int kPasses = 8;

  std::vector<ExclusivePair> exclusive;
  std::vector<TogetherGroup> together;
  std::vector<Condition> conditions;  ///< One on a shape stands before those that go by that shape.

  /// Moves the weights until they obey: of an exclusive pair the smaller becomes 0, of two equal ones b; a
  /// group is brought within its band of the mean, and comes down to what pairs and conditions have lowered
  /// instead of raising that again; of a condition a is lowered. In this order, until nothing moves, kPasses
  /// passes at most; a rule that is broken even then gives up its shapes, which become 0. Weights that obey
  /// stay to the bit; what is not within 0 to 1 is brought there first, what is no number becomes 0. No
  /// allocation.
  void project(BlendshapeWeights& weights) const noexcept;
  /// Whether all weights are within 0 to 1 and every rule is obeyed.
  [[nodiscard]] bool obeyed(const BlendshapeWeights& weights) const noexcept;
  /// Whether the passes of project() alone bring the weights (0 to 1) to obey, and nothing has to give up.
  [[nodiscard]] bool settles(BlendshapeWeights& weights) const noexcept;
};

/// What faces keep and no tracker knows: rules between shapes, read from a file (rigs/constraints/ict.toml;
/// format: docs/reference/constraints.md), each for one use or more. In the live chain they are obeyed
/// (RuleSet::project), in WeightSolver they are costs and bounds. Immutable; thread-safe.
class RigConstraints {
 public:
  static constexpr std::size_t kMostRules = 512;
  static constexpr std::size_t kMostBytes = 1U << 20U;

  /// No rules.
  RigConstraints() = default;

  /// Errors: malformed (TOML, unknown keys or shapes, a shape twice in a rule, points that do not ascend,
  /// conditions in a circle, live rules that do not settle: one of 1,000 random faces does not obey after
  /// kPasses passes), out_of_range (numbers, more than kMostRules or kMostBytes); each with the line. `where`
  /// names the source.
  [[nodiscard]] static Result<RigConstraints> parse(std::string_view toml, const std::string& where);
  /// Errors: not_found, io, those of parse().
  [[nodiscard]] static Result<RigConstraints> read(const std::filesystem::path& path);

  /// For the live chain, where a session asks for them; those of always() among them.
  [[nodiscard]] const RuleSet& live() const { return live_; }
  /// For the live chain of every session, in every frame.
  [[nodiscard]] const RuleSet& always() const { return always_; }
  /// For WeightSolver.
  [[nodiscard]] const RuleSet& solve() const { return solve_; }

  /// The file, from which parse() makes equal rules: to the letter, but for letters beyond ASCII, which stand
  /// in comments alone and are question marks here.
  [[nodiscard]] const std::string& text() const { return text_; }
  /// Of one text.
  bool operator==(const RigConstraints& other) const { return text_ == other.text_; }

 private:
  std::string text_;
  RuleSet live_, always_, solve_;
};

/// rigs/constraints/ict.toml as it was when Mien was built: what holds of faces in general. The lips close
/// only what the jaw opens, always; jaw and mouth go one way at a time, lids do not widen while they close;
/// in the solver both lids blink together as a rule.
[[nodiscard]] const RigConstraints& natural_constraints();

}  // namespace mien::face
