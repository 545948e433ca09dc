#include "mien/model/safetensors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <fstream>
#include <istream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <spanstream>
#include <system_error>
#include <tuple>

#include "mien/core/bytes.h"
#include "mien/core/excerpt.h"
#include "mien/core/files.h"

namespace mien::model {
namespace {

using Json = nlohmann::json;
constexpr std::size_t kMaxRank = 8;
constexpr std::size_t kHeaderAlignment = 64;

/// An array as the header declares it; nothing here is believed yet.
struct Declared {
  std::string name;
  std::string type;
  std::vector<std::uint64_t> shape;
  std::vector<std::uint64_t> offsets;
  bool has_shape = false;
};

/// Takes the header's events one by one and allows only what the format does, so that neither depth nor width
/// of hostile JSON costs memory, and no name can be given twice.
class HeaderReader : public nlohmann::json_sax<Json> {
 public:
  std::vector<Declared> declared;
  std::map<std::string, std::string> metadata;
  std::string problem;

  bool null() override { return refuse("null stands where it may not"); }
  bool boolean(bool) override { return refuse("true or false stands where it may not"); }
  bool number_float(double, const std::string&) override { return refuse("a size is not a whole number"); }
  bool binary(binary_t&) override { return refuse("binary data stand where they may not"); }
  bool number_integer(std::int64_t value) override {
    return value < 0 ? refuse("a size is negative") : number_unsigned(static_cast<std::uint64_t>(value));
  }
  bool number_unsigned(std::uint64_t value) override {
    if (place_ == Place::shape && declared.back().shape.size() < kMaxRank) {
      declared.back().shape.push_back(value);
      return true;
    }
    if (place_ == Place::offsets && declared.back().offsets.size() < 2) {
      declared.back().offsets.push_back(value);
      return true;
    }
    return refuse("a number stands where it may not");
  }
  bool string(std::string& value) override {
    if (place_ == Place::metadata) {
      metadata[key_] = std::move(value);
      return true;
    }
    if (place_ == Place::tensor && key_ == "dtype") {
      declared.back().type = std::move(value);
      return true;
    }
    return refuse("a text stands where it may not");
  }
  bool start_object(std::size_t) override {
    if (place_ == Place::outside) return go(Place::top);
    if (place_ != Place::top) return refuse("an object stands where it may not");
    keys_.clear();
    if (key_ == "__metadata__") return go(Place::metadata);
    declared.push_back({.name = key_, .type = {}, .shape = {}, .offsets = {}});
    return go(Place::tensor);
  }
  bool key(std::string& name) override {
    auto& known = place_ == Place::top ? names_ : keys_;
    if (!known.insert(name).second) return refuse(fmt::format("{:?} stands there twice", name));
    key_ = std::move(name);
    return true;
  }
  bool end_object() override { return go(place_ == Place::top ? Place::end : Place::top); }
  bool start_array(std::size_t) override {
    if (place_ == Place::tensor && key_ == "shape") {
      declared.back().has_shape = true;
      return go(Place::shape);
    }
    if (place_ == Place::tensor && key_ == "data_offsets") return go(Place::offsets);
    return refuse("a list stands where it may not");
  }
  bool end_array() override { return go(Place::tensor); }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception&) override {
    return refuse(fmt::format("it is not JSON from byte {} on", position));
  }

 private:
  enum class Place { outside, top, metadata, tensor, shape, offsets, end };
  bool go(Place place) {
    place_ = place;
    return true;
  }
  bool refuse(std::string why) {
    problem = std::move(why);
    return false;
  }
  Place place_ = Place::outside;
  std::string key_;
  std::set<std::string> names_, keys_;
};

/// Number of elements, if it can be counted at all.
std::optional<std::uint64_t> element_count(const std::vector<std::uint64_t>& shape) {
  std::uint64_t count = 1;
  for (const std::uint64_t n : shape) {
    if (n != 0 && count > std::numeric_limits<std::uint64_t>::max() / n) return std::nullopt;
    count *= n;
  }
  return count;
}

/// Fills `values` with little-endian numbers; false where the stream ends before.
template <class T>
bool read_numbers(std::istream& from, std::span<T> values) {
  from.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size_bytes()));
  if (!from) return false;
  if constexpr (std::endian::native == std::endian::big)
    for (T& value : values) {
      auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
      std::ranges::reverse(bytes);
      value = std::bit_cast<T>(bytes);
    }
  return true;
}

/// The tensor whose bytes come next.
Result<Tensor> read_tensor(const Declared& declared, std::istream& from, const std::string& where) {
  Tensor tensor{.name = declared.name, .shape = {declared.shape.begin(), declared.shape.end()}, .values = {}};
  const std::size_t bytes = declared.offsets[1] - declared.offsets[0];
  bool whole = false;
  if (declared.type == "F32") {
    tensor.values.resize(bytes / sizeof(float));
    whole = read_numbers(from, std::span(tensor.values));
  } else {
    std::vector<std::uint16_t> halves(bytes / sizeof(std::uint16_t));
    whole = read_numbers(from, std::span(halves));
    tensor.values.reserve(halves.size());
    for (const std::uint16_t half : halves)
      tensor.values.push_back(std::bit_cast<float>(std::uint32_t{half} << 16U));
  }
  if (!whole)
    return fail(ErrorCode::truncated, fmt::format("the file ends inside tensor \"{}\"", excerpt(tensor.name)),
                where);
  if (!std::ranges::all_of(tensor.values, [](float value) { return std::isfinite(value); }))
    return fail(ErrorCode::out_of_range,
                fmt::format("tensor \"{}\" holds a number that is not finite", excerpt(tensor.name)), where);
  return tensor;
}

