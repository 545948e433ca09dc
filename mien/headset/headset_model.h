#pragma once

#include <memory>
#include <optional>
#include <string>

#include "mien/core/error.h"
#include "mien/headset/views_file.h"
#include "mien/model/causal_network.h"
#include "mien/model/precision.h"
#include "mien/model/views_network.h"

namespace mien::headset {

/// What a session's networks multiply in: half of fp32's time and a quarter of the memory that each frame
/// reads. What it costs: docs/experiments/headset.md, "Precision".
inline constexpr model::Precision kHeadsetPrecision = model::Precision::int8;

/// A network of pictures as a session uses it, by which its tracker and the reduction of its pictures are
/// made. Immutable: any number may share one.
class HeadsetModel {
 public:
  /// Errors: the network's (mismatch, out_of_range).
  [[nodiscard]] static Result<std::shared_ptr<const HeadsetModel>> create(
      const ViewsFile& file, model::Precision precision = kHeadsetPrecision);

  [[nodiscard]] const model::ViewsNetwork& network() const { return network_; }
  /// What answers from frame to frame; null: each moment is answered by network() alone.
  [[nodiscard]] const model::CausalNetwork* memory() const { return memory_ ? &*memory_ : nullptr; }
  /// The probability that a judgement's logit of the memory's outputs stands for.
  [[nodiscard]] float probability(std::size_t judgement, float logit) const;
  [[nodiscard]] const MirroredEye& mirrored_eye() const { return mirrored_eye_; }
  /// SHA-256 of everything that its answers depend on: 64 lower-case hexadecimal digits.
  [[nodiscard]] const std::string& hash() const { return hash_; }

 private:
  explicit HeadsetModel(model::ViewsNetwork network) : network_(std::move(network)) {}

  model::ViewsNetwork network_;
  std::optional<model::CausalNetwork> memory_;
  std::array<model::LogisticMap, kJudgements> judgements_;
  MirroredEye mirrored_eye_;
  std::string hash_;
};

}  // namespace mien::headset
