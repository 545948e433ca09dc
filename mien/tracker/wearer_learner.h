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

/// Learns a wearer while a session goes on (personalise()): keeps the features of the expressions that are
/// asked for, learns from them on a thread of its own, and hands out what was learnt at a frame that is known
/// beforehand, so that live and replay give the same bits. Belongs to one thread.
class WearerLearner {
 public:
  /// `rig_sensors` names the entries of the features that will come.
  explicit WearerLearner(std::vector<std::string> rig_sensors) : rig_sensors_(std::move(rig_sensors)) {}

  /// One of the expressions, in their order and before the first begins.
  void expect(const PromptedExpression& asked);
  /// Forgets what was expected and what is being learnt. Waits only for one that was forgotten before and is
  /// not over.
  void cancel();

  struct Learnt {
    std::vector<float>
        slopes;           ///< model::Skin::wearer: learnt, or the standard's; empty: neither could be told.
    sensor::Score score;  ///< "wearer".
  };
  /// The next frame. Keeps it while expressions are asked for, starts learning for `file` after the last, and
  /// returns what was learnt once, at the first frame kWearerLearnt after it; waits there if it must.
  /// Allocates while expressions are asked for.
  [[nodiscard]] std::optional<Learnt> add(const model::FeatureFrame& features, const model::ModelFile& file);

 private:
  std::vector<std::string> rig_sensors_;
  std::vector<PromptedExpression> asked_;
  std::vector<model::FeatureFrame> seen_;
  std::future<Learnt> running_;
  std::future<Learnt> abandoned_;  // A future's end waits for its work; this one's nobody hears.
};

}  // namespace mien::tracker
