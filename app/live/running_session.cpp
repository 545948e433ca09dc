#include "app/live/running_session.h"

#include <exception>
#include <utility>

namespace mien::app {

RunningSession::RunningSession(live::Engine& engine)
    : thread_([this, &engine] {
        try {
          summary_ = engine.run(stop_, live::EngineListener());
        } catch (const std::exception& error) {
          summary_ = fail(ErrorCode::internal, error.what(), "the live session");
        }
      }) {}

RunningSession::~RunningSession() {
  stop_ = true;
}

Result<live::EngineSummary> RunningSession::finish() {
  stop_ = true;
  thread_.join();
  return std::move(summary_);
}

}  // namespace mien::app
