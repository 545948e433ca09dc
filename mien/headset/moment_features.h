#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "mien/face/shape_region.h"
#include "mien/headset/answer.h"
#include "mien/model/architecture.h"
#include "mien/model/views_network.h"

namespace mien::headset {

/// Of each place of a network of pictures, whether it has a view.
using Present = std::array<bool, model::kViews>;

/// What a network finds in the views of a wearer's face at rest.
struct RestFeatures {
  std::vector<float> features;  ///< kViews x features; empty: nothing is known.
  Present present{};            ///< Of which views.
  bool operator==(const RestFeatures&) const = default;
};

/// A feature so old is as good as none, s; ages are told as shares of it.
inline constexpr float kOldest_s = 0.1F;

/// What has been found at one moment, of which a network makes an answer.
struct MomentFeatures {
  std::vector<float> features;  ///< kViews x features; of a view that is missing what stands for it.
  Present present{};            ///< Which views are there.
  std::array<float, model::kViews> age_s{};  ///< How long ago each was taken, 0 to kOldest_s.
};

/// Features less those at rest; 0 where either is not known. `out`: as many numbers.
void features_from_rest(const MomentFeatures& moment, const RestFeatures& rest, std::span<float> out);

/// Where a memory's condition has the network of pictures' answer to the moment, which is its end.
[[nodiscard]] constexpr std::size_t moment_answer(std::size_t features) {
  return 2 * model::kViews * (features + 1) + 1;
}
/// Numbers of a moment that a memory reads, in their order: the features, what they are from rest, of each
/// view its age (1: kOldest_s or missing) and whether it is there, whether the face at rest is known, and
/// what `network` answers to this moment alone.
[[nodiscard]] constexpr std::size_t moment_condition(std::size_t features) {
  return moment_answer(features) + kAnswerOutputs;
}
/// Writes them; `condition`: moment_condition() numbers.
void read_moment(const model::ViewsNetwork& network, const MomentFeatures& moment, const RestFeatures& rest,
                 model::ViewsNetwork::Workspace& workspace, std::span<float> condition);

/// What a memory answers: what it would add to the moment's kAnswerOutputs (headset/answer.h), then of each
/// region of shapes and of the gaze the logit of the probability that the answer is right: that nothing hides
/// the region and the mean absolute error of its shapes is at most 0.1 (docs/reference/metrics.md), that of
/// the eyes' angles at most 0.1 rad. It adds as much of it as it doubts: nothing where that is surely right.
inline constexpr std::size_t kGazeJudgement = face::kShapeRegionCount;
inline constexpr std::size_t kJudgements = kGazeJudgement + 1;
inline constexpr std::size_t kMemoryOutputs = kAnswerOutputs + kJudgements;
inline constexpr float kRightWeight = 0.1F, kRightGaze_rad = 0.1F;
/// Makes answers of a memory's outputs: each is the moment's of the condition, and what is added to it times
/// the probability that its judgement gives to being wrong.
void add_moment_answer(std::span<const float> condition, std::span<float, kMemoryOutputs> outputs);
/// The judgement that doubts an output: its shape's region's; of the tongue the jaw's, of lids' gaps and
/// pupils the eyes'.
[[nodiscard]] std::size_t judgement_of(std::size_t output);
/// The half of the face that it is of: 0 the upper one, with the eyes; 1 the lower one.
[[nodiscard]] std::size_t half_of_face(std::size_t judgement);
/// The answer's outputs that a judgement is about: the region's shapes.
[[nodiscard]] const std::array<std::vector<std::size_t>, kJudgements>& judged_outputs();
/// The error of such an output that is right, in the outputs' range.
[[nodiscard]] float right_output_error(std::size_t judgement);

}  // namespace mien::headset
