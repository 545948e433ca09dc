#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/model_file.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/seal.h"
#include "mien/session/session.h"
#include "mien/shaping/settings.h"

// Trackers, protocols and models of all modalities, by the kinds of a rig's sensors.
namespace mien::modalities {

using Protocols = std::vector<std::unique_ptr<sensor::Protocol>>;

/// Addresses that a session listens on unless told otherwise: the UDP ports of every modality's devices.
[[nodiscard]] std::vector<std::string> default_listen();

/// The live model for a rig's sensors: the file `named`, or where that is empty the default one of such
/// sensors. A rig with sensors of several kinds that need models takes a folder instead, in which the model
/// of each has its default name; gaze and weights need none, and the path for a rig of these alone is empty.
/// Speech beside others takes its default one, or that of the folder. Errors: not_found (none is installed),
/// unsupported (sensors of a kind that is unknown).
[[nodiscard]] Result<std::filesystem::path> live_model(const sensor::Rig& rig, const std::string& named);

/// Whether there are models that see a whole window of such sensors, past and future; else only the live
/// model solves their takes, frame by frame.
[[nodiscard]] bool has_window_models(const sensor::Rig& rig);

/// What the networks of a rig's sensors multiply with in a session on this CPU (model::kernel_name()); of
/// several kinds each name once. "none" where no kind needs a network.
[[nodiscard]] std::string live_kernels(const sensor::Rig& rig);

/// The protocols of all sensors; with keys one that opens the packets of those which can be sealed, beside
/// what devices inside this program speak, and nobody else is heard. Errors: internal (libsodium), the keys'.
[[nodiscard]] Result<Protocols> make_protocols(const std::vector<sensor::SealKey>& keys = {});

/// What a session logs of what cameras see.
enum class Pictures : std::uint8_t {
  reduced,  ///< What its network finds in them. No picture is kept anywhere.
  kept,     ///< The pictures themselves, so that another network can look at them.
};

/// The live model of a rig's sensors.
struct LiveModel {
  template <class Path>
  requires std::convertible_to<Path, std::filesystem::path> LiveModel(Path&& file_or_folder)
      : path(std::forward<Path>(file_or_folder)) {}
  std::filesystem::path path;             ///< live_model()'s.
  std::optional<model::ModelFile> imu{};  ///< In place of the file that the IMUs' tracker would read.
};

/// A session for a rig: its sensors' trackers with this live model, and the protocols of all sensors. With
/// keys only what is sealed by one of them is accepted, so nothing from serial lines. A replay shows the same
/// with either kind of `pictures`. Errors: unsupported (sensors of a kind that is unknown), the model's
/// (mismatch: another rig's), make_protocols', the session's.
[[nodiscard]] Result<std::unique_ptr<session::Session>> make_session(
    const sensor::Rig& rig, const LiveModel& model, const shaping::ShaperSettings& shaping = {},
    const std::vector<sensor::SealKey>& keys = {}, Pictures pictures = Pictures::reduced);

/// A session without trackers: devices, clocks and ticks alone. Errors: make_protocols', the session's.
[[nodiscard]] Result<std::unique_ptr<session::Session>> make_receiving_session(const sensor::Rig& rig);

}  // namespace mien::modalities
