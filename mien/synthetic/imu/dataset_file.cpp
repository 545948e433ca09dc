#include "mien/synthetic/imu/dataset_file.h"

#include <fmt/format.h>

#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "mien/core/files.h"
#include "mien/face/profile.h"
#include "mien/model/safetensors.h"

namespace mien::synthetic {
namespace {

using DatasetJson = nlohmann::json;

constexpr const char* kDatasetKey = "dataset";

void add_sequences(const char* set, const dataset::Dataset& data, model::TensorFile& file,
                   DatasetJson& told) {
  const std::size_t n = data.sensors.size();
  told[set] = DatasetJson::array();
  for (std::size_t i = 0; i < data.sequences.size(); ++i) {
    const dataset::Sequence& s = data.sequences[i];
    const auto add = [&](const char* what, std::vector<std::size_t> shape, std::vector<float> values) {
      file.tensors.push_back({fmt::format("{}.{}.{}", set, i, what), std::move(shape), std::move(values)});
    };
    add("values", {s.frames, 7 * n}, s.values);
    add("present", {s.frames, 2 * n}, {s.present.begin(), s.present.end()});
    add("weights", {s.frames, face::kShapeCount}, s.weights);
    if (!s.slopes.empty()) add("slopes", {3 * n, face::kShapeCount}, s.slopes);
    told[set].push_back({{"performer", s.performer}, {"lab", s.lab}, {"from_take", s.from_take}});
  }
}

/// The file's arrays by name, each taken once.
class Arrays {
 public:
  explicit Arrays(std::vector<model::Tensor> tensors) {
    for (model::Tensor& tensor : tensors) by_name_.emplace(tensor.name, std::move(tensor));
  }
  /// Nothing where there is none, or it is no matrix of so many columns.
  std::optional<model::Tensor> take(const std::string& name, std::size_t columns) {
    const auto found = by_name_.find(name);
    if (found == by_name_.end()) return std::nullopt;
    model::Tensor tensor = std::move(found->second);
    by_name_.erase(found);
    if (tensor.shape.size() != 2 || tensor.shape[1] != columns) return std::nullopt;
    return tensor;
  }
  [[nodiscard]] bool empty() const { return by_name_.empty(); }
  [[nodiscard]] bool has(const std::string& name) const { return by_name_.contains(name); }

 private:
  std::map<std::string, model::Tensor> by_name_;
};

Result<dataset::Sequence> sequence_of(const std::string& name, const DatasetJson& told, std::size_t n,
                                      Arrays& arrays, const std::string& where) {
  const auto wrong = [&](const char* what) {
    return fail(ErrorCode::malformed, fmt::format("{} of {} is missing or of another shape", what, name),
                where, "make the file again");
  };
  const auto flag = [&](const char* key) {
    return told.is_object() && told.contains(key) && told[key].is_boolean();
  };
  if (!flag("lab") || !flag("from_take") || !told.contains("performer") ||
      !told["performer"].is_number_unsigned() ||
      told["performer"].get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max())
    return wrong("the description");
  dataset::Sequence out;
  out.performer = told["performer"].get<std::uint32_t>();
  out.lab = told["lab"].get<bool>();
  out.from_take = told["from_take"].get<bool>();
  auto values = arrays.take(name + ".values", 7 * n);
  if (!values) return wrong("values");
  out.frames = values->shape[0];
  out.values = std::move(values->values);
  auto present = arrays.take(name + ".present", 2 * n);
  if (!present || present->shape[0] != out.frames) return wrong("present");
  for (const float there : present->values) {
    if (there != 0 && there != 1) return wrong("present");
    out.present.push_back(there != 0 ? 1 : 0);
  }
  auto weights = arrays.take(name + ".weights", face::kShapeCount);
  if (!weights || weights->shape[0] != out.frames) return wrong("weights");
  out.weights = std::move(weights->values);
  if (arrays.has(name + ".slopes")) {
    auto slopes = arrays.take(name + ".slopes", face::kShapeCount);
    if (!slopes || slopes->shape[0] != 3 * n) return wrong("slopes");
    out.slopes = std::move(slopes->values);
  }
  return out;
}

}  // namespace

std::vector<std::byte> format_training_data(const dataset::TrainingData& data) {
  model::TensorFile file;
  DatasetJson told = {{"sensors", data.train.sensors}};
  add_sequences("train", data.train, file, told);
  add_sequences("validation", data.validation, file, told);
  if (!data.train.standard_slopes.empty())
    file.tensors.push_back(
        {"standard_slopes", {3 * data.train.sensors.size(), face::kShapeCount}, data.train.standard_slopes});
  file.metadata[kDatasetKey] = told.dump();
  return model::write_safetensors(file);
}

Result<void> write_training_data(const std::filesystem::path& path, const dataset::TrainingData& data) {
  const std::vector<std::byte> bytes = format_training_data(data);
  return write_file(path, bytes);
}

Result<dataset::TrainingData> parse_training_data(std::span<const std::byte> bytes,
                                                  std::string_view where_view) {
  const std::string where(where_view);
  MIEN_TRY_ASSIGN(model::TensorFile file, model::parse_safetensors(bytes, where));
  const auto text = file.metadata.find(kDatasetKey);
  const DatasetJson told =
      text == file.metadata.end() ? DatasetJson() : DatasetJson::parse(text->second, nullptr, false);
  const auto wrong = [&](const std::string& what) {
    return fail(ErrorCode::malformed, what, where, "name a file that mien made to train on");
  };
  const auto list = [&](const char* key) {
    return told.is_object() && told.contains(key) && told[key].is_array();
  };
  if (!list("sensors") || !list("train") || !list("validation") || told["sensors"].empty())
    return wrong("it is no file of data to train on");
  dataset::TrainingData out;
  for (const DatasetJson& name : told["sensors"]) {
    if (!name.is_string()) return wrong("a sensor's name is no text");
    out.train.sensors.push_back(name.get<std::string>());
  }
  out.validation.sensors = out.train.sensors;
  const std::size_t n = out.train.sensors.size();
  Arrays arrays(std::move(file.tensors));
  for (const auto& [set, data] : {std::pair("train", &out.train), std::pair("validation", &out.validation)})
    for (std::size_t i = 0; i < told[set].size(); ++i) {
      MIEN_TRY_ASSIGN(data->sequences.emplace_back(),
                      sequence_of(fmt::format("{}.{}", set, i), told[set][i], n, arrays, where));
    }
  if (arrays.has("standard_slopes")) {
    auto slopes = arrays.take("standard_slopes", face::kShapeCount);
    if (!slopes || slopes->shape[0] != 3 * n) return wrong("the standard skin is of another shape");
    out.train.standard_slopes = out.validation.standard_slopes = std::move(slopes->values);
  }
  if (!arrays.empty()) return wrong("it holds arrays of no sequence");
  return out;
}

Result<dataset::TrainingData> read_training_data(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes,
                  read_file(path, std::numeric_limits<std::size_t>::max()));
  return parse_training_data(bytes, path.string());
}

}  // namespace mien::synthetic
