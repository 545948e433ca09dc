#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lab/imu/short_training.h"
#include "tests/tracker/tiny_model.h"

namespace mien::lab::test {

/// A trainer that trains nothing: models of the sensors that the data have, another for each training.
struct Untrained {
  std::vector<ShortTraining> asked;
  std::map<std::string, dataset::TrainingData> data;  ///< By the training's name.

  TrainShort trainer() {
    return [this](std::span<const ShortTraining> trainings,
                  const Progress& progress) -> Result<std::vector<ShortTrained>> {
      std::vector<ShortTrained> out;
      for (const ShortTraining& training : trainings) {
        asked.push_back(training);
        MIEN_TRY_ASSIGN(dataset::TrainingData made, training.data(progress));
        out.push_back({tracker::test::tiny_causal_model(made.train.sensors, asked.size()),
                       "step,seconds,windows,learning_rate,training_loss,validation_loss,validation_mse\n"
                       "1,0.5,32,0.004,0.9,0.8,0.07\n2,1.0,64,0.004,0.5,0.6,0.05\n"});
        data.emplace(training.name, std::move(made));
      }
      return out;
    };
  }
};

}  // namespace mien::lab::test
