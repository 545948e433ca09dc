#include "mien/model/network_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/model/backbone.h"

namespace mien::model {
namespace {

using Json = nlohmann::json;

/// Beside NetworkKind.
constexpr std::array<std::string_view, 3> kKinds = {"window", "causal", "views"};

constexpr std::size_t Architecture::*kSizes[] = {
    &Architecture::layers, &Architecture::d_model, &Architecture::heads,     &Architecture::d_head,
    &Architecture::ffn,    &Architecture::window,  &Architecture::condition, &Architecture::outputs,
};
constexpr const char* kSizeNames[] = {"layers", "d_model", "heads",     "d_head",
                                      "ffn",    "window",  "condition", "outputs"};

}  // namespace

std::unexpected<Error> wrong_description(const std::exception& error, const std::string& where) {
  return fail(ErrorCode::malformed,
              fmt::format("the model's description is wrong: {}", excerpt(error.what(), kComplaintLetters)),
              where);
}

std::optional<std::vector<float>> take_tensor(std::string_view name, TensorFile& file) {
  const auto found = std::ranges::find(file.tensors, name, &Tensor::name);
  if (found == file.tensors.end()) return std::nullopt;
  std::vector<float> values = std::move(found->values);
  file.tensors.erase(found);
  return values;
}

Result<void> check_all_taken(const TensorFile& file, const std::string& where) {
  if (file.tensors.empty()) return {};
  return fail(ErrorCode::mismatch, fmt::format("tensor {:?} belongs to nothing", file.tensors[0].name),
              where);
}

std::string format_architecture(const Architecture& architecture) {
  Json json = {{"name", architecture.name}, {"kind", kKinds[static_cast<std::size_t>(architecture.kind)]}};
  for (std::size_t i = 0; i < std::size(kSizes); ++i) json[kSizeNames[i]] = architecture.*kSizes[i];
  if (architecture.kind == NetworkKind::views) {
    json["side"] = architecture.side;
    json["features"] = architecture.features;
    json["widths"] = architecture.widths;
  }
  return json.dump();
}

Result<Architecture> parse_architecture(std::string_view text, const std::string& where) {
  Architecture a;
  try {
    const Json from = Json::parse(text);
    // Files from before there were causal networks name no kind.
    const auto kind = std::ranges::find(kKinds, from.value("kind", std::string(kKinds[0])));
    if (kind == kKinds.end())
      return fail(ErrorCode::unsupported, "the model's network is of a kind that is not known here", where,
                  "update the program");
    a.kind = static_cast<NetworkKind>(kind - kKinds.begin());
    a.name = from.at("name").get<std::string>();
    // A wrong number becomes one that check() refuses.
    const auto whole = [](const Json& value) {
      return value.is_number_unsigned() ? value.get<std::size_t>() : std::numeric_limits<std::size_t>::max();
    };
    for (std::size_t i = 0; i < std::size(kSizes); ++i) a.*kSizes[i] = whole(from.at(kSizeNames[i]));
    if (a.kind == NetworkKind::views) {
      a.side = whole(from.at("side"));
      a.features = whole(from.at("features"));
      for (const Json& width : from.at("widths")) {
        a.widths.push_back(whole(width));
        if (a.widths.size() > kMostConvolutions) break;  // check() says so.
      }
    }
  } catch (const Json::exception& error) {
    return wrong_description(error, where);
  }
  if (const auto ok = check(a); !ok) return fail(ok.error().code, ok.error().what, where);
  return a;
}

Result<Architecture> architecture_of(TensorFile& file, std::string_view format, std::string_view version,
                                     std::string_view kind, const std::string& where) {
  if (file.metadata["format"] != format)
    return fail(ErrorCode::unsupported, fmt::format("this safetensors file is not {}", kind), where);
  if (const std::string& found = file.metadata["version"]; found != version)
    return fail(ErrorCode::unsupported,
                fmt::format("the model's version is \"{}\", not {}", excerpt(found), version), where,
                "update the program, or train the model anew");
  return parse_architecture(file.metadata["architecture"], where);
}

void add_network(const std::vector<Tensor>& network, TensorFile& file, std::string_view prefix) {
  for (const Tensor& tensor : network)
    file.tensors.push_back(
        {.name = std::string(prefix) + tensor.name, .shape = tensor.shape, .values = tensor.values});
}

Result<std::vector<Tensor>> take_network(const Architecture& architecture, TensorFile& file,
                                         const std::string& where, std::string_view prefix) {
  std::vector<Tensor> network;
  for (const TensorSpec& spec : network_tensors(architecture)) {
    const auto it = std::ranges::find(file.tensors, std::string(prefix) + spec.name, &Tensor::name);
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
