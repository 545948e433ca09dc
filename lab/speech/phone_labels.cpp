#include "lab/speech/phone_labels.h"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <string>

#include "mien/core/excerpt.h"

namespace mien::lab {
namespace {

using PhoneJson = nlohmann::json;

constexpr double kLongest_s = 3600;

bool is_bilabial(std::string_view phone) {
  return phone == "P" || phone == "B" || phone == "M" || phone == "p" || phone == "b" || phone == "m";
}

Result<void> add(std::string_view phone, double begin_s, double end_s, const std::string& where,
                 std::vector<synthetic::Closure>& closures) {
  if (!(begin_s >= 0 && end_s >= begin_s && end_s <= kLongest_s) ||
      (!closures.empty() && begin_s < closures.back().begin_s))
    return fail(ErrorCode::out_of_range,
                fmt::format("the phone {} is from {} to {} s", excerpt(phone), begin_s, end_s), where);
  if (is_bilabial(phone)) closures.push_back({begin_s, end_s});
  return {};
}

/// Leaves are phones.
Result<void> walk(const PhoneJson& node, int depth, const std::string& where,
                  std::vector<synthetic::Closure>& closures) {
  constexpr int kDeepest = 8;
  if (!node.is_object() || depth > kDeepest)
    return fail(ErrorCode::malformed, "no alignment: neither objects of b, d, t and w nor HTK's lines",
                where);
  if (const auto parts = node.find("w"); parts != node.end() && parts->is_array()) {
    for (const PhoneJson& part : *parts) MIEN_TRY(walk(part, depth + 1, where, closures));
    return {};
  }
  const auto begin = node.find("b"), length = node.find("d"), text = node.find("t");
  if (begin == node.end() || length == node.end() || text == node.end() || !begin->is_number() ||
      !length->is_number() || !text->is_string())
    return fail(ErrorCode::malformed, "a phone lacks its b, d or t", where);
  const auto begin_s = begin->get<double>();
  return add(text->get_ref<const std::string&>(), begin_s, begin_s + length->get<double>(), where, closures);
}

/// What stands before the next blank; leaves the rest.
std::string_view next_word(std::string_view& line) {
  const std::size_t begin = std::min(line.find_first_not_of(" \t\r"), line.size());
  const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

/// Units of 100 ns.
bool read_time(std::string_view word, double& seconds) {
  std::int64_t units = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), units);
  seconds = 1e-7 * static_cast<double>(units);
  return code == std::errc() && end == word.data() + word.size();
}

}  // namespace

Result<std::vector<synthetic::Closure>> parse_phone_labels(std::string_view text,
                                                           std::string_view where_view) {
  const std::string where(where_view);
  std::vector<synthetic::Closure> closures;
  if (const std::size_t first = text.find_first_not_of(" \t\r\n");
      first < text.size() && text[first] == '{') {
    const PhoneJson root = PhoneJson::parse(text, nullptr, false);
    if (root.is_discarded()) return fail(ErrorCode::malformed, "it is no JSON", where);
    MIEN_TRY(walk(root, 0, where, closures));
    return closures;
  }
  std::size_t number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::string place = fmt::format("{}, line {}", where, number);
    const std::string_view begin_word = next_word(line), end_word = next_word(line);
    std::string_view label = next_word(line);
    if (begin_word.empty()) continue;
    double begin_s = 0, end_s = 0;
    if (!read_time(begin_word, begin_s) || !read_time(end_word, end_s) || label.empty())
      return fail(ErrorCode::malformed, "no line of HTK's labels: begin, end, label", place);
    if (const std::size_t minus = label.find('-'), plus = label.find('+', std::min(minus, label.size()));
        minus < label.size() && plus < label.size())
      label = label.substr(minus + 1, plus - minus - 1);
    MIEN_TRY(add(label, begin_s, end_s, place, closures));
  }
  return closures;
}

}  // namespace mien::lab
