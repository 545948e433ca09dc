#include "mien/media/phone_names.h"

#include <algorithm>
#include <array>
#include <span>

namespace mien::media {
namespace {

struct Phone {
  std::string_view name, ipa;
};
constexpr std::array kEnglish = {
    Phone{"aa", "ɑ"},  Phone{"ae", "æ"},  Phone{"ah", "ʌ"}, Phone{"ao", "ɔ"},  Phone{"aw", "aʊ"},
    Phone{"ax", "ə"},  Phone{"ay", "aɪ"}, Phone{"b", "b"},  Phone{"ch", "tʃ"}, Phone{"d", "d"},
    Phone{"dh", "ð"},  Phone{"eh", "ɛ"},  Phone{"er", "ɝ"}, Phone{"ey", "eɪ"}, Phone{"f", "f"},
    Phone{"g", "ɡ"},   Phone{"hh", "h"},  Phone{"ih", "ɪ"}, Phone{"iy", "i"},  Phone{"jh", "dʒ"},
    Phone{"k", "k"},   Phone{"l", "l"},   Phone{"m", "m"},  Phone{"n", "n"},   Phone{"ng", "ŋ"},
    Phone{"ow", "oʊ"}, Phone{"oy", "ɔɪ"}, Phone{"p", "p"},  Phone{"r", "ɹ"},   Phone{"s", "s"},
    Phone{"sh", "ʃ"},  Phone{"t", "t"},   Phone{"th", "θ"}, Phone{"uh", "ʊ"},  Phone{"uw", "u"},
    Phone{"v", "v"},   Phone{"w", "w"},   Phone{"y", "j"},  Phone{"z", "z"},   Phone{"zh", "ʒ"}};
/// Without their length and stress.
constexpr std::array kContinental = {
    Phone{"&", "æ"},  Phone{"@", "ø"},  Phone{"E", "ɛ"},   Phone{"J", "ɲ"},   Phone{"L", "ʎ"},
    Phone{"N", "ŋ"},  Phone{"O", "ɔ"},  Phone{"S", "ʃ"},   Phone{"T", "θ"},   Phone{"Z", "ʒ"},
    Phone{"a", "a"},  Phone{"b", "b"},  Phone{"c", "ts"},  Phone{"c~", "tʃ"}, Phone{"ch", "x"},
    Phone{"d", "d"},  Phone{"d~", "ɟ"}, Phone{"dZ", "dʒ"}, Phone{"dz", "dz"}, Phone{"dz~", "dʒ"},
    Phone{"e", "e"},  Phone{"f", "f"},  Phone{"g", "ɡ"},   Phone{"h", "h"},   Phone{"i", "i"},
    Phone{"j", "j"},  Phone{"k", "k"},  Phone{"l", "l"},   Phone{"m", "m"},   Phone{"n", "n"},
    Phone{"n*", "ŋ"}, Phone{"ng", "ŋ"}, Phone{"n~", "ɲ"},  Phone{"nf", "ɱ"},  Phone{"o", "o"},
    Phone{"p", "p"},  Phone{"r", "r"},  Phone{"r~", "r"},  Phone{"r~*", "r"}, Phone{"s", "s"},
    Phone{"s~", "ʃ"}, Phone{"t", "t"},  Phone{"t~", "c"},  Phone{"tS", "tʃ"}, Phone{"ts", "ts"},
    Phone{"u", "u"},  Phone{"v", "v"},  Phone{"w", "w"},   Phone{"x", "x"},   Phone{"y", "y"},
    Phone{"z", "z"},  Phone{"z~", "ʒ"}};
/// Without their softness, which the lips do not show.
constexpr std::array kRussian = {
    Phone{"a", "a"},  Phone{"aa", "a"},  Phone{"ae", "ɛ"}, Phone{"ay", "ʌ"}, Phone{"b", "b"},
    Phone{"c", "ts"}, Phone{"ch", "tʃ"}, Phone{"d", "d"},  Phone{"e", "e"},  Phone{"ee", "e"},
    Phone{"f", "f"},  Phone{"g", "ɡ"},   Phone{"h", "x"},  Phone{"i", "ɪ"},  Phone{"ii", "i"},
    Phone{"j", "j"},  Phone{"k", "k"},   Phone{"l", "l"},  Phone{"m", "m"},  Phone{"n", "n"},
    Phone{"oo", "o"}, Phone{"p", "p"},   Phone{"r", "r"},  Phone{"s", "s"},  Phone{"sch", "ʃ"},
    Phone{"sh", "ʃ"}, Phone{"t", "t"},   Phone{"u", "u"},  Phone{"ur", "ʊ"}, Phone{"uu", "u"},
    Phone{"v", "v"},  Phone{"y", "ɨ"},   Phone{"yy", "ɨ"}, Phone{"z", "z"},  Phone{"zh", "ʒ"}};

std::string_view find(std::span<const Phone> phones, std::string_view name) {
  const auto found = std::ranges::find(phones, name, &Phone::name);
  return found == phones.end() ? std::string_view() : found->ipa;
}

}  // namespace

std::string ipa_of(PhoneSet set, std::string_view phone) {
  if (set == PhoneSet::english) return std::string(find(kEnglish, phone));
  if (set == PhoneSet::continental)
    return std::string(find(kContinental, phone.substr(0, phone.find_first_of("0123456789:"))));
  const std::string_view ipa = find(kRussian, phone);
  const bool twice = phone.size() == 2 && phone[0] == phone[1];
  return std::string(ipa.empty() && twice ? find(kRussian, phone.substr(1)) : ipa);
}

}  // namespace mien::media
