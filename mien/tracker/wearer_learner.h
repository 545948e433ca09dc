#pragma once

#include <future>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/time.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/sensor/calibration.h"
#include "mien/tracker/prompted_expression.h"

namespace mien::tracker {

/// Personalisation during a session (personalise()): records the features of the prompted expressions, learns
/// from them on a thread of its own, and returns the result at a frame fixed in advance (kWearerLearnt after
/// the last prompt), so that live and replay give the same bits. One thread calls it.
class WearerLearner {
 public:
  /// `rig_sensors`: names of the features' entries.
  explicit WearerLearner(std::vector<std::string> rig_sensors) : rig_sensors_(std::move(rig_sensors)) {}

  /// A prompted expression; all are given in their order, before the first begins.
  void expect(const PromptedExpression& asked);
  /// Drops the expected expressions and the learning in progress. Blocks only where an earlier cancelled
  /// learning has not ended.
  void cancel();

  struct Learnt {
    std::vector<float> slopes;  ///< model::Skin::wearer: learnt, or the standard's where it is no better;
                                ///< empty: learning failed.
    sensor::Score score;        ///< "wearer".
  };
  /// The next frame. Records it during the prompts, starts learning for `file` after the last, and returns
  /// the result once, at the first frame kWearerLearnt after the last prompt; blocks there until it is ready.
  /// Allocates during the prompts.
  [[nodiscard]] std::optional<Learnt> add(const model::FeatureFrame& features, const model::ModelFile& file);

 private:
  std::vector<std::string> rig_sensors_;
  std::vector<PromptedExpression> asked_;
  std::vector<model::FeatureFrame> seen_;
  std::future<Learnt> running_;
  std::future<Learnt> abandoned_;  // Cancelled; a future's destructor waits for its task.
};

}  // namespace mien::tracker
