#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/face/rig_constraints.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::face;
  const auto rules =
      RigConstraints::parse(std::string_view(reinterpret_cast<const char*>(data), size), "input");
  if (!rules) return 0;
  // Whatever rules load are obeyed, and a face that obeys stays.
  for (const RuleSet* set : {&rules->live(), &rules->always(), &rules->solve()}) {
    BlendshapeWeights weights;
    for (std::size_t i = 0; i < kShapeCount; ++i) weights[i] = static_cast<float>(i * 37 % 101) / 100;
    set->project(weights);
    if (!set->obeyed(weights)) std::abort();
    const BlendshapeWeights once = weights;
    set->project(weights);
    if (!(weights == once)) std::abort();
  }
  // And go through a session's log.
  const auto again = RigConstraints::parse(rules->text(), "text");
  if (!again || *again != *rules) std::abort();
  return 0;
}