/// Rounds to nearest, ties to even; finite values only.
std::uint16_t to_bf16(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return static_cast<std::uint16_t>((bits + 0x7FFFU + ((bits >> 16U) & 1U)) >> 16U);
}

/// A file of `size` bytes, from its first on. Tensors are read to where they stay: a large file that is read
/// from the disk is nowhere twice.
Result<TensorFile> read_file_of(std::istream& from, std::uint64_t size, const std::string& where) {
  std::uint64_t header_size = 0;
  if (size < sizeof(header_size) || !read_numbers(from, std::span(&header_size, 1)))
    return fail(ErrorCode::truncated, "the file is shorter than a safetensors file can be", where);
  if (header_size > kMaxHeaderBytes)
    return fail(ErrorCode::malformed, "this is no safetensors file", where, "models are made by mien train");
  std::string header;
  if (header_size <= size - sizeof(header_size)) {
    header.resize(header_size);
    from.read(header.data(), static_cast<std::streamsize>(header_size));
  }
  if (header.size() != header_size || !from)
    return fail(ErrorCode::truncated, "the file ends inside its header", where);
  const std::uint64_t data_size = size - sizeof(header_size) - header_size;

  HeaderReader content;
  if (header.empty() || header[0] != '{' ||
      !Json::sax_parse(header.data(), header.data() + header.size(), &content))
    return fail(
        ErrorCode::malformed,
        fmt::format("the header is wrong: {}", content.problem.empty() ? "it is not JSON" : content.problem),
        where);

  for (const Declared& declared : content.declared) {
    const std::string name = fmt::format("tensor \"{}\"", excerpt(declared.name));
    if (declared.type != "F32" && declared.type != "BF16")
      return fail(ErrorCode::unsupported,
                  fmt::format("{} has the type \"{}\", not F32 or BF16", name, excerpt(declared.type)),
                  where);
    if (!declared.has_shape || declared.offsets.size() != 2)
      return fail(ErrorCode::malformed, name + " lacks its shape or its place", where);
    const std::uint64_t begin = declared.offsets[0], end = declared.offsets[1];
    if (begin > end || end > data_size)
      return fail(end > data_size ? ErrorCode::truncated : ErrorCode::malformed,
                  fmt::format("{} claims bytes {} to {} of {}", name, begin, end, data_size), where);
    const auto count = element_count(declared.shape);
    const std::uint64_t element = declared.type == "F32" ? 4 : 2;
    if (!count || *count > data_size || *count * element != end - begin)
      return fail(ErrorCode::malformed, name + " has a shape that does not fit its bytes", where);
  }
  std::ranges::sort(content.declared, {}, [](const Declared& d) { return std::tie(d.offsets, d.name); });
  std::uint64_t covered = 0;
  for (const Declared& declared : content.declared) {
    if (declared.offsets[0] != covered)
      return fail(ErrorCode::malformed,
                  fmt::format("tensor \"{}\" leaves a gap or overlaps another", excerpt(declared.name)),
                  where);
    covered = declared.offsets[1];
  }
  if (covered != data_size)
    return fail(ErrorCode::malformed, fmt::format("{} bytes belong to no tensor", data_size - covered),
                where);

  TensorFile file;
  file.metadata = std::move(content.metadata);
  for (const Declared& declared : content.declared) {
    MIEN_TRY_ASSIGN(Tensor tensor, read_tensor(declared, from, where));
    file.tensors.push_back(std::move(tensor));
  }
  return file;
}

}  // namespace

Result<TensorFile> parse_safetensors(std::span<const std::byte> bytes, std::string_view where) {
  std::ispanstream from(std::span(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  return read_file_of(from, bytes.size(), std::string(where));
}

Result<TensorFile> read_safetensors(const std::filesystem::path& path) {
  std::error_code code;
  const std::uintmax_t size = std::filesystem::file_size(path, code);
  std::ifstream file(path, std::ios::binary);
  if (!code && size > 0 && size <= kMaxFileBytes && file) return read_file_of(file, size, path.string());
  // There is none, it is too large, or it has no size, as a pipe.
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, read_file(path));
  return parse_safetensors(bytes, path.string());
}

std::vector<std::byte> write_safetensors(const TensorFile& file, TensorType type) {
  const std::size_t element = type == TensorType::f32 ? 4 : 2;
  nlohmann::ordered_json header = nlohmann::ordered_json::object();
  if (!file.metadata.empty()) header["__metadata__"] = file.metadata;
  std::size_t at = 0;
  for (const Tensor& tensor : file.tensors) {
    const std::size_t end = at + element * tensor.values.size();
    header[tensor.name] = {{"dtype", type == TensorType::f32 ? "F32" : "BF16"},
                           {"shape", tensor.shape},
                           {"data_offsets", {at, end}}};
    at = end;
  }
  std::string text = header.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  text.append((kHeaderAlignment - (8 + text.size()) % kHeaderAlignment) % kHeaderAlignment, ' ');

  ByteWriter writer;
  writer.little(static_cast<std::uint64_t>(text.size()));
  writer.append(text);
  for (const Tensor& tensor : file.tensors)
    for (const float value : tensor.values) {
      if (type == TensorType::f32)
        writer.little(value);
      else
        writer.little(to_bf16(value));
    }
  return writer.release();
}

}  // namespace mien::model
