#include "mien/train/recurrent.h"

#include <torch/csrc/autograd/custom_function.h>

namespace mien::train {
namespace {

using torch::autograd::AutogradContext;
using Tensors = torch::autograd::variable_list;

/// The three parts of a unit, as views into [..., 3 width].
struct Parts {
  explicit Parts(const torch::Tensor& all)
      : width(all.size(-1) / 3),
        reset(all.narrow(-1, 0, width)),
        update(all.narrow(-1, width, width)),
        fresh(all.narrow(-1, 2 * width, width)) {}
  std::int64_t width;
  torch::Tensor reset, update, fresh;
};

/// a^T b of two [frames, sequences, n] arrays, summed over frames and sequences.
torch::Tensor summed_product(const torch::Tensor& a, const torch::Tensor& b, bool bf16) {
  const auto type = bf16 ? torch::kBFloat16 : torch::kFloat;
  return torch::mm(a.flatten(0, 1).to(type).t(), b.flatten(0, 1).to(type)).to(torch::kFloat);
}

class Recurrent : public torch::autograd::Function<Recurrent> {
 public:
  // The signatures are libtorch's to give: it looks for a static forward and backward.
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& from_input,
                               const torch::Tensor& weight, const torch::Tensor& bias, bool bf16) {
    const std::int64_t frames = from_input.size(0), sequences = from_input.size(1), width = weight.size(1);
    // states[0] is the beginning, states[t + 1] what frame t leaves.
    torch::Tensor states = torch::zeros({frames + 1, sequences, width}, from_input.options());
    torch::Tensor gates = from_input.clone();  // Becomes r, z and n.
    torch::Tensor fresh_from_state = torch::empty({frames, sequences, width}, from_input.options());
    const torch::Tensor turned = weight.t();
    torch::Tensor from_state = torch::empty({sequences, 3 * width}, from_input.options());
    const Parts of_state(from_state);
    for (std::int64_t t = 0; t < frames; ++t) {
      at::addmm_out(from_state, bias, states[t], turned);
      const torch::Tensor gate = gates[t];
      const Parts parts(gate);
      gate.narrow(-1, 0, 2 * width).add_(from_state.narrow(-1, 0, 2 * width)).sigmoid_();
      fresh_from_state[t].copy_(of_state.fresh);
      parts.fresh.addcmul_(parts.reset, of_state.fresh).tanh_();
      torch::Tensor next = states[t + 1];
      at::lerp_out(next, parts.fresh, states[t], parts.update);
    }
    context->save_for_backward({weight, states, gates, fresh_from_state});
    context->saved_data["bf16"] = bf16;
    return states.narrow(0, 1, frames);
  }

  static Tensors backward(AutogradContext* context, Tensors gradients) {
    const Tensors saved = context->get_saved_variables();
    const torch::Tensor& weight = saved[0];
    const torch::Tensor& states = saved[1];
    const torch::Tensor& gates = saved[2];
    const torch::Tensor& fresh_from_state = saved[3];
    const bool bf16 = context->saved_data["bf16"].toBool();
    const std::int64_t frames = gates.size(0), width = weight.size(1);
    const Parts all(gates);
    // What each part's gradient is multiplied by, for all frames at once.
    const torch::Tensor keep_new = 1 - all.update;
    const torch::Tensor to_fresh = keep_new * (1 - all.fresh.square());
    const torch::Tensor to_update = (states.narrow(0, 0, frames) - all.fresh) * all.update * keep_new;
    const torch::Tensor to_reset = fresh_from_state * all.reset * (1 - all.reset);

    const torch::Tensor of_states = gradients[0].contiguous();
    torch::Tensor of_input = torch::empty_like(gates), of_state = torch::empty_like(gates);
    torch::Tensor carried = torch::zeros_like(states[0]);  // What later frames ask of this one's state.
    for (std::int64_t t = frames - 1; t >= 0; --t) {
      carried.add_(of_states[t]);
      const Parts input(of_input[t]), state(of_state[t]);
      torch::Tensor fresh = input.fresh, update = input.update, reset = input.reset, gated = state.fresh;
      at::mul_out(fresh, carried, to_fresh[t]);
      at::mul_out(update, carried, to_update[t]);
      at::mul_out(reset, fresh, to_reset[t]);
      of_state[t].narrow(-1, 0, 2 * width).copy_(of_input[t].narrow(-1, 0, 2 * width));
      at::mul_out(gated, fresh, all.reset[t]);
      carried.mul_(all.update[t]).addmm_(of_state[t], weight);
    }
    return {of_input, summed_product(of_state, states.narrow(0, 0, frames), bf16),
            of_state.sum(at::IntArrayRef{0, 1}), torch::Tensor()};
  }
};

}  // namespace

torch::Tensor run_recurrent(const torch::Tensor& from_input, const torch::Tensor& weight,
                            const torch::Tensor& bias, bool bf16) {
  return Recurrent::apply(from_input, weight, bias, bf16);
}

}  // namespace mien::train
