#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/live/page_token.h"
#include "mien/core/error.h"
#include "mien/live/engine.h"
#include "mien/shaping/settings.h"

namespace mien::app {

/// What a live session is asked for on the command line.
struct LiveRequest {
  std::string rig;    ///< Empty: the default one.
  std::string model;  ///< Empty: the default live one of the rig's sensors.
  /// Where devices send to, and cameras that are asked; empty: our port and SlimeVR's, from everywhere.
  std::vector<std::string> listen;
  std::vector<std::string> out;
  std::filesystem::path record;  ///< Empty: the page's visitors may record.
  bool force = false;
  std::filesystem::path takes;          ///< Empty: the folder of `record`, or the present one.
  std::vector<std::string> texts;       ///< Files of recording scripts of one's own, beside ours.
  std::string page = "127.0.0.1:8740";  ///< Or "off"; without a port 8740.
  TokenOption token;                    ///< Of the page.
  std::string face = "builtin";
  std::string performer;
  std::string script = "live";  ///< What is performed: goes into takes.
  std::string key;              ///< A file; empty: everybody is heard.
  double seconds = 0;           ///< 0: until it is stopped.
  std::string constraints;      ///< A file, or "off"; empty: the default.
  double blinks_per_min = shaping::ShaperSettings().blinks_per_min;
  std::string audio;      ///< A WAV file, a microphone, "page" or "network" that is heard; empty: nothing is.
  std::string hears_by;   ///< "network" or "phones"; empty: as the rig says.
  std::string phone;      ///< "truth" or "source": what phones are for that the rig has no sensor of.
  bool images = false;    ///< Pictures are logged, not only what a network finds in them.
  bool no_audio = false;  ///< No microphone is opened, and no file heard.
  std::vector<session::Prompt> prompts;  ///< Poses to ask for.
  bool only_record = false;              ///< It ends when its prompts or its recording do.
  /// What the temporary log may take, 10^9 bytes.
  double log_limit_gb = 1e-9 * static_cast<double>(live::Spool::kDefaultLimit);
};

/// A session that is open, and what it shows.
struct LiveSession {
  std::vector<std::string> out;  ///< Addresses of the sinks that were asked for.
  /// Cameras that are asked for pictures, and serial lines on which one may speak: each one's address, and
  /// the sensor whose pictures they are.
  std::vector<std::pair<std::string, std::string>> cameras;
  std::vector<std::string> phones;           ///< Those that are asked for their frames.
  std::vector<std::string> without_address;  ///< The rig's cameras that no address is left for.
  std::string pictures;                      ///< Where they are kept: what that will take; else empty.
  std::unique_ptr<live::Engine> engine;
};

/// Reads what the request names and opens every port, sink, take and page. The built-in face that the page
/// shows is made on a thread of its own meanwhile: frames do not wait for it. Errors: theirs.
[[nodiscard]] Result<LiveSession> open_live(LiveRequest request);

}  // namespace mien::app
