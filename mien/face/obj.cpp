#include "mien/face/obj.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>

#include "mien/core/excerpt.h"

namespace mien::face {
namespace {

inline constexpr std::size_t kMaxElements = std::size_t{1} << 24U;

constexpr bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

/// Walks one line, word by word.
class Words {
 public:
  explicit Words(std::string_view line) : at_(line.data()), end_(line.data() + line.size()) {}

  std::string_view next() {
    while (at_ != end_ && is_space(*at_)) ++at_;
    const char* begin = at_;
    while (at_ != end_ && !is_space(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }
  /// The next number, or NaN where there is none in +-1e9.
  float number() {
    while (at_ != end_ && is_space(*at_)) ++at_;
    if (at_ != end_ && *at_ == '+') ++at_;
    double value = 0;  // As a double, so that a number too small for a float is zero and no error.
    const auto [end, code] = std::from_chars(at_, end_, value);
    const bool whole = code == std::errc{} && (end == end_ || is_space(*end)) && std::abs(value) <= 1e9;
    at_ = end;
    return whole ? static_cast<float>(value) : std::nanf("");
  }
  std::string_view rest() {
    while (at_ != end_ && is_space(*at_)) ++at_;
    while (end_ != at_ && is_space(end_[-1])) --end_;
    return {at_, static_cast<std::size_t>(end_ - at_)};
  }

 private:
  const char* at_;
  const char* end_;
};

/// The vertex of a corner such as "12", "12/3", "12//4" or "-1/3/4"; -1 when it names none.
std::int64_t corner_vertex(std::string_view corner, std::size_t vertices_so_far) {
  std::int64_t index = 0;
  const auto [end, code] = std::from_chars(corner.data(), corner.data() + corner.size(), index);
  if (code != std::errc{} || (end != corner.data() + corner.size() && *end != '/')) return -1;
  if (index < 0) index += static_cast<std::int64_t>(vertices_so_far) + 1;
  return index >= 1 ? index - 1 : -1;
}

}  // namespace

Result<ObjMesh> parse_obj(std::string_view text, std::string_view name, ObjContent content) {
  ObjMesh mesh;
  std::size_t line_number = 0;
  const auto bad = [&](ErrorCode code, std::string what) {
    return fail(code, std::move(what), fmt::format("{}, line {}", name, line_number));
  };
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    ++line_number;
    const void* found = std::memchr(at, '\n', static_cast<std::size_t>(end - at));
    const char* const line_end = found != nullptr ? static_cast<const char*>(found) : end;
    const std::string_view line(at, static_cast<std::size_t>(line_end - at));
    at = found != nullptr ? line_end + 1 : end;
    if (line.size() < 2) continue;

    if (line[0] == 'v' && is_space(line[1])) {
      Words words(line.substr(2));
      const float x = words.number();
      const float y = words.number();
      const float z = words.number();
      if (std::isnan(x) || std::isnan(y) || std::isnan(z))
        return bad(ErrorCode::malformed, "a vertex needs three finite numbers within 1e9");
      if (mesh.position.size() == kMaxElements)
        return bad(ErrorCode::out_of_range, "more than 16 million vertices");
      mesh.position.emplace_back(x, y, z);
    } else if (content == ObjContent::positions) {
      continue;
    } else if (line[0] == 'f' && is_space(line[1])) {
      Words words(line.substr(2));
      std::array<std::uint32_t, 3> corner{};
      std::size_t count = 0;
      for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
        const std::int64_t vertex = corner_vertex(word, mesh.position.size());
        if (vertex < 0 || vertex >= static_cast<std::int64_t>(kMaxElements))
          return bad(ErrorCode::out_of_range, fmt::format("the corner '{}' names no vertex", excerpt(word)));
        corner[count < 2 ? count : 2] = static_cast<std::uint32_t>(vertex);
        if (++count < 3) continue;
        if (mesh.triangles.size() == kMaxElements)
          return bad(ErrorCode::out_of_range, "more than 16 million triangles");
        mesh.triangles.push_back(corner);
        corner[1] = corner[2];
      }
      if (count < 3) return bad(ErrorCode::malformed, "a face needs at least three corners");
      if (mesh.groups.empty()) mesh.groups.emplace_back();
    } else if (line.starts_with("usemtl") && (line.size() == 6 || is_space(line[6]))) {
      const auto first = static_cast<std::uint32_t>(mesh.triangles.size());
      mesh.groups.push_back({std::string(Words(line.substr(6)).rest()), first, 0});
    }
  }
  if (mesh.position.empty()) return fail(ErrorCode::truncated, "there is no vertex in it", std::string(name));
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t vertex : triangle)
      if (vertex >= mesh.position.size())
        return fail(ErrorCode::out_of_range,
                    fmt::format("a face names vertex {} of {}", vertex + 1, mesh.position.size()),
                    std::string(name));
  for (std::size_t g = 0; g < mesh.groups.size(); ++g) {
    const std::size_t next =
        g + 1 < mesh.groups.size() ? mesh.groups[g + 1].first_triangle : mesh.triangles.size();
    mesh.groups[g].triangle_count = static_cast<std::uint32_t>(next - mesh.groups[g].first_triangle);
  }
  std::erase_if(mesh.groups, [](const ObjGroup& group) { return group.triangle_count == 0; });
  return mesh;
}

std::string format_obj(const Face& face, std::span<const Vec3f> vertices_m) {
  std::string text = fmt::format("# {}, metres\n", face.name);
  auto out = std::back_inserter(text);
  for (const Vec3f& v : vertices_m) fmt::format_to(out, "v {} {} {}\n", v.x(), v.y(), v.z());
  for (const Part& part : face.parts) {
    fmt::format_to(out, "g {}\nusemtl {}\n", part.name, part.name);
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
      const auto& [a, b, c] = face.triangles[t];
      fmt::format_to(out, "f {} {} {}\n", a + 1, b + 1, c + 1);
    }
  }
  return text;
}

}  // namespace mien::face
