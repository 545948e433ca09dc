#include "app/live/phones_beside.h"

#include <fmt/format.h>

#include "app/command.h"
#include "mien/phone/ifacialmocap.h"
#include "mien/phone/live_link.h"

namespace mien::app {
namespace {

/// So many at once are said in one sentence.
constexpr std::size_t kSeveralPhones = 3;
/// Who is heard has sent within so long.
constexpr Duration kHeard = std::chrono::seconds(2);

bool is_a_phones(const std::string& device) {
  const auto key = sensor::parse_device(device);
  if (!key) return false;
  const auto one_of = [&](std::uint64_t first, std::size_t most) {
    return key->device >= first && key->device < first + most;
  };
  return one_of(phone::kLiveLinkDevice, phone::kMostLiveLinkPhones) ||
         one_of(phone::kIFacialMocapDevice, phone::kMostIFacialMocapPhones);
}

}  // namespace

std::vector<std::string> PhonesBeside::tell(const session::Report& report) {
  std::vector<std::string> phones;
  for (const session::Report::Unbound& one : report.unbound) {
    if (!is_a_phones(one.device) || one.age > kHeard || !told_.insert(one.device).second) continue;
    phones.push_back(fmt::format("{} ({} from {})", one.device, one.protocol, one_line(one.source)));
  }
  const char* const what =
      "bind it to the phone's sensor on the page if it is the one that is meant, or end it";
  if (phones.size() >= kSeveralPhones)
    return {fmt::format("{} and {} phones more are heard that no sensor is bound to; {}", phones.front(),
                        phones.size() - 1, what)};
  for (std::string& phone : phones)
    phone = fmt::format("a phone is heard that no sensor is bound to, {}; {}", phone, what);
  return phones;
}

}  // namespace mien::app
