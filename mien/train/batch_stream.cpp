#include "mien/train/batch_stream.h"

namespace mien::train {

BatchStream::BatchStream(const Task& task, std::int64_t first_step, std::size_t ahead)
    : task_(task), next_step_(first_step), ahead_(ahead) {}

Batch BatchStream::next() {
  while (coming_.size() <= ahead_)
    coming_.push_back(std::async(std::launch::async, [this, step = next_step_++] {
      const Recipe& recipe = task_.recipe();
      return task_.random_batch(recipe.batch,
                                Random(recipe.seed).fork("batch", static_cast<std::uint64_t>(step)));
    }));
  Batch batch = coming_.front().get();
  coming_.pop_front();
  return batch;
}

}  // namespace mien::train
