#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/model/confidence.h"
#include "mien/synthetic/watched.h"

namespace mien::lab {

/// A model whose confidence is studied, and whom it watches; one class a modality.
class StudiedModel {
 public:
  virtual ~StudiedModel() = default;
  /// None: nobody has measured it.
  [[nodiscard]] virtual const std::optional<model::ConfidenceTable>& table() const = 0;
  virtual void use(model::ConfidenceTable table) = 0;
  /// The model with its table. Errors: the writer's.
  [[nodiscard]] virtual Result<void> write(const std::string& path) const = 0;
  [[nodiscard]] virtual std::string rig_name() const = 0;

  /// Virtual people with the rig's faults, `seconds` of performance each. Errors: the devices'; cancelled.
  [[nodiscard]] virtual Result<synthetic::WatchedGroup> virtual_people(int people, double seconds,
                                                                       std::uint64_t seed,
                                                                       const std::string& title) const = 0;
  /// People unlike those of training (synthetic::draw_shifted_person), likewise.
  [[nodiscard]] virtual Result<synthetic::WatchedGroup> shifted_people(int people, double seconds,
                                                                       std::uint64_t seed,
                                                                       const std::string& title) const = 0;
  /// A recorded performance on the built-in face. Errors: the devices'.
  [[nodiscard]] virtual Result<synthetic::WatchedGroup> recorded(std::string who, const face::Motion& motion,
                                                                 const Random& random) const = 0;
  /// Virtual people under every fault that the simulator knows; of every two one unlike those of training,
  /// where `shifted`. Errors: the devices'.
  [[nodiscard]] virtual Result<synthetic::FaultyGroup> faulty_people(int people, double seconds, bool shifted,
                                                                     std::uint64_t seed) const = 0;
};

/// The model of a file, whichever modality it is of, before the sensors of a rig; of an empty `rig` those of
/// its modality's default one. Errors: the readers'.
[[nodiscard]] Result<std::unique_ptr<StudiedModel>> read_studied_model(const std::string& model,
                                                                       const std::string& rig);

}  // namespace mien::lab
