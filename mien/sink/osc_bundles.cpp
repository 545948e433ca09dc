#include "mien/sink/osc_bundles.h"

namespace mien::sink {

void OscBundles::finish() {
  if (!open_) return;
  stream_ << osc::EndBundle;
  out_->begin();
  out_->append(std::string_view(stream_.Data(), stream_.Size()));
  open_ = false;
}

}  // namespace mien::sink
