#include "mien/face/gltf_import.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "mien/core/files.h"
#include "mien/face/gltf/arrays.h"
#include "mien/face/gltf/assembly.h"
#include "mien/face/gltf/binding.h"
#include "mien/face/gltf/container.h"
#include "mien/face/gltf/nodes.h"

namespace mien::face {
namespace gltf {
namespace {

Result<GltfHead> read_head(std::span<const std::byte> bytes, const std::string& name, Folder& folder) {
  MIEN_TRY_ASSIGN(const tinygltf::Model model, read_container(bytes, name, folder));
  const Arrays arrays(model, name);
  const Binding binding = bind_shapes(model);
  if (binding.count > kMaxBinds)
    return fail(ErrorCode::out_of_range, fmt::format("it binds more than {} morph targets", kMaxBinds), name);
  if (binding.count == 0)
    return fail(ErrorCode::not_found, "no morph target has an ARKit name such as jawOpen or eyeBlinkLeft",
                name, "export the head with its shape key names (mesh extras, targetNames)");
  MIEN_TRY_ASSIGN(const auto placed, place_nodes(model, arrays));
  std::vector<Eigen::Matrix4d> worlds(model.nodes.size(), Eigen::Matrix4d::Identity());
  for (const Placed& p : placed) worlds[static_cast<std::size_t>(p.node)] = p.world;
  Assembly head;
  for (const Placed& p : placed)
    if (model.nodes[static_cast<std::size_t>(p.node)].mesh >= 0)
      MIEN_TRY(add_mesh(model, p, worlds, binding, head, arrays));
  return finish(std::move(head), binding, name);
}

}  // namespace
}  // namespace gltf

Result<GltfHead> import_gltf(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const auto bytes, read_file(path, gltf::kMaxBytes));
  std::error_code code;
  gltf::Folder folder{std::filesystem::canonical(path, code).parent_path()};
  return gltf::read_head(bytes, path.string(), folder);
}

Result<GltfHead> parse_gltf(std::span<const std::byte> bytes, std::string_view name) {
  gltf::Folder nothing;
  return gltf::read_head(bytes, std::string(name), nothing);
}

}  // namespace mien::face
