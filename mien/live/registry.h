#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/session.h"
#include "mien/model/model_file.h"
#include "mien/shaping/settings.h"

// The one place of this room that knows which modalities there are.
namespace mien::live {

/// What devices and a host share, so that nobody else is heard; the program reads it from the file of --key.
struct PairingKey {
  std::uint8_t id = 0;
  std::array<std::byte, 32> secret{};
};

/// A session for a rig: its sensors' tracker with this live model, and every language that such sensors
/// speak. With keys only what is sealed by one of them is heard, so nothing on serial lines. Errors:
/// unsupported (photo-reflective sensors), the model's (mismatch: another rig's), the session's.
[[nodiscard]] Result<std::unique_ptr<Session>> make_session(const sensor::Rig& rig,
                                                            model::ModelFile live_model,
                                                            const shaping::ShaperSettings& shaping = {},
                                                            const std::vector<PairingKey>& keys = {});

}  // namespace mien::live
