#include "mien/headset/headset_model.h"

#include <span>
#include <string>
#include <utility>

#include "mien/core/sha256.h"
#include "mien/model/network_parts.h"

namespace mien::headset {

Result<std::shared_ptr<const HeadsetModel>> HeadsetModel::create(const ViewsFile& file) {
  MIEN_TRY_ASSIGN(model::ViewsNetwork network, model::ViewsNetwork::create(file.architecture, file.network));
  const std::string architecture = model::format_architecture(file.architecture);
  Sha256 hash;
  hash.add(std::as_bytes(std::span(architecture)));
  for (const model::Tensor& tensor : file.network) hash.add(std::as_bytes(std::span(tensor.values)));
  return std::shared_ptr<const HeadsetModel>(new HeadsetModel(std::move(network), hash.hex()));
}

}  // namespace mien::headset
