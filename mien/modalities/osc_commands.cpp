#include "mien/modalities/osc_commands.h"

#include <cmath>
#include <optional>

#include "mien/gaze/osc.h"

namespace mien::modalities {
namespace {

const char* const kOscCommand = "OSC command";

bool asks_to_recentre(std::string_view address) {
  return address == "/mien/recentre" || address == "/avatar/parameters/mien/recentre";
}

/// Whether a message's button is pressed; none where its arguments are no button's.
std::optional<bool> pressed(const gaze::OscMessage& message) {
  if (message.count == 0) return true;
  if (message.count > 1) return std::nullopt;
  if (message.numeric) return std::isfinite(message.numbers[0]) && message.numbers[0] != 0;
  if (message.types == "T" || message.types == "I") return true;
  if (message.types == "F" || message.types == "N") return false;
  return std::nullopt;
}

class Commands final : public gaze::OscListener {
 public:
  Result<void> hear(const gaze::OscMessage& message) override {
    const bool known = asks_to_recentre(message.address);
    if (messages++ == 0) first_known = known;
    if (!known) return {};
    const std::optional<bool> button = pressed(message);
    if (!button)
      return fail(ErrorCode::malformed, "a command with other arguments than a button's", kOscCommand);
    recentre = recentre || *button;
    return {};
  }
  std::size_t messages = 0;
  bool first_known = false;
  bool recentre = false;
};

}  // namespace

bool OscCommands::recognises(std::span<const std::byte> datagram) const {
  if (!gaze::is_osc(datagram)) return false;
  Commands commands;
  // What is wrong with it is for receive() to say.
  static_cast<void>(gaze::read_osc(datagram, commands));
  return commands.first_known;
}

sensor::Verdict OscCommands::receive(HostTime, sensor::Peer, std::span<const std::byte> datagram,
                                     sensor::Inbox& inbox) {
  Commands commands;
  if (!gaze::read_osc(datagram, commands)) return sensor::Verdict::malformed;
  inbox.recentre = commands.recentre;
  return commands.recentre ? sensor::Verdict::taken : sensor::Verdict::ignored;
}

}  // namespace mien::modalities
