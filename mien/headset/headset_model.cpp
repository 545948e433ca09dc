#include "mien/headset/headset_model.h"

#include <functional>
#include <future>
#include <span>
#include <utility>
#include <vector>

#include "mien/core/sha256.h"
#include "mien/model/network_parts.h"

namespace mien::headset {
namespace {

void add_network(const model::Architecture& architecture, const std::vector<model::Tensor>& network,
                 Sha256& to) {
  const std::string text = model::format_architecture(architecture);
  to.add(std::as_bytes(std::span(text)));
  for (const model::Tensor& tensor : network) to.add(std::as_bytes(std::span(tensor.values)));
}

std::string hash_of(const ViewsFile& file, model::Precision precision) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(model::precision_name(precision))));
  add_network(file.architecture, file.network, hash);
  if (const std::optional<ViewsMemory>& memory = file.memory) {
    add_network(memory->architecture, memory->network, hash);
    for (const model::LogisticMap& map : memory->judgements) {
      hash.add_value(map.offset);
      hash.add_value(map.slope);
    }
    hash.add(std::as_bytes(std::span(memory->mirrored_eye.weight)));
    hash.add_value(memory->mirrored_eye.bias);
  }
  return hash.hex();
}

}  // namespace

Result<std::shared_ptr<const HeadsetModel>> HeadsetModel::create(const ViewsFile& file,
                                                                 model::Precision precision) {
  // As long as all else here together: beside it.
  auto hash = std::async(std::launch::async, hash_of, std::cref(file), precision);
  MIEN_TRY_ASSIGN(model::ViewsNetwork network,
                  model::ViewsNetwork::create(file.architecture, file.network, precision));
  const auto made = std::shared_ptr<HeadsetModel>(new HeadsetModel(std::move(network)));
  if (file.memory) {
    MIEN_TRY_ASSIGN(made->memory_,
                    model::CausalNetwork::create(file.memory->architecture, file.memory->network, precision));
    made->judgements_ = file.memory->judgements;
    made->mirrored_eye_ = file.memory->mirrored_eye;
  }
  made->hash_ = hash.get();
  return made;
}

float HeadsetModel::probability(std::size_t judgement, float logit) const {
  return judgements_[judgement].at(logit);
}

}  // namespace mien::headset
