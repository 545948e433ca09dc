#include "mien/face/gltf/container.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string_view>
#include <system_error>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/excerpt.h"
#include "mien/core/files.h"

namespace mien::face::gltf {
namespace fs = std::filesystem;
namespace {

inline constexpr std::size_t kMaxJsonDepth = 128;
constexpr const char* kExportAgain = "export it again, or use a copy from before it was damaged";

/// tinygltf walks JSON recursively: text that nests deeper than any real file must not reach it.
bool nests_too_deep(std::string_view json) {
  std::size_t depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (quoted) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxJsonDepth) return true;
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
    }
  }
  return false;
}

tinygltf::FsCallbacks callbacks(Folder& folder) {
  tinygltf::FsCallbacks c{};
  c.FileExists = [](const std::string& file, void* data) { return static_cast<Folder*>(data)->holds(file); };
  c.ExpandFilePath = [](const std::string& file, void*) { return file; };
  c.ReadWholeFile = [](std::vector<unsigned char>* out, std::string* error, const std::string& file,
                       void* data) {
    if (!static_cast<Folder*>(data)->holds(file)) {
      if (error != nullptr) *error += fmt::format("{} is not in the folder of the glTF", file);
      return false;
    }
    const auto bytes = read_file(file, kMaxBytes);
    if (!bytes || bytes->empty()) return false;
    out->resize(bytes->size());
    std::memcpy(out->data(), bytes->data(), bytes->size());
    return true;
  };
  c.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  c.user_data = &folder;
  return c;
}

std::string first_line(std::string text) {
  text.resize(std::min(text.find_first_of("\r\n"), text.size()));
  while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
  return excerpt(text, kComplaintLetters);
}

/// What tinygltf complains of, in our words, with what to do.
Error damage(const std::string& complaint, const std::string& name) {
  if (complaint.empty()) return {ErrorCode::malformed, "this is no glTF", name, kExportAgain};
  int line = 0, column = 0;
  if (const std::size_t at = complaint.find("parse error at line ");
      at != std::string::npos &&
      std::sscanf(complaint.c_str() + at, "parse error at line %9d, column %9d", &line, &column) == 2)
    return {ErrorCode::malformed, fmt::format("its JSON is broken at line {}, column {}", line, column), name,
            kExportAgain};
  constexpr std::string_view kMissing = "File not found : ";
  const std::string said = first_line(complaint);
  if (said.starts_with(kMissing))
    return {ErrorCode::malformed,
            fmt::format("a file that it names is not in its folder ({})", said.substr(kMissing.size())), name,
            "put that file there, or export it as a .glb, which is one file"};
  return {ErrorCode::malformed, fmt::format("it is damaged, or no sound glTF ({})", said), name,
          kExportAgain};
}

}  // namespace

bool Folder::holds(const std::string& file) const {
  if (path.empty()) return false;
  std::error_code code;
  const fs::path real = fs::weakly_canonical(file, code);
  if (code || !fs::is_regular_file(real, code)) return false;
  const fs::path relative = real.lexically_relative(path);
  return !relative.empty() && *relative.begin() != "..";
}

Result<tinygltf::Model> read_container(std::span<const std::byte> bytes, const std::string& name,
                                       Folder& folder) {
  if (bytes.empty()) return fail(ErrorCode::truncated, "the file is empty", name, kExportAgain);
  if (bytes.size() > kMaxBytes) return fail(ErrorCode::out_of_range, "the file is larger than 1 GiB", name);
  const bool binary = bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
  std::string_view json(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (binary) {
    ByteReader header(bytes.subspan(4));
    const auto version = header.little<std::uint32_t>();
    const auto length = header.little<std::uint32_t>();
    const auto json_length = header.little<std::uint32_t>();
    const auto kind = header.take(4);
    const auto chunk = header.take(json_length);
    if (!header.ok() || length > bytes.size())
      return fail(ErrorCode::truncated, "the file is cut short", name, kExportAgain);
    if (version != 2)
      return fail(ErrorCode::unsupported, fmt::format("this is glTF version {}, not 2", version), name);
    if (std::memcmp(kind.data(), "JSON", 4) != 0)
      return fail(ErrorCode::malformed, "the first chunk is not JSON", name, kExportAgain);
    json = {reinterpret_cast<const char*>(chunk.data()), chunk.size()};
  }
  if (nests_too_deep(json))
    return fail(ErrorCode::malformed, "the JSON nests deeper than any glTF does", name, kExportAgain);

  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(callbacks(folder));
  // Pictures are nothing to us; unread, they cannot grow in memory either.
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int,
                           const unsigned char*, int, void*) { return true; },
                        nullptr);
  tinygltf::Model model;
  std::string error;
  std::string warning;
  bool read = false;
  try {
    const auto size = static_cast<unsigned int>(bytes.size());
    if (binary)
      read = loader.LoadBinaryFromMemory(&model, &error, &warning,
                                         reinterpret_cast<const unsigned char*>(bytes.data()), size,
                                         folder.path.string());
    else
      read = loader.LoadASCIIFromString(&model, &error, &warning, json.data(), size, folder.path.string());
  } catch (const std::exception& thrown) {
    error = thrown.what();
    read = false;
  }
  if (!read) return std::unexpected(damage(error, name));
  for (const std::string& extension : model.extensionsRequired)
    if (extension == "KHR_draco_mesh_compression" || extension == "EXT_meshopt_compression")
      return fail(ErrorCode::unsupported, fmt::format("its meshes are compressed ({})", extension), name,
                  "export it without compression");
  return model;
}

}  // namespace mien::face::gltf
