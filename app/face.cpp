#include "app/command.h"

namespace mien::app {

void add_face_command(Commands& commands) {
  commands.add("face", "Shows what a face model is made of", "mien face --face builtin", [] { return Result<void>{}; });
}

}  // namespace mien::app
