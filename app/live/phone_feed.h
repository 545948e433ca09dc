#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/feeds.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/rig.h"

namespace mien::app {

/// Whether what `--listen` names is a phone that is heard, "livelink://HOST[:PORT]", or asked,
/// "ifacialmocap://PHONE[:PORT]".
[[nodiscard]] bool is_phone(std::string_view address);

/// The phones among what a session listens on.
struct ListenedPhones {
  std::vector<std::string> ports;          ///< Where their frames come in, as live::Intake listens: udp://...
  std::vector<live::Feed> feeds;           ///< Who asks those that want to be asked.
  std::vector<sensor::DeviceKey> devices;  ///< What each is heard as.
  std::vector<std::string> asked;          ///< Addresses of those that are asked.
};
/// Errors: bad_usage (no address, or one phone twice).
[[nodiscard]] Result<ListenedPhones> listened_phones(const std::vector<std::string>& listen);

/// The rig with a sensor for each of these devices that it binds to none, as phone::with_phones adds it.
/// `use`: "truth" or "source". Errors: bad_usage (`use` is empty where a sensor is wanted, or given where
/// none is), and those of with_phones.
[[nodiscard]] Result<sensor::Rig> with_listened(sensor::Rig rig,
                                                const std::vector<sensor::DeviceKey>& devices,
                                                const std::string& use);

}  // namespace mien::app
