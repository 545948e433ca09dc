#include "mien/face/gltf/arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "mien/core/bytes.h"

namespace mien::face::gltf {
namespace {

template <class T>
double load(const unsigned char* from) {
  ByteReader reader(std::as_bytes(std::span(from, sizeof(T))));
  return static_cast<double>(reader.little<T>());
}

double component(const unsigned char* from, int type, bool normalized) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return normalized ? std::max(load<std::int8_t>(from) / 127, -1.0) : load<std::int8_t>(from);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return normalized ? load<std::uint8_t>(from) / 255 : load<std::uint8_t>(from);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return normalized ? std::max(load<std::int16_t>(from) / 32767, -1.0) : load<std::int16_t>(from);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return normalized ? load<std::uint16_t>(from) / 65535 : load<std::uint16_t>(from);
    case TINYGLTF_COMPONENT_TYPE_INT:
      return load<std::int32_t>(from);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return load<std::uint32_t>(from);
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return load<float>(from);
    default:
      return load<double>(from);
  }
}

}  // namespace

Result<std::vector<double>> Arrays::read(int index, std::size_t width,
                                         std::optional<std::size_t> expected) const {
  const tinygltf::Accessor* accessor = at(model_.accessors, index);
  if (accessor == nullptr) return bad("an accessor that is not there is named");
  const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor->type));
  if (components != static_cast<int>(width)) return bad(fmt::format("accessor {} has the wrong type", index));
  if (expected && accessor->count != *expected)
    return bad(fmt::format("accessor {} has {} elements where {} belong", index, accessor->count, *expected));
  if (!expected && accessor->count > kMaxTriangles * 3)
    return bad(fmt::format("accessor {} is too large", index));
  std::vector<double> values;
  if (accessor->bufferView >= 0) {
    MIEN_TRY_ASSIGN(values, strided(accessor->bufferView, accessor->byteOffset, accessor->componentType,
                                    width, accessor->count, accessor->normalized));
  } else if (expected) {
    values.assign(accessor->count * width, 0.0);
  } else {
    return bad(fmt::format("accessor {} has no data", index));
  }
  if (accessor->sparse.isSparse) {
    const auto& sparse = accessor->sparse;
    if (sparse.count < 0 || static_cast<std::size_t>(sparse.count) > accessor->count ||
        sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
      return bad(fmt::format("accessor {} is wrongly sparse", index));
    const auto count = static_cast<std::size_t>(sparse.count);
    MIEN_TRY_ASSIGN(const auto rows,
                    strided(sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
                            sparse.indices.componentType, 1, count, false));
    MIEN_TRY_ASSIGN(const auto changed,
                    strided(sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset),
                            accessor->componentType, width, count, accessor->normalized));
    for (std::size_t i = 0; i < count; ++i) {
      if (!(rows[i] >= 0 && rows[i] < static_cast<double>(accessor->count)))
        return bad(fmt::format("accessor {} is wrongly sparse", index));
      std::copy_n(changed.begin() + static_cast<std::ptrdiff_t>(i * width), width,
                  values.begin() + static_cast<std::ptrdiff_t>(rows[i]) * static_cast<std::ptrdiff_t>(width));
    }
  }
  for (const double v : values)
    if (!(std::abs(v) <= 1e9))
      return fail(ErrorCode::out_of_range, fmt::format("accessor {} holds a number beyond 1e9", index),
                  name_);
  return values;
}

std::unexpected<Error> Arrays::bad(std::string what) const {
  return fail(ErrorCode::malformed, std::move(what), name_);
}

Result<std::vector<double>> Arrays::strided(int view_index, std::size_t offset, int type, std::size_t width,
                                            std::size_t count, bool normalized) const {
  const tinygltf::BufferView* view = at(model_.bufferViews, view_index);
  if (view == nullptr) return bad("a buffer view that is not there is named");
  const tinygltf::Buffer* buffer = at(model_.buffers, view->buffer);
  if (buffer == nullptr) return bad("a buffer that is not there is named");
  const int size = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type));
  if (size <= 0) return bad("an accessor has an unknown number format");
  const std::size_t element = static_cast<std::size_t>(size) * width;
  const std::size_t stride = view->byteStride == 0 ? element : view->byteStride;
  const std::size_t have = buffer->data.size();
  // Every difference below is taken only after it is known not to be negative.
  if (view->byteOffset > have || view->byteLength > have - view->byteOffset)
    return fail(ErrorCode::truncated, "a buffer view reaches beyond its buffer", name_);
  if (count > 0 && (offset > view->byteLength || element > view->byteLength - offset ||
                    (count - 1) > (view->byteLength - offset - element) / stride))
    return fail(ErrorCode::truncated, "an accessor reaches beyond its buffer view", name_);
  std::vector<double> values;
  values.reserve(count * width);
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned char* row = buffer->data.data() + view->byteOffset + offset + i * stride;
    for (std::size_t c = 0; c < width; ++c)
      values.push_back(component(row + c * static_cast<std::size_t>(size), type, normalized));
  }
  return values;
}

}  // namespace mien::face::gltf
