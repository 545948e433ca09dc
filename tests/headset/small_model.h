#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mien/core/random.h"
#include "mien/headset/answer.h"
#include "mien/headset/headset_model.h"
#include "mien/headset/views_file.h"
#include "mien/sensor/rig.h"

// A headset and a network for tests of what uses them.
namespace mien::headset::test {

/// A network of pictures of 16 x 16 pixels that has learnt nothing: its numbers are drawn.
inline ViewsFile small_views_file(std::uint64_t seed = 1) {
  ViewsFile file;
  file.architecture = model::named_architecture("views", 1).value();
  file.architecture.side = 16;
  file.architecture.widths = {4, 8};
  file.architecture.layers = 2;
  file.architecture.features = 8;
  file.architecture.d_model = 32;
  file.architecture.outputs = kAnswerOutputs;
  file.architecture.condition = model::views_condition(16);
  file.mean_answer.assign(kAnswerOutputs, 0.0F);
  Random random(seed);
  for (const model::TensorSpec& spec : model::network_tensors(file.architecture)) {
    std::size_t count = 1;
    for (const std::size_t n : spec.shape) count *= n;
    std::vector<float> values(count);
    for (float& value : values) value = static_cast<float>(random.uniform(-0.4, 0.5));
    file.network.push_back({.name = spec.name, .shape = spec.shape, .values = std::move(values)});
  }
  return file;
}

/// A memory of it that has learnt nothing either.
inline ViewsMemory small_memory(std::uint64_t seed = 2) {
  ViewsMemory memory;
  memory.architecture = model::named_architecture("causal", moment_condition(8)).value();
  memory.architecture.d_model = 32;
  memory.architecture.outputs = kMemoryOutputs;
  Random random(seed);
  for (const model::TensorSpec& spec : model::network_tensors(memory.architecture)) {
    std::size_t count = 1;
    for (const std::size_t n : spec.shape) count *= n;
    std::vector<float> values(count);
    for (float& value : values) value = static_cast<float>(random.uniform(-0.3, 0.3));
    memory.network.push_back({.name = spec.name, .shape = spec.shape, .values = std::move(values)});
  }
  memory.judgements.fill({.offset = 0.5F, .slope = 1});
  return memory;
}
inline ViewsFile small_file_with_memory(std::uint64_t seed = 2) {
  ViewsFile file = small_views_file();
  // What random weights answer to a moment lies far beyond its range, and a memory that reads it saturates.
  for (float& weight : file.network[file.network.size() - 2].values) weight *= 0.02F;
  file.memory = small_memory(seed);
  return file;
}
inline std::shared_ptr<const HeadsetModel> small_model_with_memory() {
  return HeadsetModel::create(small_file_with_memory()).value();
}

inline std::shared_ptr<const HeadsetModel> small_model(std::uint64_t seed = 1) {
  return HeadsetModel::create(small_views_file(seed)).value();
}

/// What binds the cameras of the rig below, by their numbers.
inline constexpr std::uint64_t kHeadset = 0x024D'4948'5300ULL;
inline constexpr std::array<const char*, 4> kCameraNames = {"eye_L", "eye_R", "mouth_L", "mouth_R"};

/// Two eyes, two halves of a mouth.
inline std::string headset_rig_text() {
  std::string text = "name = \"test\"\nreference = \"eye_L\"\n";
  for (std::size_t c = 0; c < kCameraNames.size(); ++c) {
    const std::string name = kCameraNames[c];
    const std::string side(1, name.back());
    text += "[[sensor]]\nname = \"" + name + "\"\nkind = \"camera\"\nsite = \"" +
            name.substr(0, name.size() - 2) + "\"\nside = \"" + side +
            "\"\nrole = \"face\"\ndevice = \"02:4D:49:48:53:0" + std::to_string(c) + "\"\nposition_m = [" +
            (side == "L" ? "0.05" : "-0.05") + ", 0.02, 0.1245]\n[sensor.camera]\nlook_at_m = [" +
            (side == "L" ? "0.031" : "-0.031") +
            ", 0.042, 0.093]\nup = [0.0, 1.0, 0.0]\nfield_of_view_deg = 83.0\nsize = [240, 240]\n"
            "rate_hz = 60.0\nexposure_ms = 4.0\ncrop = [0.1, 0.1, 0.8, 0.8]\nmirror = " +
            (side == "L" ? "false" : "true") + "\n";
  }
  return text;
}

inline sensor::Rig headset_rig() {
  return sensor::parse_rig(headset_rig_text(), "test").value();
}

}  // namespace mien::headset::test
