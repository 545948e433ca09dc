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
                  const Progress& progress) -> Result<std::vector<model::ModelFile>> {
      std::vector<model::ModelFile> out;
      for (const ShortTraining& training : trainings) {
        asked.push_back(training);
        MIEN_TRY_ASSIGN(dataset::TrainingData made, training.data(progress));
        out.push_back(tracker::test::tiny_causal_model(made.train.sensors, asked.size()));
        data.emplace(training.name, std::move(made));
      }
      return out;
    };
  }
};

}  // namespace mien::lab::test
