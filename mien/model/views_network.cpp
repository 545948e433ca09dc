#include "mien/model/views_network.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace mien::model {

Result<ViewsNetwork> ViewsNetwork::create(const Architecture& architecture, std::span<const Tensor> network,
                                          Precision precision) {
  if (architecture.kind != NetworkKind::views)
    return fail(ErrorCode::mismatch, "it is no network of pictures");
  MIEN_TRY(check(architecture));
  MIEN_TRY(check_tensors(architecture, network));
  const BackboneShape shape = backbone_shape(architecture);
  const std::size_t count = tensor_specs(shape).size();
  const auto backbone = [&](std::size_t first) {
    std::vector<Tensor> tensors(network.begin() + static_cast<std::ptrdiff_t>(first),
                                network.begin() + static_cast<std::ptrdiff_t>(first + count));
    for (std::size_t i = 0; i < count; ++i) tensors[i].name = tensor_specs(shape)[i].name;
    return Backbone::create(shape, tensors, precision);
  };
  MIEN_TRY_ASSIGN(Backbone eye, backbone(0));
  MIEN_TRY_ASSIGN(Backbone mouth, backbone(count));
  ViewsNetwork made(std::move(eye), std::move(mouth));
  made.architecture_ = architecture;
  const Tensor& missing = network[2 * count];
  made.missing_ = AlignedFloats(missing.values.size());
  std::ranges::copy(missing.values, made.missing_.data());
  const auto linear = [&](std::size_t at, std::size_t out, std::size_t in) {
    return pack_linear(network[at].values, network[at + 1].values, out, in, 0, in, precision);
  };
  made.hidden_ = linear(2 * count + 1, architecture.d_model, 2 * kViews * architecture.features);
  made.output_ = linear(2 * count + 3, architecture.outputs, architecture.d_model);
  return made;
}

ViewsNetwork::Workspace::Workspace(const ViewsNetwork& network)
    : eye_(network.eye_, 2),
      mouth_(network.mouth_, 2),
      features_(row_stride(2 * kViews * network.architecture_.features)),
      hidden_(row_stride(network.architecture_.d_model)),
      answer_(row_stride(network.architecture_.outputs)),
      converted_(1, std::max(2 * kViews * network.architecture_.features, network.architecture_.d_model)) {}

void ViewsNetwork::find(std::span<const float> views, const std::array<bool, kViews>& present,
                        Workspace& workspace, std::span<float> features) const {
  const std::size_t pixels = architecture_.side * architecture_.side, found = architecture_.features;
  for (std::size_t first = 0; first < kViews; first += 2) {
    const Backbone& backbone = first == 0 ? eye_ : mouth_;
    Backbone::Workspace& memory = first == 0 ? workspace.eye_ : workspace.mouth_;
    if (present[first] && present[first + 1]) {
      backbone.apply(views.subspan(first * pixels, 2 * pixels), memory,
                     features.subspan(first * found, 2 * found));
      continue;
    }
    for (const std::size_t v : {first, first + 1}) {
      const std::span<float> out = features.subspan(v * found, found);
      if (present[v])
        find_one(v, views.subspan(v * pixels, pixels), workspace, out);
      else
        std::ranges::copy(missing(v), out.data());
    }
  }
}

void ViewsNetwork::find_one(std::size_t which, std::span<const float> view, Workspace& workspace,
                            std::span<float> features) const {
  if (which < 2)
    eye_.apply(view, workspace.eye_, features);
  else
    mouth_.apply(view, workspace.mouth_, features);
}

void ViewsNetwork::answer(std::span<const float> features, std::span<const float> differences,
                          Workspace& workspace, std::span<float> out) const {
  std::ranges::copy(differences, std::ranges::copy(features, workspace.features_.data()).out);
  apply_linear(hidden_, 1, {workspace.features_.data(), workspace.features_.size()},
               {workspace.hidden_.data(), workspace.hidden_.size()}, {.add = {}, .relu = true},
               workspace.converted_);
  apply_linear(output_, 1, {workspace.hidden_.data(), workspace.hidden_.size()},
               {workspace.answer_.data(), workspace.answer_.size()}, {}, workspace.converted_);
  std::copy_n(workspace.answer_.data(), architecture_.outputs, out.data());
}

}  // namespace mien::model
