#include "mien/model/network_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "mien/core/excerpt.h"

namespace mien::model {
namespace {

using Json = nlohmann::json;

constexpr const char* kKindWindow = "window";
constexpr const char* kKindCausal = "causal";
constexpr std::string_view kPrefix = "network.";

constexpr std::size_t Architecture::*kSizes[] = {
    &Architecture::layers, &Architecture::d_model, &Architecture::heads,     &Architecture::d_head,
    &Architecture::ffn,    &Architecture::window,  &Architecture::condition, &Architecture::outputs,
};
constexpr const char* kSizeNames[] = {"layers", "d_model", "heads",     "d_head",
                                      "ffn",    "window",  "condition", "outputs"};

}  // namespace

std::string format_architecture(const Architecture& architecture) {
  Json json = {{"name", architecture.name},
               {"kind", architecture.kind == NetworkKind::causal ? kKindCausal : kKindWindow}};
  for (std::size_t i = 0; i < std::size(kSizes); ++i) json[kSizeNames[i]] = architecture.*kSizes[i];
  return json.dump();
}

Result<Architecture> parse_architecture(std::string_view text, const std::string& where) {
  Architecture a;
  try {
    const Json from = Json::parse(text);
    // Files from before there were causal networks name no kind.
    const std::string kind = from.value("kind", kKindWindow);
    if (kind != kKindWindow && kind != kKindCausal)
      return fail(ErrorCode::unsupported, "the model's network is of a kind that is not known here", where,
                  "update the program");
    a.kind = kind == kKindCausal ? NetworkKind::causal : NetworkKind::window;
    a.name = from.at("name").get<std::string>();
    for (std::size_t i = 0; i < std::size(kSizes); ++i) {
      const Json& value = from.at(kSizeNames[i]);
      // A wrong number becomes one that check() refuses.
      a.*kSizes[i] =
          value.is_number_unsigned() ? value.get<std::size_t>() : std::numeric_limits<std::size_t>::max();
    }
  } catch (const Json::exception& error) {
    return fail(ErrorCode::malformed,
                fmt::format("the model's description is wrong: {}", excerpt(error.what(), kComplaintLetters)),
                where);
  }
  if (const auto ok = check(a); !ok) return fail(ok.error().code, ok.error().what, where);
  return a;
}

void add_network(const std::vector<Tensor>& network, TensorFile& file) {
  for (const Tensor& tensor : network)
    file.tensors.push_back(
        {.name = std::string(kPrefix) + tensor.name, .shape = tensor.shape, .values = tensor.values});
}

Result<std::vector<Tensor>> take_network(const Architecture& architecture, TensorFile& file,
                                         const std::string& where) {
  std::vector<Tensor> network;
  for (const TensorSpec& spec : network_tensors(architecture)) {
    const auto it = std::ranges::find(file.tensors, std::string(kPrefix) + spec.name, &Tensor::name);
    if (it == file.tensors.end())
      return fail(ErrorCode::mismatch, fmt::format("tensor {} is missing", spec.name), where);
    it->name = spec.name;
    network.push_back(std::move(*it));
    file.tensors.erase(it);
  }
  if (const auto ok = check_tensors(architecture, network); !ok)
    return fail(ErrorCode::mismatch, ok.error().what, where);
  return network;
}

}  // namespace mien::model
