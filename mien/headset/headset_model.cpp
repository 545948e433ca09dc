#include "mien/headset/headset_model.h"

#include <span>
#include <string>
#include <utility>

#include "mien/core/sha256.h"
#include "mien/model/network_parts.h"

namespace mien::headset {

Result<std::shared_ptr<const HeadsetModel>> HeadsetModel::create(const ViewsFile& file,
                                                                 model::Precision precision) {
  MIEN_TRY_ASSIGN(model::ViewsNetwork network,
                  model::ViewsNetwork::create(file.architecture, file.network, precision));
  const std::string architecture = model::format_architecture(file.architecture);
  Sha256 hash;
  hash.add(std::as_bytes(std::span(architecture)));
  hash.add(std::as_bytes(std::span(model::precision_name(precision))));
  for (const model::Tensor& tensor : file.network) hash.add(std::as_bytes(std::span(tensor.values)));
  const auto made = std::shared_ptr<HeadsetModel>(new HeadsetModel(std::move(network)));
  if (file.memory) {
    MIEN_TRY_ASSIGN(made->memory_,
                    model::CausalNetwork::create(file.memory->architecture, file.memory->network, precision));
    made->judgements_ = file.memory->judgements;
    made->mirrored_eye_ = file.memory->mirrored_eye;
    const std::string of_memory = model::format_architecture(file.memory->architecture);
    hash.add(std::as_bytes(std::span(of_memory)));
    for (const model::Tensor& tensor : file.memory->network)
      hash.add(std::as_bytes(std::span(tensor.values)));
    for (const model::LogisticMap& map : made->judgements_) {
      hash.add_value(map.offset);
      hash.add_value(map.slope);
    }
  }
  made->hash_ = hash.hex();
  return made;
}

float HeadsetModel::probability(std::size_t judgement, float logit) const {
  return judgements_[judgement].at(logit);
}

}  // namespace mien::headset
