#include "mien/synthetic/imu/dataset_file.h"

#include <gtest/gtest.h>

#include <functional>

#include "mien/core/files.h"
#include "mien/model/safetensors.h"
#include "tests/folder.h"
#include "tests/synthetic/imu/toy_training_data.h"

namespace mien::synthetic::dataset_file_test {
namespace {

dataset::TrainingData toy() {
  const std::vector<std::string> sensors = {"mentalis", "buccinator_L", "frontalis_R"};
  dataset::TrainingData data{test::toy_dataset(sensors, 5), test::toy_dataset(sensors, 2, 5)};
  data.validation.standard_slopes = data.train.standard_slopes;
  return data;
}

TEST(TrainingDataFile, GivesBackWhatWasWritten) {
  const mien::test::Folder folder;
  const dataset::TrainingData data = toy();
  ASSERT_TRUE(write_training_data(folder / "data.safetensors", data));
  const auto read = read_training_data(folder / "data.safetensors");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_TRUE(test::same(read->train, data.train));
  EXPECT_TRUE(test::same(read->validation, data.validation));
}

TEST(TrainingDataFile, WithoutAKnownSkinHasNone) {
  dataset::TrainingData data = toy();
  data.train.standard_slopes.clear();
  data.validation.standard_slopes.clear();
  for (dataset::Dataset* set : {&data.train, &data.validation})
    for (dataset::Sequence& sequence : set->sequences) sequence.slopes.clear();
  const auto read = parse_training_data(format_training_data(data), "data");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_TRUE(test::same(read->train, data.train));
}

/// What is changed in a sound file's arrays.
using Break = std::function<void(model::TensorFile&)>;

ErrorCode error_after(const Break& spoil) {
  model::TensorFile file = *model::parse_safetensors(format_training_data(toy()), "data");
  spoil(file);
  const auto read = parse_training_data(model::write_safetensors(file), "data");
  return read ? ErrorCode::internal : read.error().code;
}

model::Tensor& array(model::TensorFile& file, const std::string& name) {
  for (model::Tensor& tensor : file.tensors)
    if (tensor.name == name) return tensor;
  throw std::out_of_range(name);
}

TEST(TrainingDataFile, RefusesWhatDoesNotHoldTogether) {
  const auto shorter = [](const char* name) {
    return [name](model::TensorFile& file) {
      model::Tensor& tensor = array(file, name);
      tensor.values.resize(tensor.values.size() - tensor.shape[1]);
      --tensor.shape[0];
    };
  };
  EXPECT_EQ(error_after(shorter("train.1.present")), ErrorCode::malformed);
  EXPECT_EQ(error_after(shorter("train.1.weights")), ErrorCode::malformed);
  EXPECT_EQ(error_after(shorter("validation.0.slopes")), ErrorCode::malformed);
  EXPECT_EQ(error_after(shorter("standard_slopes")), ErrorCode::malformed);
  EXPECT_EQ(error_after([](auto& file) {
              file.tensors.pop_back();
              file.metadata.erase("dataset");
            }),
            ErrorCode::malformed);
  EXPECT_EQ(error_after([](auto& file) { file.metadata["dataset"] = "[1, 2"; }), ErrorCode::malformed);
  EXPECT_EQ(error_after([](auto& file) { file.metadata["dataset"] = R"({"sensors": []})"; }),
            ErrorCode::malformed);
  EXPECT_EQ(error_after([](auto& file) { array(file, "train.0.present").values[0] = 0.5F; }),
            ErrorCode::malformed);
  EXPECT_EQ(error_after([](auto& file) { array(file, "train.0.values").name = "train.9.values"; }),
            ErrorCode::malformed);
  EXPECT_EQ(error_after([](auto& file) {
              file.tensors.push_back({"more", {1, 1}, {0}});
            }),
            ErrorCode::malformed);
}

TEST(TrainingDataFile, OfAnotherKindIsRefused) {
  const mien::test::Folder folder;
  ASSERT_TRUE(write_file(folder / "no.safetensors", "no arrays"));
  EXPECT_FALSE(read_training_data(folder / "no.safetensors"));
  EXPECT_EQ(read_training_data(folder / "none.safetensors").error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::synthetic::dataset_file_test
