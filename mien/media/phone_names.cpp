#include "mien/media/phone_names.h"

#include <ranges>

namespace mien::media {
namespace {

// Names and their IPA.
constexpr std::string_view kEnglish =
    "aa=ɑ ae=æ ah=ʌ ao=ɔ aw=aʊ ax=ə ay=aɪ b=b ch=tʃ d=d dh=ð eh=ɛ er=ɝ ey=eɪ f=f g=ɡ hh=h ih=ɪ iy=i jh=dʒ "
    "k=k l=l m=m n=n ng=ŋ ow=oʊ oy=ɔɪ p=p r=ɹ s=s sh=ʃ t=t th=θ uh=ʊ uw=u v=v w=w y=j z=z zh=ʒ";
/// Without their length and stress.
constexpr std::string_view kContinental =
    "&=æ @=ø E=ɛ J=ɲ L=ʎ N=ŋ O=ɔ S=ʃ T=θ Z=ʒ a=a b=b c=ts c~=tʃ ch=x d=d d~=ɟ dZ=dʒ dz=dz dz~=dʒ e=e f=f "
    "g=ɡ h=h i=i j=j k=k l=l m=m n=n n*=ŋ ng=ŋ n~=ɲ nf=ɱ o=o p=p r=r r~=r r~*=r s=s s~=ʃ t=t t~=c tS=tʃ "
    "ts=ts u=u v=v w=w x=x y=y z=z z~=ʒ";
/// Without their softness, which the lips do not show.
constexpr std::string_view kRussian =
    "a=a aa=a ae=ɛ ay=ʌ b=b c=ts ch=tʃ d=d e=e ee=e f=f g=ɡ h=x i=ɪ ii=i j=j k=k l=l m=m n=n oo=o p=p r=r "
    "s=s sch=ʃ sh=ʃ t=t u=u ur=ʊ uu=u v=v y=ɨ yy=ɨ z=z zh=ʒ";

std::string_view find(std::string_view phones, std::string_view name) {
  for (const auto entry : phones | std::views::split(' ')) {
    const std::string_view phone(entry.begin(), entry.end());
    if (phone.starts_with(name) && phone.substr(name.size()).starts_with('='))
      return phone.substr(name.size() + 1);
  }
  return {};
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
