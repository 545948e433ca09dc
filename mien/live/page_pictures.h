#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/feeds.h"
#include "mien/live/picture_tap.h"
#include "mien/session/report.h"

namespace mien::live {

class PageServer;

/// What the page is told of a session's cameras.
struct PicturesState {
  std::size_t cameras = 0;   ///< Whose pictures can be looked at.
  std::size_t watchers = 0;  ///< Pages that are shown them now.
};

/// Shows what cameras see to those of the page's clients that asked for it, and to nobody else. A view is
/// made at each look, of each camera, while somebody looks on; a client that is behind gets the newest alone.
/// Nothing is kept, and nothing of it is logged. Network thread.
class PagePictures {
 public:
  /// Of feeds that have a tap. Before they begin.
  void open(std::span<const Feed> feeds);
  /// What a client asks for by the command `pictures`: to be shown them from now on, or no more. True where
  /// nobody was shown any before. Errors: unsupported (no camera).
  [[nodiscard]] Result<bool> show(std::uint64_t client, bool on);
  /// Whether somebody looks on. Forgets who is gone.
  [[nodiscard]] bool watched(const PageServer& page);
  /// Ten times a second, where it is watched: sends what was made, and asks for the next.
  void look(std::span<const session::Report::Link> links, PageServer& page);
  /// None of a session without cameras.
  [[nodiscard]] std::optional<PicturesState> state() const;

 private:
  std::vector<std::shared_ptr<PictureTap>> taps_;
  std::set<std::uint64_t> clients_;
};

/// A view's binary message (docs/reference/page_protocol.md).
[[nodiscard]] std::string picture_message(const PictureTap::View& view);

}  // namespace mien::live
