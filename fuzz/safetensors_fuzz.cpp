#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "mien/model/causal_network.h"
#include "mien/model/denoiser.h"
#include "mien/model/model_file.h"

/// Whatever is read can be written and is then read the same; whatever passes as a model can be run.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::model;
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  if (const auto file = parse_safetensors(bytes, "input")) {
    const auto again = parse_safetensors(write_safetensors(*file), "output");
    if (!again || again->tensors.size() != file->tensors.size()) std::abort();
  }
  if (const auto model = parse_model(bytes, "input")) {
    const bool causal = model->architecture.kind == NetworkKind::causal;
    const bool runs = causal ? CausalNetwork::create(model->architecture, model->network).has_value()
                             : Denoiser::create(model->architecture, model->network).has_value();
    if (!runs || !format_model(*model)) std::abort();
  }
  return 0;
}
