#include "mien/model/network_correction.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "mien/core/sha256.h"

namespace mien::model {

namespace {

/// Tensors of the output layer, weights and bias, which come last.
constexpr std::size_t kOutputLayer = 2;

}  // namespace

std::string correction_key(std::span<const Tensor> network) {
  constexpr std::size_t kDigits = 16;
  Sha256 hash;
  for (const Tensor& tensor : network.last(std::min(kOutputLayer, network.size())))
    for (const float value : tensor.values) hash.add_value(value);
  return hash.hex().substr(0, kDigits);
}

Result<void> check_correction(const Correction& correction, const Architecture& architecture,
                              std::span<const Tensor> network, const std::string& where) {
  if (architecture.kind != NetworkKind::causal)
    return fail(ErrorCode::unsupported, "a window network's answers are not corrected", where,
                "use a live model, such as models/live.safetensors");
  if (correction.weights.size() != architecture.outputs * architecture.d_model ||
      correction.bias.size() != architecture.outputs)
    return fail(ErrorCode::mismatch, "the correction has another size than the network's output layer",
                where);
  if (correction.network != correction_key(network))
    return fail(ErrorCode::mismatch, "the correction was learnt for another model", where,
                "let the phone teach this one");
  const auto usual = [](float weight) { return std::abs(weight) <= kMostCorrection; };
  if (!std::ranges::all_of(correction.weights, usual) || !std::ranges::all_of(correction.bias, usual))
    return fail(ErrorCode::out_of_range, "the correction is larger than any that is learnt", where);
  return {};
}

std::vector<Tensor> corrected_network(std::span<const Tensor> network, const Correction& correction) {
  std::vector<Tensor> out(network.begin(), network.end());
  std::ranges::transform(out[out.size() - 2].values, correction.weights, out[out.size() - 2].values.begin(),
                         std::plus());
  std::ranges::transform(out.back().values, correction.bias, out.back().values.begin(), std::plus());
  return out;
}

}  // namespace mien::model
