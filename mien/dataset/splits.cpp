#include "mien/dataset/splits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "mien/core/draw_first.h"
#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/core/nearest_word.h"
#include "mien/core/random.h"
#include "mien/core/toml.h"
#include "mien/core/utf8.h"

namespace mien::dataset {
namespace {

/// A number of people, by their share of all; one at least where it is not 0.
std::size_t people_of_share(double share, std::size_t all) {
  if (share == 0) return 0;
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(share * static_cast<double>(all))));
}

/// As TOML's basic strings have it, in ASCII. What is no UTF-8 becomes "?".
std::string toml_text(std::string_view text) {
  std::string out = "\"";
  while (!text.empty()) {
    const std::size_t length = utf8_letter(text);
    const char first = text.front();
    if (length == 0)
      out += '?';
    else if (length > 1)
      out += fmt::format("\\U{:08X}", static_cast<std::uint32_t>(code_point(text.substr(0, length))));
    else if (first == '"' || first == '\\')
      out += {'\\', first};
    else if (first < 0x20 || first == 0x7F)
      out += fmt::format("\\u{:04X}", static_cast<unsigned>(first));
    else
      out += first;
    text.remove_prefix(std::max<std::size_t>(1, length));
  }
  return out + '"';
}

/// A name in a message.
std::string quoted_name(std::string_view name) {
  return "\"" + excerpt(name, 60) + "\"";
}

}  // namespace

std::optional<Split> Splits::where(std::string_view person) const {
  for (std::size_t i = 0; i < people.size(); ++i)
    if (std::ranges::find(people[i], person) != people[i].end()) return static_cast<Split>(i);
  return std::nullopt;
}

Result<void> check_shares(const SplitShares& shares) {
  if (!(shares.validation >= 0 && shares.test >= 0 && shares.validation + shares.test < 1))
    return fail(
        ErrorCode::out_of_range,
        fmt::format("validation and test together are {} of the people", shares.validation + shares.test),
        "splits", "give two shares from 0 on that are less than 1 together");
  return {};
}

Result<Splits> draw_splits(std::vector<std::string> people, const SplitShares& shares, std::uint64_t seed) {
  MIEN_TRY(check_shares(shares));
  // Whoever lists them in another order draws the same.
  std::ranges::sort(people);
  Random random = Random(seed).fork("splits");
  draw_first(std::span(people), people.size(), random);
  std::size_t left = people.size();
  const auto draw = [&](double share) {
    const std::size_t count = std::min(people_of_share(share, people.size()), left > 0 ? left - 1 : 0);
    left -= count;
    std::vector<std::string> drawn(people.begin() + static_cast<std::ptrdiff_t>(left),
                                   people.begin() + static_cast<std::ptrdiff_t>(left + count));
    std::ranges::sort(drawn);
    return drawn;
  };
  Splits splits;
  splits.people[static_cast<std::size_t>(Split::validation)] = draw(shares.validation);
  splits.people[static_cast<std::size_t>(Split::test)] = draw(shares.test);
  people.resize(left);
  std::ranges::sort(people);
  splits.people[static_cast<std::size_t>(Split::train)] = std::move(people);
  return splits;
}

std::string write_splits(const Splits& splits, std::string_view comment) {
  std::string out = fmt::format("# {}\n[split]\n", comment);
  for (std::size_t i = 0; i < splits.people.size(); ++i) {
    out += fmt::format("{} = [", kSplitNames[i]);
    for (const std::string& person : splits.people[i]) out += "\n  " + toml_text(person) + ",";
    out += splits.people[i].empty() ? "]\n" : "\n]\n";
  }
  return out;
}

Result<Splits> parse_splits(std::string_view text, const std::string& where,
                            std::span<const std::string> known) {
  MIEN_TRY_ASSIGN(const toml::table table, parse_toml(text, where));
  MIEN_TRY(only_keys(table, {"split"}, where));
  const toml::table* const split = table["split"].as_table();
  if (split == nullptr)
    return fail(ErrorCode::malformed, "there is no table [split]", where,
                "have one written by mien dataset split");
  MIEN_TRY(only_keys(*split, {kSplitNames[0], kSplitNames[1], kSplitNames[2]}, where));
  Splits splits;
  std::map<std::string, std::string_view> seen;
  for (std::size_t i = 0; i < kSplitNames.size(); ++i) {
    const toml::node* const node = split->get(kSplitNames[i]);
    if (node == nullptr) continue;
    const toml::array* const names = node->as_array();
    if (names == nullptr)
      return fail(ErrorCode::malformed, fmt::format("{} is no list of names", kSplitNames[i]),
                  place(where, *node), "write it as [\"anna\", \"ben\"]");
    for (const toml::node& entry : *names) {
      const std::optional<std::string> name = entry.value<std::string>();
      if (!entry.is_string() || !name)
        return fail(ErrorCode::malformed, fmt::format("{} holds something that is no name", kSplitNames[i]),
                    place(where, entry), "write names between quotes");
      if (std::ranges::find(known, *name) == known.end())
        return fail(
            ErrorCode::not_found,
            fmt::format("{} has no take in the dataset{}", quoted_name(*name), did_you_mean(*name, known)),
            place(where, entry));
      if (const auto [before, fresh] = seen.emplace(*name, kSplitNames[i]); !fresh)
        return fail(ErrorCode::mismatch,
                    fmt::format("{} is in {} twice", quoted_name(*name),
                                before->second == kSplitNames[i]
                                    ? std::string(kSplitNames[i])
                                    : fmt::format("{} and in {}", before->second, kSplitNames[i])),
                    place(where, entry), "a person is in one set only");
      splits.people[i].push_back(*name);
    }
    std::ranges::sort(splits.people[i]);
  }
  return splits;
}

Result<Splits> read_splits(const std::filesystem::path& path, std::span<const std::string> known) {
  MIEN_TRY_ASSIGN(const std::string text, read_text(path, kMaxSplitsBytes));
  return parse_splits(text, path.string(), known);
}

Result<Split> split_of(const Splits& splits, const std::string& person, const std::string& where) {
  if (const std::optional<Split> split = splits.where(person)) return *split;
  return fail(ErrorCode::mismatch, fmt::format("{} is in none of the sets", quoted_name(person)), where,
              "put them into train, validation or test");
}

}  // namespace mien::dataset
