#include "lab/virtual_motion.h"

#include <array>
#include <span>
#include <string>

#include "mien/core/random.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

using performer::Block;

constexpr std::array kKinds = {Block::range_of_motion, Block::free, Block::expressions, Block::reading,
                               Block::acted};

}  // namespace

Result<std::vector<MotionStatistics>> virtual_motion(const VirtualMotionRequest& request,
                                                     const Progress& progress) {
  if (request.performers < 1 || !(request.seconds >= 1))
    return fail(ErrorCode::bad_usage, "nobody moves", "study motion", "ask for a performer and a second");
  const auto people = static_cast<std::size_t>(request.performers);
  std::vector<MotionStatistics> each(kKinds.size() * people);
  MIEN_TRY(
      virt::for_each_performer(each.size(), request.threads, progress, [&](std::size_t i) -> Result<void> {
        const Random person = Random(request.seed).fork("person", i % people);
        Random drawn = person.fork("style");
        const std::array motions = {
            performer::perform(performer::default_script(kKinds[i / people], request.seconds),
                               performer::draw_style(drawn), person.fork("motion"))};
        each[i] = motion_statistics(motions, {});
        return {};
      }));
  std::vector<MotionStatistics> out;
  for (std::size_t k = 0; k < kKinds.size(); ++k)
    out.push_back(mean_statistics(std::span(each).subspan(k * people, people),
                                  std::string(performer::block_name(kKinds[k]))));
  return out;
}

}  // namespace mien::lab
