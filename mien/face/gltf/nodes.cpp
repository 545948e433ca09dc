#include "mien/face/gltf/nodes.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "mien/core/excerpt.h"
#include "mien/core/rotation.h"
#include "mien/face/gltf/names.h"

namespace mien::face::gltf {
namespace {

using Mat4 = Eigen::Matrix4d;

inline constexpr std::size_t kMaxNodes = 100'000;
inline constexpr std::size_t kMaxNodeDepth = 512;

Mat4 local_transform(const tinygltf::Node& node) {
  Mat4 m = Mat4::Identity();
  if (node.matrix.size() == 16) {
    for (int i = 0; i < 16; ++i) m(i % 4, i / 4) = node.matrix[static_cast<std::size_t>(i)];
    return m;
  }
  if (node.rotation.size() == 4) {
    const Quat q(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    if (q.norm() > 1e-9) m.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
  }
  if (node.scale.size() == 3)
    m.topLeftCorner<3, 3>() *= Vec3(node.scale[0], node.scale[1], node.scale[2]).asDiagonal();
  if (node.translation.size() == 3)
    m.topRightCorner<3, 1>() = Vec3(node.translation[0], node.translation[1], node.translation[2]);
  return m;
}

}  // namespace

Result<std::vector<Placed>> place_nodes(const tinygltf::Model& model, const Arrays& arrays) {
  std::vector<int> roots;
  if (const tinygltf::Scene* scene = at(model.scenes, std::max(model.defaultScene, 0)))
    roots = scene->nodes;
  else
    for (std::size_t i = 0; i < model.nodes.size(); ++i) roots.push_back(static_cast<int>(i));
  if (model.nodes.size() > kMaxNodes)
    return arrays.bad(fmt::format("there are more than {} nodes", kMaxNodes));
  std::vector<bool> seen(model.nodes.size());
  std::vector<Placed> placed;
  struct Open {
    int node;
    Mat4 parent;
    std::size_t depth;
  };
  std::vector<Open> open;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) open.push_back({*root, Mat4::Identity(), 0});
  while (!open.empty()) {
    const Open next = open.back();
    open.pop_back();
    const tinygltf::Node* node = at(model.nodes, next.node);
    if (node == nullptr) return arrays.bad("a node that is not there is named");
    if (next.depth > kMaxNodeDepth) return arrays.bad("the nodes nest too deep");
    if (seen[static_cast<std::size_t>(next.node)]) continue;
    seen[static_cast<std::size_t>(next.node)] = true;
    const Mat4 world = next.parent * local_transform(*node);
    if (!world.allFinite() || world.cwiseAbs().maxCoeff() > 1e9)
      return fail(ErrorCode::out_of_range, "a node's transform is beyond all bounds", excerpt(node->name));
    placed.push_back({next.node, world});
    for (auto child = node->children.rbegin(); child != node->children.rend(); ++child)
      open.push_back({*child, world, next.depth + 1});
  }
  return placed;
}

Result<std::vector<Mat4>> vertex_matrices(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                                          const tinygltf::Node& node, const Mat4& world,
                                          const std::vector<Mat4>& worlds, std::size_t vertices,
                                          const Arrays& arrays) {
  const tinygltf::Skin* skin = at(model.skins, node.skin);
  const auto joints_at = primitive.attributes.find("JOINTS_0");
  const auto weights_at = primitive.attributes.find("WEIGHTS_0");
  if (skin == nullptr || joints_at == primitive.attributes.end() || weights_at == primitive.attributes.end())
    return std::vector<Mat4>{world};
  std::vector<Mat4> joint(skin->joints.size());
  std::vector<double> inverse;
  if (skin->inverseBindMatrices >= 0) {
    MIEN_TRY_ASSIGN(inverse, arrays.read(skin->inverseBindMatrices, 16, joint.size()));
  }
  for (std::size_t j = 0; j < joint.size(); ++j) {
    if (at(worlds, skin->joints[j]) == nullptr) return arrays.bad("a skin names a joint that is not there");
    joint[j] = *at(worlds, skin->joints[j]);
    if (!inverse.empty()) joint[j] *= Eigen::Map<const Mat4>(inverse.data() + 16 * j);
  }
  MIEN_TRY_ASSIGN(const auto joints, arrays.read(joints_at->second, 4, vertices));
  MIEN_TRY_ASSIGN(const auto weights, arrays.read(weights_at->second, 4, vertices));
  std::vector<Mat4> matrices(vertices, Mat4::Zero());
  for (std::size_t v = 0; v < vertices; ++v) {
    double sum = 0;
    for (std::size_t c = 4 * v; c < 4 * v + 4; ++c) {
      if (weights[c] <= 0) continue;
      if (!(joints[c] >= 0 && joints[c] < static_cast<double>(joint.size())))
        return arrays.bad("a vertex names a joint that is not there");
      matrices[v] += weights[c] * joint[static_cast<std::size_t>(joints[c])];
      sum += weights[c];
    }
    if (sum > 0)
      matrices[v] /= sum;
    else
      matrices[v] = world;
  }
  return matrices;
}

}  // namespace mien::face::gltf
