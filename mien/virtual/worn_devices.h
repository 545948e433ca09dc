#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/performer/encore.h"
#include "mien/performer/prologue.h"
#include "mien/take/take.h"
#include "mien/virtual/network.h"
#include "mien/virtual/node.h"
#include "mien/virtual/session.h"
#include "mien/virtual/virtual_clock.h"

namespace mien::virt {

struct Stage;

/// What a performer's devices send.
struct Sent {
  /// At their arrivals. Shape: those of one moment in the order in which they are received.
  std::vector<Datagram> datagrams;
  VirtualClock reference;  ///< Of the rig's reference, by which the performance is timed.
  /// In the profile *lab*: how many frames there are, each once what is sent until its time has arrived.
  std::optional<std::int64_t> frames;
  std::vector<take::Event> events;  ///< What befell the devices, beside the prologue's; on that clock.
};

/// A part of a session, after what came before it.
struct Stretch {
  VirtualSession session;  ///< Entries and ticks are numbered on; events come with the first.
  double share = 1;        ///< Of the whole that is performed by its end, 0 to 1.
};

/// A session that is simulated and received stretch by stretch, in memory that does not grow with its length.
class SessionStream {
 public:
  virtual ~SessionStream() = default;
  /// Until done(). Errors: those of WornDevices::send().
  [[nodiscard]] virtual Result<Stretch> next(const Progress& progress) = 0;
  [[nodiscard]] virtual bool done() const = 0;
};

/// The language of nodes on the network.
enum class NodeLanguage {
  mien,     ///< Our own packets, of IMUs, of eyewear and of microphones.
  slimevr,  ///< A SlimeVR tracker's.
};

/// The motion that devices on the network are worn through; both outlive these.
struct PlayedMotion {
  const face::MotionCurve& curve;
  const std::optional<performer::Encore>& encore;  ///< None: played once.

  /// At a true time, s.
  [[nodiscard]] face::MotionFrame at(double true_s) const {
    return encore ? encore->at(curve, true_s) : curve.at(true_s);
  }
};

/// A performer's sensors on the network: their simulation, which runs a little ahead of the performance and
/// hands what is sampled to their nodes. Thread: one at a time.
class NodeDevices {
 public:
  virtual ~NodeDevices() = default;
  /// One a board, in the order of the rig's sensors. Valid as long as this.
  [[nodiscard]] virtual std::vector<Node*> nodes() = 0;
  /// A sixtieth of a second more. Errors: the packet encoders'.
  [[nodiscard]] virtual Result<void> simulate() = 0;
  /// True time up to which all that is sampled has been handed over, s from the performance's time 0.
  [[nodiscard]] virtual double simulated_s() const = 0;
  /// The motion is over; never with an encore.
  [[nodiscard]] virtual bool done() const = 0;
};

/// A performer's devices: faults read, places and skin drawn. Each modality's folder derives
/// one, and stage.cpp has the table of them; WornTogether is of several. Immutable once made, so safe to
/// share between threads.
class WornDevices {
 public:
  virtual ~WornDevices() = default;
  /// What a prologue must hold for a session to calibrate these.
  [[nodiscard]] virtual performer::PrologueNeeds prologue(const Stage& stage) const = 0;
  /// What they send of the whole performance. Errors: bad_usage (a motion without frames), cancelled, the
  /// packet encoders'.
  [[nodiscard]] virtual Result<Sent> send(const Stage& stage, const Progress& progress) const = 0;
  /// Whether stream() can be asked for, in this profile.
  [[nodiscard]] virtual bool streams([[maybe_unused]] bool lab) const { return false; }
  /// What is received of them, stretch by stretch. The stage outlives the stream.
  /// Errors: unsupported, Reception::create's.
  [[nodiscard]] virtual Result<std::unique_ptr<SessionStream>> stream(const Stage& stage) const;
  /// Whether they send nothing by themselves and wait to be asked, as cameras do: they are offered on the
  /// network otherwise than by on_network(), which then fails.
  [[nodiscard]] virtual bool are_asked() const { return false; }
  /// The same devices on the network: the same stage gives the same samples as send(). The stage outlives
  /// them. Errors: bad_usage (a language that their boards do not have; a rig whose boards cannot be).
  [[nodiscard]] virtual Result<std::unique_ptr<NodeDevices>> on_network(const Stage& stage,
                                                                        const PlayedMotion& motion,
                                                                        NodeLanguage language) const = 0;
};

}  // namespace mien::virt
