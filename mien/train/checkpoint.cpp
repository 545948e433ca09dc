#include "mien/train/checkpoint.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "mien/core/excerpt.h"
#include "mien/core/files.h"

namespace mien::train {
namespace {

using Json = nlohmann::json;

struct Part {
  const char* name;
  std::vector<model::Tensor> Checkpoint::*tensors;
};
constexpr Part kParts[] = {{"weights/", &Checkpoint::weights},
                           {"adam_mean/", &Checkpoint::adam_mean},
                           {"adam_square/", &Checkpoint::adam_square},
                           {"average/", &Checkpoint::average},
                           {"best/", &Checkpoint::best}};

}  // namespace

Result<void> write_checkpoint(const std::filesystem::path& path, const Checkpoint& c) {
  model::TensorFile file;
  file.metadata = {{"format", "mien-checkpoint"},
                   {"run", c.run},
                   {"curve", c.curve},
                   {"state", Json{{"step", c.step},
                                  {"averagings", c.averagings},
                                  {"seconds", c.seconds},
                                  {"best_score", c.best_score},
                                  {"best_step", c.best_step},
                                  {"loss_sum", c.loss_sum},
                                  {"losses", c.losses}}
                                 .dump()}};
  for (const Part& part : kParts)
    for (const model::Tensor& tensor : c.*part.tensors) {
      file.tensors.push_back(tensor);
      file.tensors.back().name = part.name + tensor.name;
    }
  return write_file(path, model::write_safetensors(file));
}

Result<Checkpoint> read_checkpoint(const std::filesystem::path& path,
                                   const model::Architecture& architecture) {
  const std::string where = path.string();
  MIEN_TRY_ASSIGN(model::TensorFile file, model::read_safetensors(path));
  if (file.metadata["format"] != "mien-checkpoint")
    return fail(ErrorCode::malformed, "this is no checkpoint of a training run", where);
  Checkpoint c;
  c.run = file.metadata["run"];
  c.curve = file.metadata["curve"];
  try {
    const Json state = Json::parse(file.metadata["state"]);
    c.step = state.at("step").get<std::int64_t>();
    c.averagings = state.at("averagings").get<std::int64_t>();
    c.seconds = state.at("seconds").get<double>();
    c.best_score = state.at("best_score").get<double>();
    c.best_step = state.at("best_step").get<std::int64_t>();
    c.loss_sum = state.value("loss_sum", 0.0);  // Older checkpoints have neither.
    c.losses = state.value("losses", std::int64_t{0});
  } catch (const Json::exception& error) {
    return fail(ErrorCode::malformed,
                fmt::format("the checkpoint's state is wrong: {}", excerpt(error.what(), kComplaintLetters)),
                where);
  }
  const auto specs = model::network_tensors(architecture);
  auto tensor = file.tensors.begin();
  for (const Part& part : kParts)
    for (const model::TensorSpec& spec : specs) {
      if (tensor == file.tensors.end() || tensor->name != part.name + spec.name ||
          tensor->shape != spec.shape)
        return fail(ErrorCode::mismatch, fmt::format("{}{} is not where it belongs", part.name, spec.name),
                    where);
      tensor->name = spec.name;
      (c.*part.tensors).push_back(std::move(*tensor++));
    }
  return c;
}

}  // namespace mien::train
