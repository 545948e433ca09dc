#pragma once

#include <memory>
#include <string>

#include "mien/core/error.h"
#include "mien/headset/views_file.h"
#include "mien/model/views_network.h"

namespace mien::headset {

/// A network of pictures as a session uses it, by which its tracker and the reduction of its pictures are
/// made. Immutable: any number may share one.
class HeadsetModel {
 public:
  /// Errors: the network's (mismatch, out_of_range).
  [[nodiscard]] static Result<std::shared_ptr<const HeadsetModel>> create(const ViewsFile& file);

  [[nodiscard]] const model::ViewsNetwork& network() const { return network_; }
  /// SHA-256 of everything that its answers depend on: 64 lower-case hexadecimal digits.
  [[nodiscard]] const std::string& hash() const { return hash_; }

 private:
  HeadsetModel(model::ViewsNetwork network, std::string hash)
      : network_(std::move(network)), hash_(std::move(hash)) {}

  model::ViewsNetwork network_;
  std::string hash_;
};

}  // namespace mien::headset
