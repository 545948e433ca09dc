#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/sensor/rig.h"
#include "mien/session/report.h"

// What the page asks for, made safe: it may name takes and receivers, and nothing else of this machine. It
// writes one file that it cannot name: the rig of the session.
namespace mien::live {

/// What a command's "on" says. Errors: malformed (it has none), told of `name`.
[[nodiscard]] Result<bool> switch_field(const nlohmann::json& command, const std::string& name);

/// Whether a person's name for a file or folder is one: a name, never a path, that no program hides. Errors:
/// bad_usage, told of `what`.
[[nodiscard]] Result<void> check_file_name(const std::string& name, const std::string& what);

/// This file, or with a number behind its name the first of it that is not there.
[[nodiscard]] std::filesystem::path unused(const std::filesystem::path& take);

/// The take that a person means in `folder`: a name, never a path; empty: one by the time of day. Errors:
/// bad_usage.
[[nodiscard]] Result<std::filesystem::path> take_path(const std::filesystem::path& folder,
                                                      const std::string& name);

/// Whether a page may ask for this sink: neither a path, which is not its business, nor a host's name, since
/// looking it up takes seconds. Errors: bad_usage, sink::parse_address()'s.
[[nodiscard]] Result<void> check_page_sink(const std::string& text);

/// Writes which parts of cameras' pictures are seen now into the session's rig file, for sessions to come;
/// what came of it, as the page is told. Errors: unsupported (no such file, no camera),
/// sensor::write_views'.
[[nodiscard]] Result<std::string> save_views(const std::filesystem::path& rig_file, const sensor::Rig& rig,
                                             std::span<const session::Report::Link> links);

}  // namespace mien::live
