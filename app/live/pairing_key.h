#pragma once

#include <filesystem>
#include <string>

#include "mien/core/error.h"
#include "mien/sensor/seal.h"

// The key that devices and sessions share, as a file: a number from 0 to 255, a space, 64 hexadecimal digits.
namespace mien::app {

/// Says on stderr where others than its owner can read the file, and the way out. Errors: not_found, io,
/// malformed (no key file).
[[nodiscard]] Result<sensor::SealKey> read_pairing_key(const std::filesystem::path& file);

/// Where this user's key is unless told otherwise: mien/pairing.key in XDG_CONFIG_HOME, or in ~/.config.
/// Errors: not_found (the environment names neither).
[[nodiscard]] Result<std::filesystem::path> default_pairing_key();

/// The key in `file`; where there is none a new one is drawn and written, for its owner alone (mode 600, and
/// 700 for folders that are made). Errors: read_pairing_key()'s, io.
[[nodiscard]] Result<sensor::SealKey> make_pairing_key(const std::filesystem::path& file);

/// The one line of a board's firmware: a constant of the key's number and its 32 bytes.
[[nodiscard]] std::string firmware_line(const sensor::SealKey& key);

/// The command that starts a session with this key file, for a shell.
[[nodiscard]] std::string keyed_command(const std::filesystem::path& file);

}  // namespace mien::app
